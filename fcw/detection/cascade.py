"""The soft cascade: boosted depth-2 trees over all windows of a level.

A window's score is the sum of one leaf of each tree. Bourdev and Brandt's soft cascade with a constant
threshold (as in ACF): a window is dropped as soon as its running score falls below it. The first trees, which
drop most windows, run over whole rows of windows at once (vectorised); the survivors go on one by one.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.jit import kernel
from fcw.detection.model import BoostedTrees, Window

ROW_TREES = 64
"""Trees that run over whole rows of windows."""
_LARGEST = np.float32(np.finfo(np.float32).max)


def feature_offsets(
    trees: BoostedTrees, window: Window, channel_pitch: int, row_pitch: int
) -> NDArray[np.int64]:
    """(T, 3) place of each node's feature in planar grids, counted from the window's first cell.

    Args:
        trees: their feature indices are in the order channel, row, column.
        window: its size in cells.
        channel_pitch: elements from a channel to the next.
        row_pitch: elements from a row to the next.
    """
    shape = (window.feature_count // window.cells**2, window.cells, window.cells)
    channel, row, column = np.unravel_index(trees.feature.astype(np.int64), shape)
    return channel * channel_pitch + row * row_pitch + column


def score_windows(
    grids: NDArray[np.uint8],
    row_pitch: int,
    first_row: int,
    end_row: int,
    columns: int,
    offsets: NDArray[np.int64],
    thresholds: NDArray[np.uint8],
    leaves: NDArray[np.float32],
    rejection_threshold: float,
    score_threshold: float,
    scratch: NDArray[np.float32],
    places: NDArray[np.int32],
    scores: NDArray[np.float32],
) -> int:
    """Windows that survive the cascade with a score of at least `score_threshold`.

    Args:
        grids: planar channels, flat.
        row_pitch: elements from a row of cells to the next.
        first_row: first row of cells with windows' tops.
        end_row: one past the last.
        columns: windows in a row.
        offsets: (T, 3) from `feature_offsets`.
        thresholds: (T, 3) of the trees.
        leaves: (T, 4) of the trees.
        rejection_threshold: running score below which a window is dropped; finite.
        score_threshold: final score from which a window is put out.
        scratch: (2, columns or more).
        places: (N, 2) receives row and column of the windows.
        scores: (N,) receives their scores.

    Returns:
        How many there are; where that is more than N, only the first N were written.
    """
    return _score_windows(
        grids,
        row_pitch,
        first_row,
        end_row,
        columns,
        offsets,
        thresholds,
        leaves,
        np.float32(rejection_threshold),
        np.float32(score_threshold),
        scratch,
        places,
        scores,
    )


@kernel()
def _score_windows(
    grids: NDArray[np.uint8],
    row_pitch: int,
    first_row: int,
    end_row: int,
    columns: int,
    offsets: NDArray[np.int64],
    thresholds: NDArray[np.uint8],
    leaves: NDArray[np.float32],
    rejection_threshold: np.float32,
    score_threshold: np.float32,
    scratch: NDArray[np.float32],
    places: NDArray[np.int32],
    scores: NDArray[np.float32],
) -> int:
    tree_count = len(offsets)
    row_trees = min(ROW_TREES, tree_count)
    score, lowest = scratch[0, :columns], scratch[1, :columns]
    found = 0
    for row in range(first_row, end_row):
        base = row * row_pitch
        score[:] = np.float32(0)
        lowest[:] = _LARGEST
        for t in range(row_trees):
            at0, at1, at2 = base + offsets[t, 0], base + offsets[t, 1], base + offsets[t, 2]
            root, left, right = (
                grids[at0 : at0 + columns],
                grids[at1 : at1 + columns],
                grids[at2 : at2 + columns],
            )
            limit0, limit1, limit2 = thresholds[t, 0], thresholds[t, 1], thresholds[t, 2]
            leaf0, leaf1, leaf2, leaf3 = leaves[t, 0], leaves[t, 1], leaves[t, 2], leaves[t, 3]
            for x in range(columns):
                leaf_left = leaf0 if left[x] <= limit1 else leaf1
                leaf_right = leaf2 if right[x] <= limit2 else leaf3
                running = score[x] + (leaf_left if root[x] <= limit0 else leaf_right)
                score[x] = running
                lowest[x] = min(lowest[x], running)
        for x in range(columns):
            if lowest[x] < rejection_threshold:
                continue
            running = score[x]
            at = base + x
            alive = True
            for t in range(row_trees, tree_count):
                if grids[at + offsets[t, 0]] <= thresholds[t, 0]:
                    running += leaves[t, 0] if grids[at + offsets[t, 1]] <= thresholds[t, 1] else leaves[t, 1]
                else:
                    running += leaves[t, 2] if grids[at + offsets[t, 2]] <= thresholds[t, 2] else leaves[t, 3]
                if running < rejection_threshold:
                    alive = False
                    break
            if alive and running >= score_threshold:
                if found < len(scores):
                    places[found, 0] = row
                    places[found, 1] = x
                    scores[found] = running
                found += 1
    return found
