"""The soft cascade: boosted depth-2 trees over all windows of a level.

A window's score is the sum of one leaf of each tree. Bourdev and Brandt's soft cascade with a constant
threshold (as in ACF): a window is dropped as soon as its running score falls below it.

Windows are not scored one by one. Each tree is evaluated for many neighbouring windows at once, whose
features are contiguous. A window is identified by its place, the index of its first cell in a channel. The
places of a level are one run without gaps. The last places of each row belong to no window, and are removed
at the end.

1. The first `FIRST_TREES` trees run over all places, in chunks that stay in the first-level cache. 2. The
places that remain are divided into segments of `SEGMENT` places. The other trees run over these, and every
few
   trees, segments without a window left are dropped.
3. All trees run once more over the segments that remain, in order and in single precision. So scores and
survivors
   are those of a plain evaluation, to the bit.

Steps 1 and 2 use 16-bit integers, of which a register holds twice as many. Leaves are rounded up, so that no
window is dropped that single precision would keep.

The loops themselves are in `fcw.detection.trees.loops`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import BoostedTrees, Window
from fcw.detection.trees.loops import DROPPED, SEGMENT, add_tree, add_trees
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel

FIRST_TREES = 64
"""Number of trees that run over all places; they leave about half of the segments."""
_CHUNK = 4096
_DROP_EVERY = 32
"""Number of trees after which segments without a window left are dropped."""
_MOST_STEPS = 32000
"""Largest running score in steps; the rest, up to 32767, is for the rounding of the leaves."""


def feature_offsets(
    trees: BoostedTrees, window: Window, channel_pitch: int, row_pitch: int
) -> NDArray[np.int32]:
    """(T, 3) offset of each node's feature in planar grids from the window's first cell.

    Args:
        trees: the trees; their feature indices are in the order channel, row, column.
        window: the model's window.
        channel_pitch: elements from one channel to the next.
        row_pitch: elements from one row to the next.
    """
    shape = (window.feature_count // window.cells**2, window.cells, window.cells)
    channel, row, column = np.unravel_index(trees.feature.astype(np.int64), shape)
    return (channel * channel_pitch + row * row_pitch + column).astype(np.int32)


class Cascade(NamedTuple):
    """A model's cascade in the form that the kernel reads, with working memory. Each thread needs its own.

    Attributes:
        thresholds: (T, 3) uint8.
        leaves: (T, 4) float32.
        rejection_threshold: running score below which a window is dropped.
        steps: (T, 4) int16, the leaves in steps.
        fewest_steps: the rejection threshold in steps.
        dropped_steps: what the running score of a dropped window is set to, in steps.
        chunk: (chunk + SEGMENT,) int16, memory for running scores of all places.
        starts: (S,) int64, memory for the first places of segments.
        step_scores: (S, SEGMENT) int16, memory for their running scores in steps.
        running: (S, SEGMENT) float32, memory for their running scores.
    """

    thresholds: NDArray[np.uint8]
    leaves: NDArray[np.float32]
    rejection_threshold: np.float32
    steps: NDArray[np.int16]
    fewest_steps: np.int16
    dropped_steps: np.int16
    chunk: NDArray[np.int16]
    starts: NDArray[np.int64]
    step_scores: NDArray[np.int16]
    running: NDArray[np.float32]


def prepare_cascade(trees: BoostedTrees, rejection_threshold: float, most_places: int) -> Cascade:
    """Prepare a cascade for levels with up to a number of places.

    Args:
        trees: the trees of the cascade.
        rejection_threshold: running score below which a window is dropped; finite.
        most_places: largest number of places from a level's first window to its last.
    """
    segments = most_places // SEGMENT + most_places // _CHUNK + 2  # each chunk is divided separately
    leaves = np.array(trees.leaf, np.float32, order="C")
    return Cascade(
        np.array(trees.threshold, np.uint8, order="C"),
        leaves,
        np.float32(rejection_threshold),
        *_in_steps(leaves, rejection_threshold),
        aligned_zeros((_CHUNK + SEGMENT,), np.int16),
        np.empty(segments, np.int64),
        aligned_zeros((segments, SEGMENT), np.int16),
        aligned_zeros((segments, SEGMENT), np.float32),
    )


def _in_steps(
    leaves: NDArray[np.float32], rejection_threshold: float
) -> tuple[NDArray[np.int16], np.int16, np.int16]:
    """Leaves in steps, rounded up; the threshold, rounded down; and a score for dropped windows.

    The steps are as fine as possible without an overflow of 16 bits, whether a window was dropped or not. A
    dropped window's score stays so low that no leaf lifts it to the threshold again. One extra step allows
    for the rounding of single precision.
    """
    highest, lowest = leaves.max(axis=1, initial=0.0), leaves.min(axis=1, initial=0.0)
    threshold = max(rejection_threshold, 1.001 * float(lowest.sum()) - 1e-3)  # lower, and none is dropped
    most_steps = _MOST_STEPS - len(leaves)
    if most_steps < _MOST_STEPS // 2:
        raise ValueError(f"a cascade of {len(leaves)} trees: expected up to {_MOST_STEPS // 2}")
    largest, smallest = float(highest.max(initial=0.0)), float(lowest.min(initial=0.0))
    scale = most_steps / max(float(highest.sum()), largest - smallest - threshold)
    steps = np.ceil(leaves * scale).astype(np.int16)
    fewest = np.int16(min(np.floor(threshold * scale) - 1, np.iinfo(np.int16).max))
    return steps, fewest, np.int16(np.iinfo(np.int16).min - int(steps.min(initial=0)))


@inner_kernel(from_python=True)
def run_cascade(
    grids: NDArray[np.uint8],
    row_pitch: int,
    first_row: int,
    end_row: int,
    columns: int,
    offsets: NDArray[np.int32],
    cascade: Cascade,
    places: NDArray[np.int64],
    scores: NDArray[np.float32],
) -> int:
    """Windows that survive the cascade, row by row.

    Args:
        grids: planar channels, flat, and after them `SLACK` elements that do not matter.
        row_pitch: elements from a row of cells to the next.
        first_row: first row of cells where windows have their top.
        end_row: one past the last.
        columns: windows in a row.
        offsets: (T, 3) from `feature_offsets`.
        cascade: from `prepare_cascade`.
        places: receives the places of the windows in the first channel; room for all windows.
        scores: receives their scores.

    Returns:
        How many there are.
    """
    thresholds, steps, starts, running = cascade.thresholds, cascade.steps, cascade.starts, cascade.running
    level_end = (end_row - 1) * row_pitch + columns
    count = np.int64(0)  # a literal 0 would have the next kernels compiled twice
    for first in range(first_row * row_pitch, level_end, _CHUNK):
        end = min(first + _CHUNK, level_end)
        _run_first_trees(grids, first, end - first, offsets, cascade)
        count = _cut_into_segments(first, end - first, count, cascade)
    for t in range(FIRST_TREES, len(offsets), _DROP_EVERY):
        stop = min(t + _DROP_EVERY, len(offsets))
        add_trees(
            grids,
            starts[:count],
            offsets[t:stop],
            thresholds[t:stop],
            steps[t:stop],
            cascade.fewest_steps,
            cascade.dropped_steps,
            cascade.step_scores,
        )
        count = _drop_dead(starts, cascade.step_scores, count, cascade.fewest_steps)
    for i in range(count):
        for x in range(SEGMENT):
            running[i, x] = np.float32(0)
    add_trees(
        grids,
        starts[:count],
        offsets,
        thresholds,
        cascade.leaves,
        cascade.rejection_threshold,
        DROPPED,
        running,
    )
    found = 0
    for i in range(count):
        for x in range(SEGMENT):
            place = starts[i] + x
            alive = cascade.step_scores[i, x] >= cascade.fewest_steps  # not one that another segment holds
            if alive and place % row_pitch < columns and running[i, x] >= cascade.rejection_threshold:
                places[found] = place
                scores[found] = running[i, x]
                found += 1
    return found


@inner_kernel()
def _run_first_trees(
    grids: NDArray[np.uint8], first: int, count: int, offsets: NDArray[np.int32], cascade: Cascade
) -> None:
    """Running scores of `count` places, in steps; after them come dropped ones, a segment long."""
    running = cascade.chunk
    for x in range(count):
        running[x] = np.int16(0)
    for x in range(count, count + SEGMENT):
        running[x] = cascade.dropped_steps
    for t in range(min(FIRST_TREES, len(offsets))):
        at0, at1, at2 = first + offsets[t, 0], first + offsets[t, 1], first + offsets[t, 2]
        add_tree(
            grids[at0 : at0 + count],
            grids[at1 : at1 + count],
            grids[at2 : at2 + count],
            cascade.thresholds[t],
            cascade.steps[t],
            cascade.fewest_steps,
            cascade.dropped_steps,
            running,
        )


@inner_kernel()
def _cut_into_segments(first: int, places: int, count: int, cascade: Cascade) -> int:
    """Add segments that hold every place of a chunk with a window left; how many there are with them."""
    running, starts, step_scores = cascade.chunk, cascade.starts, cascade.step_scores
    covered = 0
    for x in range(places):
        if x >= covered and running[x] >= cascade.fewest_steps:
            starts[count] = first + x
            for lane in range(SEGMENT):
                step_scores[count, lane] = running[x + lane]
            count += 1
            covered = x + SEGMENT
    return count


@inner_kernel()
def _drop_dead(
    starts: NDArray[np.int64], running: NDArray[np.int16], count: int, fewest_steps: np.int16
) -> int:
    """Close the ranks over segments without a window left; how many remain."""
    alive = 0
    for i in range(count):
        highest = running[i, 0]
        for x in range(1, SEGMENT):
            highest = max(highest, running[i, x])
        if highest >= fewest_steps:
            starts[alive] = starts[i]
            for x in range(SEGMENT):
                running[alive, x] = running[i, x]
            alive += 1
    return alive
