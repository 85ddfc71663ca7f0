"""How a set of points has moved and grown, when some of them have been followed wrongly.

Points of a flat rear move by a shift and a scale. Two points give both; of many pairs the one that most
points agree with is taken (Fischler & Bolles 1981), and refined by least squares over those that agree, whose
scatter says how well the scale is known.
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
    """The scale and shift of the pair that most points agree with; every point is paired with three others.

    By the sum of what is off, up to the tolerance: among pairs with as many points the closer one wins.
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
    """The best scale and shift of the points that agree with these: how many they are, both, and two sums.

    The sums are of the squares of what is left between them, and of their distances from their middle. The
    scale is 0 where it cannot be told.
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
