"""How far lines bow that are straight in the world."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FEWEST_LINE_POINTS = 5
"""Along a line that is to show how the lens bends."""
BENT_PX = 3.0
"""A line that bends by more than this was bent by the lens, or is not straight."""


def bend_px(line: Sequence[tuple[float, float]]) -> float:
    """How far the points of a line lie off a straight one, root mean square."""
    return math.sqrt(float(np.mean(bows_px(np.array(line, float)) ** 2)))


def bows_px(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) distances of (N, 2) places from their straight line."""
    centred = places - places.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    return centred @ axes[1]
