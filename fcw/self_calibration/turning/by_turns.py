"""The focal length and the distortion of a lens, from the turns of a clip.

A straight drive does not show the lens: with another one, everything is only nearer or farther. A turn moves
the picture aside by the focal length times the angle, and places at the sides by an additional amount that
depends on the angle over the focal length. If the depths are known, from how they change over some seconds of
stronger and weaker turning, both effects together give the focal length and the angle. On a circle they do
not, however many pictures there are (Sturm 1999). So each turn gives a result with its uncertainty, and the
additional error of each is estimated from how much the turns differ.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.lens.model import Lens
from fcw.frame import ImageSize
from fcw.motion.travel.tracks import PointTracks
from fcw.self_calibration.turning.bundle import Bundle, Told
from fcw.self_calibration.turning.lens import PlainLens
from fcw.self_calibration.turning.windows import HOP_S, LENGTH_S, TurningWindow, turning_windows

VIEWS_DEG = (45.0, 60.0, 75.0, 90.0, 110.0)
"""Fields of view at which the fit starts."""
ROUGH_PLAN = ((8.0, 3), (3.0, 4), (1.2, 8))
FINE_PLAN = ((1.0, 60),)
LEAST_INLYING = 0.55
"""Least mean weight of a window's points; with less, they are traffic, rain or reflections."""
LARGEST_SIGMA = 0.5
FEWEST_WINDOWS = 2
"""A single window does not show how much windows differ."""
TRUSTED_BEND = (-0.42, 0.18)
"""A bend outside this range is at the limit of the search, and is not used."""
STRAIGHT_BEND = -0.18
"""Windows with a larger bend count as those of a straight picture, because few windows show a bend well."""
SAME_BEND = 0.05
"""Windows of one lens with distortion differ by less than this; those of a wide dash camera by 0.01."""
LEAST_BENT = 0.08
"""A picture counts as straight if the lens moves its sides towards the middle by a smaller part than this."""
WINDOW_SIGMA = 0.15
"""Relative error of the focal length of each window; those of KITTI odometry 03 differ by 0.12."""
COMMON_SIGMA = 0.08
"""Relative error that all windows of a clip share: the axis is not in the middle, the lens is not quite of
the family, or the shutter rolls."""
HUBER_SIGMAS = 1.5
ROUNDS = 12
WIDENED_BY = 1.15


@dataclass(frozen=True, slots=True)
class LensByTurns:
    """What the turns of a clip show about its lens.

    Attributes:
        focal_px: focal length in pixels of the whole picture.
        bend: see `PlainLens`; None if the picture is straight enough.
    """

    focal_px: Gaussian
    bend: float | None = None

    def bent_lens(self, size: ImageSize) -> Lens | None:
        """The lens, assuming that its axis is in the middle; None if the picture is straight enough.

        Args:
            size: size of the whole picture.
        """
        if self.bend is None:
            return None
        axis_px = (size.width - 1) / 2, (size.height - 1) / 2
        return PlainLens(self.focal_px.value, self.bend, axis_px).fisheye(size)


def lens_by_turns(tracks: PointTracks) -> LensByTurns | None:
    """The lens from the turns of a clip; None if it does not turn enough.

    Args:
        tracks: points followed through the clip.
    """
    size = tracks.size
    windows = [lens_of_window(window, size) for window in turning_windows(tracks.pictures, size[0])]
    together = agreed_lens([told for told in windows if told is not None], size[0])
    if together is None:
        return None
    focal_px = together.focal_px
    return replace(
        together, focal_px=Gaussian(focal_px.value * tracks.factor, focal_px.sigma * tracks.factor)
    )


def agreed_lens(windows: Sequence[Told], width_px: int) -> LensByTurns | None:
    """The lens from all windows; None if they are too few, or most show a bend but not the same one.

    Args:
        windows: the result of each window.
        width_px: width of their pictures.
    """
    bends = np.array([told.bend.value for told in windows])
    bend = float(np.median(bends[bends < STRAIGHT_BEND])) if (bends < STRAIGHT_BEND).any() else 0.0
    bent = [told for told in windows if abs(told.bend.value - bend) < SAME_BEND]
    straight = [told for told in windows if told.bend.value >= STRAIGHT_BEND]
    together = agreed_focal(straight if len(straight) >= len(bent) else bent)
    if together is None:
        return None
    focal_px = math.exp(together.value)
    shows = len(bent) > len(straight) and -bend * (width_px / 2 / focal_px) ** 2 >= LEAST_BENT
    return LensByTurns(Gaussian(focal_px, together.sigma * focal_px), bend if shows else None)


def lens_of_window(window: TurningWindow, size: tuple[int, int]) -> Told | None:
    """The result of one window; None if its points do not belong to one rigid world.

    Args:
        window: some seconds of the clip.
        size: width and height of the small pictures.
    """
    best: tuple[float, Bundle] | None = None
    for view_deg in VIEWS_DEG:
        focal_px = size[0] / 2 / math.tan(math.radians(view_deg) / 2)
        try:
            bundle = Bundle(window.times_s, window.places, size, focal_px)
            cost = bundle.fit(ROUGH_PLAN, focal_open=False).cost
        except np.linalg.LinAlgError:
            continue
        if best is None or cost < best[0]:
            best = cost, bundle
    if best is None:
        return None
    try:
        told = best[1].fit(FINE_PLAN, focal_open=True)
    except np.linalg.LinAlgError:
        return None
    low, high = TRUSTED_BEND
    inside = low < told.bend.value < high
    tells = inside and told.inlying >= LEAST_INLYING and told.log_focal.sigma < LARGEST_SIGMA
    return told if tells else None


def agreed_focal(windows: Sequence[Told]) -> Gaussian | None:
    """The logarithm of the focal length from all windows; None for fewer than `FEWEST_WINDOWS`.

    Windows differ by more than pixel noise explains. The excess is estimated together with the mean
    (DerSimonian & Laird 1986), and windows far from the others count less (Huber 1964). Windows overlap, and
    therefore the result is less certain than their number suggests.
    """
    if len(windows) < FEWEST_WINDOWS:
        return None
    values = np.array([told.log_focal.value for told in windows])
    variances = np.array([told.log_focal.sigma for told in windows]) ** 2
    mean, own = float(np.median(values)), WINDOW_SIGMA
    weights = 1 / (variances + own**2)
    for _ in range(ROUNDS):
        weights = 1 / (variances + own**2)
        for _ in range(ROUNDS):
            off = np.abs(values - mean) * np.sqrt(weights)
            robust = weights * np.minimum(1.0, HUBER_SIGMAS / np.maximum(off, 1e-9))
            mean = float((robust * values).sum() / robust.sum())
        if (weights * (values - mean) ** 2).sum() <= len(values) - 1:
            break
        own *= WIDENED_BY
    return Gaussian(mean, math.hypot(COMMON_SIGMA, math.sqrt(LENGTH_S / HOP_S / weights.sum())))
