"""Overlaps of boxes given as arrays of (x, y, w, h), with each other and with the picture."""

import numpy as np
from numpy.typing import NDArray

from fcw.frame import ImageSize
from fcw.kernels.inner import inner_kernel


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


def vehicle_overlap(
    boxes: NDArray[np.float64],
    vehicles: NDArray[np.float64],
    rear_boxes: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """How well boxes show vehicles: IoU with the whole vehicle or with its rear face, whichever is larger.

    Args:
        boxes: (N, 4).
        vehicles: (M, 4) boxes of whole vehicles.
        rear_boxes: (M, 4) of their rear faces, NaN in the rows of those that have none; None: none has one.

    Returns:
        (N, M).
    """
    overlap = intersection_over_union(boxes, vehicles)
    if rear_boxes is not None:
        known = ~np.isnan(rear_boxes[:, 0])
        overlap[:, known] = np.maximum(overlap[:, known], intersection_over_union(boxes, rear_boxes[known]))
    return overlap


def cut_to_picture(boxes: NDArray[np.float64], size: ImageSize) -> NDArray[np.float64]:
    """The parts of boxes that lie in the picture, whose edges are half a pixel outside its outer pixels."""
    parts = np.array(boxes, np.float64, order="C").reshape(-1, 4)
    for part in parts:
        cut(part, size.width - 0.5, size.height - 0.5)
    return parts


@inner_kernel(from_python=True)
def cut(box: NDArray[np.float64], right: float, bottom: float) -> None:
    """Cut a box to the picture whose right and bottom edges these are, in place."""
    x, y = max(box[0], -0.5), max(box[1], -0.5)
    box[2], box[3] = min(box[0] + box[2], right) - x, min(box[1] + box[3], bottom) - y
    box[0], box[1] = x, y
