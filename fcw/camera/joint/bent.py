"""Whether a picture is bent by its lens though no lens was given: its lines bow, or its marks lie as no
straight picture has them."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.fit import JointFit, solved
from fcw.camera.joint.known import Known
from fcw.camera.lens.model import Lens
from fcw.errors import UserError

FEWEST_PLACES = 5
"""Of marks with columns, or along an edge; fewer tell nothing of a lens."""
ASIDE_PART = 0.1
"""Of the picture's width: marks nearer to one column tell nothing either."""
WIDE_BEND = Gaussian(-0.2, 0.15)
"""k1 of lenses whose picture nobody straightened: Udacity's -0.24, KITTI's raw ones -0.37, phones near 0."""
BENT_ODDS = 30.0
"""From which it is spoken of: even odds before, and about one straight picture accused in as many."""
SCORE_TOLERANCE = 1e-10
LEAST_BEND_PX = 3.0
"""At the picture's corners; less changes no distance that matters."""


@dataclass(frozen=True, slots=True)
class BentPicture:
    """A lens that explains better what was said than a picture free of distortion does.

    Attributes:
        lens: as it comes out.
        corner_px: how far it moves the picture's corners.
        odds: how much better it explains it.
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
    """The lens that bends the picture, where that is clearly likelier than a straight one; else None.

    Lane lines by their two ends tell nothing: along the road they run to the picture's middle, and a lens
    bends such lines least. Edges across tell, and marks beside each other in several columns.

    Both are scored by what was said under them, the unknowns integrated out (Laplace), so that a lens that
    merely may fit better does not win.

    Args:
        known: what is known; its lens and bend do not count.
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
        # A lens wins no more than the misfit that it takes away: where that is little, none is looked for.
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
