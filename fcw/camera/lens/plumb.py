"""How much lines that are straight in the world bend in the picture."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FEWEST_LINE_POINTS = 5
"""Least number of points along a line that shows the distortion of the lens."""
BENT_PX = 3.0
"""A line that bends by more than this shows distortion, or is not straight in the world."""


def bend_px(line: Sequence[tuple[float, float]]) -> float:
    """Root mean square distance of a line's points from the straight line through them."""
    return math.sqrt(float(np.mean(bows_px(np.array(line, float)) ** 2)))


def bows_px(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) distances of (N, 2) places from the straight line through them."""
    centred = places - places.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    return centred @ axes[1]
