"""Vehicles of which a detector boxes a part for a while: they have not moved away for it.

To a filter whose vehicles keep their width, one that is boxed in part falls back at once, and jumps towards
us when the whole of it is boxed again. So a width far below the one expected is left out; where the next one
is too, that part of the vehicle is boxed from then on, until a width fits the whole of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.tracking.association import OFF_SIGMAS
from fcw.tracking.box_measurement import BUMP, CAMERA, HEIGHT, VEHICLE, WIDTH, Measurements

STANDS_ASTRAY_SIGMAS = 3.0
"""What seems to stand so far off the road is elsewhere: then it is right that its width does not fit."""


class News(Enum):
    """What the latest box says of the part of its vehicle that is boxed."""

    NONE = auto()
    """As much is boxed as before."""
    UNSURE = auto()
    """It may be less, or this box is a wild one."""
    OTHER = auto()
    """Another part is boxed, or all of it again."""


@dataclass(slots=True)
class BoxedPart:
    """How much of one vehicle's width is boxed.

    Attributes:
        log_part: logarithm of that part, at most 0.
        news: of the latest box.
        was_off: whether the last width that was seen was too small.
    """

    log_part: float = 0.0
    news: News = News.NONE
    was_off: bool = False


def judge_widths(
    seen: Measurements,
    x: FloatArray,
    p: FloatArray,
    white: float,
    slots: Sequence[int],
    parts: Sequence[BoxedPart],
) -> Measurements:
    """The measurements without the widths of which it is not known how much of a vehicle they are.

    Args:
        seen: of one frame.
        x: (N,) state of the range filter.
        p: (N, N) its covariance.
        white: factor on the variances, see `BoxNoise.white`.
        slots: numbers in the filter of the vehicles that were seen.
        parts: of all vehicles; what is learnt of them is written there.
    """
    residuals, keep = seen.residuals.copy(), np.ones(len(seen.residuals), bool)

    def is_usual(index: int, residual: float) -> bool:
        row, noise = seen.rows[index], seen.variances[index] / white
        sigmas2 = (residual / OFF_SIGMAS) ** 2
        return bool(sigmas2 <= noise or sigmas2 <= noise + row @ p @ row)

    for part in parts:
        part.news = News.NONE
    for slot, view in zip(slots, seen.views, strict=True):
        at, part = CAMERA + VEHICLE * slot, parts[slot]
        widths = np.flatnonzero(seen.rows[:, at + WIDTH])
        if not len(widths):
            continue
        index = int(widths[0])
        residual = float(residuals[index])
        if is_usual(index, residual) or (residual > 0 and not part.log_part):
            part.was_off = False
            continue
        feet = np.flatnonzero((seen.rows[:, at + BUMP] != 0) & (seen.rows[:, at + HEIGHT] == 0))
        astray = abs(x[at + BUMP]) > STANDS_ASTRAY_SIGMAS * view.bump_sigma_px
        if astray or not all(is_usual(int(foot), float(residuals[foot])) for foot in feet):
            part.was_off = False
        elif part.log_part and is_usual(index, residual + part.log_part):
            residuals[index] += part.log_part
            part.log_part, part.news, part.was_off = 0.0, News.OTHER, False
        else:
            keep[index] = False
            part.news = News.OTHER if part.was_off else News.UNSURE
            if part.was_off:
                part.log_part = min(part.log_part + residual, 0.0)
            part.was_off = not part.was_off
    return Measurements(seen.rows[keep], residuals[keep], seen.variances[keep], seen.common[keep], seen.views)
