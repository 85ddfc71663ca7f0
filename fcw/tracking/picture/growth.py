"""Shift and growth of a set of points, some of which were tracked wrongly.

The points of a flat rear move by a shift and a scale. Two points determine both. Of many pairs, the one that
most points agree with is taken (Fischler & Bolles 1981) and refined by least squares over the points that
agree. Their scatter tells how well the scale is known.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.jit import kernel

FEWEST_POINTS = 6

Points = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Growth:
    """after = scale * before + shift, points as complex numbers x + iy.

    Attributes:
        scale: factor of growth.
        shift: shift of the origin.
        log_scale_sigma: 1-sigma of the log scale, from the scatter of the points that agree.
        agree: number of points that agree.
    """

    scale: float
    shift: complex
    log_scale_sigma: float
    agree: int


def fit_growth(before: Points, after: Points, tolerance_px: float) -> Growth | None:
    """The shift and scale that most points agree on; None if fewer than `FEWEST_POINTS` do.

    Args:
        before: (N,) points x + iy.
        after: (N,) the same points after the motion.
        tolerance_px: a point agrees if it is off by no more than this.
    """
    if len(before) < FEWEST_POINTS:
        return None
    scale, shift = _of_most_pairs(before, after, tolerance_px)
    _, scale, shift, _, _ = _least_squares(before, after, tolerance_px, scale, shift)
    if scale <= 0:
        return None
    count, scale, shift, left, spread = _least_squares(before, after, tolerance_px, scale, shift)
    if scale <= 0:
        return None
    log_scale_sigma = math.sqrt(left / (2 * count - 3)) / math.sqrt(spread) / scale
    return Growth(scale, shift, log_scale_sigma, count)


@kernel()
def _of_most_pairs(before: Points, after: Points, tolerance_px: float) -> tuple[float, complex]:
    """The scale and shift of the pair with the least total error; every point is paired with three others.

    The error of a point counts up to the tolerance. So among pairs that as many points agree with, the
    closest fit wins.
    """
    count = len(before)
    least, best_scale, best_shift = np.inf, 1.0, 0j
    for stride in (count // 2, count // 3, 1):
        for first in range(count):
            second = (first + stride) % count
            apart = abs(before[first] - before[second])
            scale = abs(after[first] - after[second]) / max(apart, 1e-9)
            shift = (after[first] + after[second] - scale * (before[first] + before[second])) / 2
            total = 0.0
            for i in range(count):
                off = after[i] - scale * before[i] - shift
                total += min(math.sqrt(off.real * off.real + off.imag * off.imag), tolerance_px)
            if total < least:
                least, best_scale, best_shift = total, scale, shift
    return best_scale, best_shift


@kernel()
def _least_squares(
    before: Points, after: Points, tolerance_px: float, scale: float, shift: complex
) -> tuple[int, float, complex, float, float]:
    """Least squares over the points that agree with a scale and shift.

    Returns:
        Number of points that agree, scale, shift, sum of squared residuals, and sum of the squared distances
        of the points from their mean. The scale is 0 if it cannot be determined.
    """
    agree = np.empty(len(before), np.bool_)
    count, middle, middle_after = 0, 0j, 0j
    for i in range(len(before)):
        agree[i] = abs(after[i] - scale * before[i] - shift) <= tolerance_px
        if agree[i]:
            count, middle, middle_after = count + 1, middle + before[i], middle_after + after[i]
    if count < FEWEST_POINTS:
        return count, 0.0, 0j, 0.0, 0.0
    middle, middle_after = middle / count, middle_after / count
    spread = along = 0.0
    for i in range(len(before)):
        if agree[i]:
            arm, moved = before[i] - middle, after[i] - middle_after
            spread += arm.real * arm.real + arm.imag * arm.imag
            along += arm.real * moved.real + arm.imag * moved.imag
    if spread <= 0.0 or along <= 0.0:
        return count, 0.0, 0j, 0.0, 0.0
    scale, left = along / spread, 0.0
    for i in range(len(before)):
        if agree[i]:
            off = after[i] - middle_after - scale * (before[i] - middle)
            left += off.real * off.real + off.imag * off.imag
    return count, scale, middle_after - scale * middle, left, spread
