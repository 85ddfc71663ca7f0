"""Vehicles of which the detector boxes only a part for a while, which must not look like motion.

The filter assumes that vehicles keep their width. So a vehicle that is boxed in part would seem to fall back,
and to jump towards us when it is boxed as a whole again. Therefore a width far below the expected one is left
out. If the next width is also too small, that part of the vehicle is taken to be boxed from then on, until a
width fits the whole vehicle again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.tracking.association import OFF_SIGMAS
from fcw.tracking.box_measurement import BUMP, CAMERA, HEIGHT, VEHICLE, WIDTH, Measurements

STANDS_ASTRAY_SIGMAS = 3.0
"""A vehicle that seems to stand this far off the road is elsewhere, and its width is right not to fit."""


class News(Enum):
    """What the latest box tells about the part of its vehicle that is boxed."""

    NONE = auto()
    """The same part is boxed as before."""
    UNSURE = auto()
    """A smaller part may be boxed, or this box is an outlier."""
    OTHER = auto()
    """Another part is boxed, or the whole vehicle again."""


@dataclass(slots=True)
class BoxedPart:
    """How much of one vehicle's width is boxed.

    Attributes:
        log_part: logarithm of the boxed fraction of the width, at most 0.
        news: what the latest box tells.
        was_off: whether the last measured width was too small.
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
    """The measurements without widths that may be those of only a part of a vehicle.

    Args:
        seen: the measurements of one frame.
        x: (N,) state of the range filter.
        p: (N, N) covariance of the state.
        white: factor on the variances; see `BoxNoise.white`.
        slots: indices in the filter of the vehicles that were seen.
        parts: the boxed parts of all vehicles, which are updated in place.
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
