"""What the turns of a clip tell of the lens: its focal length, and how much it bends straight lines.

Driving straight shows none: with another lens all things are as much nearer or farther. A turn moves the
picture aside by the focal length times the angle, and what lies to the sides besides by the angle over the
focal length. Where the depths are known, from how they change over some seconds in which the car turns more
and less, the two tell both. On a circle they do not, whatever the number of pictures (Sturm 1999): so each
turn tells what it tells, and what the turns have for themselves is taken from how they differ.
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
"""Fields of view to start with."""
ROUGH_PLAN = ((8.0, 3), (3.0, 4), (1.2, 8))
FINE_PLAN = ((1.0, 60),)
LEAST_INLYING = 0.55
"""A window whose points keep less to one rigid world shows traffic, rain or reflections."""
LARGEST_SIGMA = 0.5
FEWEST_WINDOWS = 2
"""How far windows differ is not seen in one."""
TRUSTED_BEND = (-0.42, 0.18)
"""What comes out beside it is at the end of what is looked for."""
STRAIGHT_BEND = -0.18
"""Windows above it count together as those of a straight picture, whatever their bends: few tell it well."""
SAME_BEND = 0.05
"""Windows of one bent lens differ by less: those of a wide dash camera by 0.01."""
LEAST_BENT = 0.08
"""A picture whose side a lens brings nearer to the middle by a smaller part is straight enough."""
WINDOW_SIGMA = 0.15
"""Of each window for itself, as a part of the focal length: those of KITTI odometry 03 differ by 0.12."""
COMMON_SIGMA = 0.08
"""Of all windows of a clip: an axis off the middle, what the family leaves of the lens, a rolling shutter."""
HUBER_SIGMAS = 1.5
ROUNDS = 12
WIDENED_BY = 1.15


@dataclass(frozen=True, slots=True)
class LensByTurns:
    """What the turns of a clip tell of its lens.

    Attributes:
        focal_px: focal length in pixels of the whole picture.
        bend: see `PlainLens`; None of a picture that is straight enough.
    """

    focal_px: Gaussian
    bend: float | None = None

    def bent_lens(self, size: ImageSize) -> Lens | None:
        """The lens, whose axis is taken to be in the middle; None of a picture that is straight enough.

        Args:
            size: of the whole picture.
        """
        if self.bend is None:
            return None
        axis_px = (size.width - 1) / 2, (size.height - 1) / 2
        return PlainLens(self.focal_px.value, self.bend, axis_px).fisheye(size)


def lens_by_turns(tracks: PointTracks) -> LensByTurns | None:
    """The lens by the turns of a clip; None where it does not turn enough to tell.

    Args:
        tracks: of the clip.
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
    """The lens by all windows; None of too few, or where most show a bent picture but not the same bend.

    Args:
        windows: what each tells.
        width_px: of their pictures.
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
    """What one window tells; None where its points are not of one rigid world.

    Args:
        window: some seconds.
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
    """The logarithm of the focal length by all windows; None of fewer than `FEWEST_WINDOWS`.

    Windows differ by more than pixel noise makes them. By how much is found with the mean (DerSimonian &
    Laird 1986), and windows far from the others count less (Huber 1964). Windows overlap, and tell so much
    less.
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
