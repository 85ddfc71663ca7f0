"""Non-maximum suppression: of the windows that one vehicle lights up, the best."""

import numpy as np
from numpy.typing import NDArray


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
