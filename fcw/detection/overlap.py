"""Overlaps of boxes given as arrays of (x, y, w, h)."""

import numpy as np
from numpy.typing import NDArray


def intersection_areas(boxes: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Common area of each box with each other one: (N, 4) and (M, 4) give (N, M), in square pixels."""
    corner, other_corner = boxes[:, None, :2], others[None, :, :2]
    far, other_far = corner + boxes[:, None, 2:], other_corner + others[None, :, 2:]
    sides = np.minimum(far, other_far) - np.maximum(corner, other_corner)
    return np.prod(np.maximum(sides, 0.0), axis=2)


def intersection_over_union(boxes: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """IoU of each box with each other one: (N, 4) and (M, 4) give (N, M); areas must be positive."""
    common = intersection_areas(boxes, others)
    return common / (np.prod(boxes[:, 2:], axis=1)[:, None] + np.prod(others[:, 2:], axis=1) - common)
