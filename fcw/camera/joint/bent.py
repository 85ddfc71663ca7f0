"""Finds out whether the lens bends a picture though no lens was given: by bent lines, or by its marks."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.fit import JointFit, solved
from fcw.camera.joint.known import Known
from fcw.camera.lens.model import Lens
from fcw.errors import UserError

FEWEST_PLACES = 5
"""Least number of marks with columns, or of places along an edge; fewer show nothing of a lens."""
ASIDE_PART = 0.1
"""Least spread of the marks' columns, as a part of the picture's width; less shows nothing either."""
WIDE_BEND = Gaussian(-0.2, 0.15)
"""k1 of lenses whose picture nobody straightened: Udacity's -0.24, KITTI's raw ones -0.37, phones near 0."""
BENT_ODDS = 30.0
"""Least odds at which it is reported. With even prior odds, about one straight picture in so many is
reported wrongly."""
SCORE_TOLERANCE = 1e-10
LEAST_BEND_PX = 3.0
"""Least shift of the picture's corners; a smaller one changes no distance noticeably."""


@dataclass(frozen=True, slots=True)
class BentPicture:
    """A lens with distortion that explains the input better than a lens without.

    Attributes:
        lens: the fitted lens.
        corner_px: how far it moves the corners of the picture.
        odds: how much better it explains the input.
    """

    lens: Lens
    corner_px: float
    odds: float

    @property
    def text(self) -> str:
        """What is wrong, in one sentence."""
        return (
            f"the lens bends this picture: the clicks fit a lens with k1 {self.lens.coefficients[0]:.2f}, "
            f"which moves the corners by {self.corner_px:.0f} px, far better than a picture free of "
            "distortion"
        )


def bent_picture(known: Known) -> BentPicture | None:
    """The lens that bends the picture, if it is clearly likelier than one without distortion; else None.

    Lane lines given by two ends show nothing: they run to the middle of the picture, and a lens bends such
    lines least. Edges across the road show it, and so do marks side by side in several columns.

    Each of the two is scored by the probability of the input with the unknowns integrated out (Laplace), so
    that the lens with more freedom does not win merely because it can fit better.

    Args:
        known: what is known; its lens and bend are not used.
    """
    evidence = known.evidence
    columns_px = [point.column_px for point in evidence.points if point.column_px is not None]
    aside = len(columns_px) >= FEWEST_PLACES and np.ptp(columns_px) > ASIDE_PART * known.image_size.width
    if not (evidence.edges or aside):
        return None

    straight = replace(known, lens=None, bend=None)
    plain, bent = JointFit(straight), JointFit(replace(straight, bend=WIDE_BEND))
    try:
        plain_x, plain_covariance = solved(straight)
        misfits = plain.residuals(plain_x)
        # A lens cannot gain more than the misfit that it removes; if that is small, none is fitted.
        if misfits @ misfits / 2 <= math.log(BENT_ODDS):
            return None
        x, covariance = bent.solve(SCORE_TOLERANCE)
        log_odds = bent.log_evidence(x, covariance) - plain.log_evidence(plain_x, plain_covariance)
    except (UserError, np.linalg.LinAlgError):
        return None
    lens = bent.lens(x)
    if lens is None or not log_odds > math.log(BENT_ODDS):
        return None
    ray = np.array([[-lens.column_px / lens.focal_x_px, -lens.row_px / lens.focal_y_px]])
    corner_px = float(np.abs(lens.distorted(ray)).max())
    if corner_px < LEAST_BEND_PX:
        return None
    return BentPicture(lens, corner_px, math.exp(min(log_odds, 700.0)))
