"""Non-maximum suppression of boxes."""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel


def suppress(
    boxes: NDArray[np.float64], scores: NDArray[np.floating], largest_overlap: float
) -> NDArray[np.int64]:
    """Greedy suppression, best score first.

    A box is dropped if its intersection with a better one that is kept is more than `largest_overlap` of the
    smaller one's area. So a box inside another counts as the same vehicle, however different their sizes; IoU
    would keep both.

    Args:
        boxes: (N, 4) x, y, w, h.
        scores: (N,).
        largest_overlap: intersection over the smaller area up to which both boxes are kept.

    Returns:
        Indices of the boxes kept, best first; of equal scores the earlier box counts as the better.
    """
    order = np.arange(len(boxes))
    kept = np.empty_like(order)
    sort_best_first(np.array(scores, np.float64), order, np.empty_like(order))
    count = keep_apart(np.array(boxes, np.float64, order="C"), order, largest_overlap, kept)
    return kept[:count]


def keep_unlike(boxes: NDArray[np.float64], largest_iou: float, most: int) -> NDArray[np.int64]:
    """Greedy suppression by IoU, which keeps a small box inside a large one.

    Args:
        boxes: (N, 4) x, y, w, h, best first.
        largest_iou: largest IoU of any two boxes that are kept.
        most: largest number of boxes that are kept.

    Returns:
        Indices of the boxes kept, in their order.
    """
    kept = np.empty(min(most, len(boxes)), np.int64)
    return kept[: _keep_unlike(np.array(boxes, np.float64, order="C"), largest_iou, kept)]


@kernel()
def _keep_unlike(boxes: NDArray[np.float64], largest_iou: float, kept: NDArray[np.int64]) -> int:
    count = 0
    for i in range(len(boxes)):
        if count == len(kept):
            break
        alike = False
        for k in range(count):
            if agree(boxes, i, kept[k], largest_iou):
                alike = True
                break
        if not alike:
            kept[count] = i
            count += 1
    return count


@inner_kernel(from_python=True)
def sort_best_first(scores: NDArray[np.float64], order: NDArray[np.int64], spare: NDArray[np.int64]) -> None:
    """Sort indices by descending score, stably.

    A bottom-up merge sort between `order` and `spare`, which has the same length. Unlike the library's, it
    allocates no memory.
    """
    count = len(order)
    run = 1
    while run < count:
        for first in range(0, count, 2 * run):
            middle, end = min(first + run, count), min(first + 2 * run, count)
            left, right = first, middle
            for to in range(first, end):
                if left < middle and (right >= end or scores[order[left]] >= scores[order[right]]):
                    spare[to] = order[left]
                    left += 1
                else:
                    spare[to] = order[right]
                    right += 1
        for i in range(count):  # assigning a slice would compile numpy's broadcasting and its error texts
            order[i] = spare[i]
        run *= 2


@inner_kernel(from_python=True)
def keep_apart(
    boxes: NDArray[np.float64], order: NDArray[np.int64], largest_overlap: float, kept: NDArray[np.int64]
) -> int:
    """Write the boxes of `order`, best first, that `suppress` keeps into `kept`; returns their number."""
    count = 0
    for i in order:
        alive = True
        for k in range(count):
            smaller = min(boxes[i, 2] * boxes[i, 3], boxes[kept[k], 2] * boxes[kept[k], 3])
            if common_area(boxes, i, kept[k]) > largest_overlap * smaller:
                alive = False
                break
        if alive:
            kept[count] = i
            count += 1
    return count


@inner_kernel()
def common_area(boxes: NDArray[np.float64], i: int, k: int) -> float:
    """Common area of two of the boxes x, y, w, h, in square pixels."""
    width = min(boxes[i, 0] + boxes[i, 2], boxes[k, 0] + boxes[k, 2]) - max(boxes[i, 0], boxes[k, 0])
    height = min(boxes[i, 1] + boxes[i, 3], boxes[k, 1] + boxes[k, 3]) - max(boxes[i, 1], boxes[k, 1])
    return max(width, 0.0) * max(height, 0.0)


@inner_kernel()
def agree(boxes: NDArray[np.float64], i: int, k: int, smallest_iou: float) -> bool:
    """Whether two of the boxes x, y, w, h have at least an IoU."""
    common = common_area(boxes, i, k)
    return common >= smallest_iou * (boxes[i, 2] * boxes[i, 3] + boxes[k, 2] * boxes[k, 3] - common)
