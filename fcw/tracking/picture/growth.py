"""How a set of points has moved and grown, when some of them have been followed wrongly.

Points of a flat rear move by a shift and a scale. Two points give both; of many pairs the one that most
points agree with is taken (Fischler & Bolles 1981), and refined by least squares over those that agree, whose
scatter says how well the scale is known.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

FEWEST_POINTS = 6

Points = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Growth:
    """after = scale * before + shift, points as complex numbers x + iy.

    Attributes:
        scale: 1 is no change.
        shift: of a point at the origin.
        log_scale_sigma: 1-sigma of the logarithm of the scale, by the scatter of the points that agree.
        agree: how many points do.
    """

    scale: float
    shift: complex
    log_scale_sigma: float
    agree: int


def fit_growth(before: Points, after: Points, tolerance_px: float) -> Growth | None:
    """The shift and scale most points agree on; None where fewer than six do.

    Args:
        before: (N,) points x + iy.
        after: (N,) where they went.
        tolerance_px: a point agrees when it is not farther off than this.
    """
    if len(before) < FEWEST_POINTS:
        return None
    first, second = _pairs(len(before))
    apart = np.abs(before[first] - before[second])
    scales = np.abs(after[first] - after[second]) / np.maximum(apart, 1e-9)
    shifts = (after[first] + after[second] - scales * (before[first] + before[second])) / 2
    off = np.abs(after - scales[:, None] * before - shifts[:, None])
    # Less the sum of what is off, up to the tolerance: among pairs with as many points the closer one wins.
    best = np.minimum(off, tolerance_px).sum(axis=1).argmin()
    agrees = off[best] <= tolerance_px
    rough = _least_squares(before[agrees], after[agrees])
    if rough is None:
        return None
    agrees = np.abs(after - rough.scale * before - rough.shift) <= tolerance_px
    return _least_squares(before[agrees], after[agrees])


def _least_squares(before: Points, after: Points) -> Growth | None:
    count = len(before)
    if count < FEWEST_POINTS:
        return None
    middle, middle_after = before.sum() / count, after.sum() / count
    arms, moved = before - middle, after - middle_after
    spread = float(np.vdot(arms, arms).real)
    scale = float(np.vdot(arms, moved).real) / spread if spread > 0 else 0.0
    if scale <= 0:
        return None
    left = moved - scale * arms
    sigma_px = math.sqrt(float(np.vdot(left, left).real) / (2 * count - 3))
    shift = complex(middle_after - scale * middle)
    return Growth(scale, shift, sigma_px / math.sqrt(spread) / scale, count)


@cache
def _pairs(count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of the points that are paired, every one with three others."""
    strides = [count // 2, count // 3, 1]
    first = np.tile(np.arange(count), len(strides))
    second = (first + np.repeat(strides, count)) % count
    return first, second
