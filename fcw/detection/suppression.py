"""Of the windows that one vehicle lights up: the best one, and the box that they agree on."""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.overlap import intersection_over_union


def suppress(
    boxes: NDArray[np.float64], scores: NDArray[np.floating], largest_overlap: float
) -> NDArray[np.int64]:
    """Greedy suppression, best score first.

    A box is dropped where a better one that is kept covers more than `largest_overlap` of the smaller of the
    two: a box within another is one vehicle, however different their sizes (IoU would keep both).

    Args:
        boxes: (N, 4) x, y, w, h.
        scores: (N,).
        largest_overlap: intersection over the smaller area up to which both boxes stay.

    Returns:
        Indices of the boxes kept, best first; of equal scores the earlier box counts as the better.
    """
    order = np.argsort(-scores, kind="stable")
    left, top = boxes[order, 0], boxes[order, 1]
    right, bottom = left + boxes[order, 2], top + boxes[order, 3]
    area = boxes[order, 2] * boxes[order, 3]
    alive = np.ones(len(order), bool)
    kept = []
    for i in range(len(order)):
        if not alive[i]:
            continue
        kept.append(order[i])
        rest = slice(i + 1, None)
        common = np.maximum(
            np.minimum(right[rest], right[i]) - np.maximum(left[rest], left[i]), 0
        ) * np.maximum(np.minimum(bottom[rest], bottom[i]) - np.maximum(top[rest], top[i]), 0)
        alive[rest] &= common <= largest_overlap * np.minimum(area[rest], area[i])
    return np.array(kept, np.int64)


def merge(
    boxes: NDArray[np.float64],
    windows: NDArray[np.float64],
    weights: NDArray[np.floating],
    kept: NDArray[np.int64],
    smallest_iou: float,
) -> NDArray[np.float64]:
    """Boxes of the kept windows, each the weighted mean of the windows that agree with it.

    Windows stand on a grid of positions and scales; the mean of several finds the edges between its steps
    (box voting, Gidaris & Komodakis 2015).

    Args:
        boxes: (N, 4) x, y, w, h that each window votes for.
        windows: (N, 4) where the windows themselves are.
        weights: (N,), positive.
        kept: (K,) indices of the kept windows.
        smallest_iou: with a kept window, from which a window agrees with it.

    Returns:
        (K, 4) x, y, w, h.
    """
    agreeing = np.where(intersection_over_union(windows[kept], windows) >= smallest_iou, weights, 0.0)
    # A mean of x, y, w, h is the box of the mean edges: right and bottom are sums of them.
    return agreeing @ boxes / agreeing.sum(axis=1, keepdims=True)
