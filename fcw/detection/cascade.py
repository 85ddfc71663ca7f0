"""The soft cascade: boosted depth-2 trees over all windows of a level.

A window's score is the sum of one leaf of each tree. Bourdev and Brandt's soft cascade with a constant
threshold (as in ACF): a window is dropped as soon as its running score falls below it.

No window is scored alone: one tree is evaluated for many neighbouring windows at once, whose features lie
side by side. Windows are told by their place, the index of their first cell in a channel; a level's places
are one run without gaps, in which the last places of a row stand for no window and are left out at the end.

1. The first `COARSE_TREES` trees run over all places, in chunks that stay in the nearest cache, in 16 bit
   steps: leaves are rounded up, so that no window is dropped that single precision would keep.
2. What is left is cut into segments of `SEGMENT` places, and all trees run over these in single precision, in
   the trees' order: scores and survivors are those of a plain evaluation, to the bit. Segments in which no
   window is left are dropped along the way.

Both loops are over trees outside and places inside: the tree's numbers stay in registers, and the places'
running scores do not wait for each other.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.jit import kernel
from fcw.detection.model import BoostedTrees, Window

COARSE_TREES = 128
"""Trees that run over all places: they leave about one window in thirty."""
SEGMENT = 32
"""Places of a segment: two of the widest registers. The compiler unrolls shorter loops instead of vectorising
them; longer segments hold more places without a window left."""
SLACK = 2 * SEGMENT
"""Elements after the channels that segments at their end may read."""
_CHUNK = 4096
_DROP_EVERY = 64
"""Trees after which dead segments are dropped."""
_LARGEST_STEPS = 32000
_LARGEST_INT16 = np.int16(np.iinfo(np.int16).max)
DROPPED = np.float32(-1e30)
"""A score so low that no leaf changes it. It needs no second array that says which windows are dropped:
before each segment the compiled loop asks whether its arrays overlap, which costs as much as the loop."""
_index = np.uint64
"""Indices in the inner loops are unsigned: signed ones are checked for being negative."""


def feature_offsets(
    trees: BoostedTrees, window: Window, channel_pitch: int, row_pitch: int
) -> NDArray[np.int32]:
    """(T, 3) place of each node's feature in planar grids, counted from the window's first cell.

    Args:
        trees: their feature indices are in the order channel, row, column.
        window: its size in cells.
        channel_pitch: elements from a channel to the next.
        row_pitch: elements from a row to the next.
    """
    shape = (window.feature_count // window.cells**2, window.cells, window.cells)
    channel, row, column = np.unravel_index(trees.feature.astype(np.int64), shape)
    return (channel * channel_pitch + row * row_pitch + column).astype(np.int32)


class Cascade(NamedTuple):
    """A model's cascade as the kernel reads it, and memory for its work: one for each thread.

    Attributes:
        thresholds: (T, 3) uint8.
        leaves: (T, 4) float32.
        steps: (up to `COARSE_TREES`, 4) int16, leaves of the first trees.
        fewest_steps: running score in steps below which a window is dropped.
        rejection_threshold: the same in single precision.
        coarse: (2, chunk) int16, memory for running scores and their lowest.
        starts: (S,) int64, memory for the first places of segments.
        running: (S, SEGMENT) float32, memory for their running scores.
    """

    thresholds: NDArray[np.uint8]
    leaves: NDArray[np.float32]
    steps: NDArray[np.int16]
    fewest_steps: np.int16
    rejection_threshold: np.float32
    coarse: NDArray[np.int16]
    starts: NDArray[np.int64]
    running: NDArray[np.float32]


def prepare_cascade(trees: BoostedTrees, rejection_threshold: float) -> Cascade:
    """`rejection_threshold`: running score below which a window is dropped; finite."""
    segments = _CHUNK // SEGMENT + 1
    leaves = np.array(trees.leaf, np.float32, order="C")
    return Cascade(
        np.array(trees.threshold, np.uint8, order="C"),
        leaves,
        *_in_steps(leaves[:COARSE_TREES], rejection_threshold),
        np.float32(rejection_threshold),
        np.empty((2, _CHUNK), np.int16),
        np.empty(segments, np.int64),
        np.empty((segments, SEGMENT), np.float32),
    )


def _in_steps(leaves: NDArray[np.float32], rejection_threshold: float) -> tuple[NDArray[np.int16], np.int16]:
    """Leaves in steps as fine as no sum of them leaves 16 bits, rounded up; and the threshold, rounded down.

    One step more is left for the rounding of single precision.
    """
    highest, lowest = leaves.max(axis=1, initial=0.0).sum(), leaves.min(axis=1, initial=0.0).sum()
    scale = _LARGEST_STEPS / max(float(highest), -float(lowest), 1e-6)
    limit = max(np.floor(rejection_threshold * scale) - 1, np.iinfo(np.int16).min)
    return np.ceil(leaves * scale).astype(np.int16), np.int16(min(limit, _LARGEST_INT16))


@kernel()
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
    thresholds, leaves, starts, running = cascade.thresholds, cascade.leaves, cascade.starts, cascade.running
    rejection_threshold = cascade.rejection_threshold
    found = 0
    level_end = (end_row - 1) * row_pitch + columns
    for first in range(first_row * row_pitch, level_end, _CHUNK):
        end = min(first + _CHUNK, level_end)
        _coarse_trees(grids, first, end, offsets, thresholds, cascade.steps, cascade.coarse)
        count = _cut_into_segments(first, end, cascade.coarse[1], cascade.fewest_steps, starts)
        running[:count] = np.float32(0)
        for t in range(0, len(offsets), _DROP_EVERY):
            stop = min(t + _DROP_EVERY, len(offsets))
            add_trees(
                grids,
                starts[:count],
                offsets[t:stop],
                thresholds[t:stop],
                leaves[t:stop],
                rejection_threshold,
                running,
            )
            if stop > COARSE_TREES:  # before, the coarse steps have seen to it
                count = _drop_dead(starts, running, count, rejection_threshold)
        for i in range(count):
            for x in range(SEGMENT):
                place = starts[i] + x
                if place < end and place % row_pitch < columns and running[i, x] >= rejection_threshold:
                    places[found] = place
                    scores[found] = running[i, x]
                    found += 1
    return found


@kernel()
def _coarse_trees(
    grids: NDArray[np.uint8],
    first: int,
    end: int,
    offsets: NDArray[np.int32],
    thresholds: NDArray[np.uint8],
    steps: NDArray[np.int16],
    coarse: NDArray[np.int16],
) -> None:
    """Running scores of the places first..end-1 and their lowest, in steps, into the rows of `coarse`."""
    count = end - first
    running, lowest = coarse[0, :count], coarse[1, :count]
    running[:] = np.int16(0)
    lowest[:] = _LARGEST_INT16
    for t in range(len(steps)):
        at0, at1, at2 = first + offsets[t, 0], first + offsets[t, 1], first + offsets[t, 2]
        root, left, right = grids[at0 : at0 + count], grids[at1 : at1 + count], grids[at2 : at2 + count]
        limit0, limit1, limit2 = thresholds[t, 0], thresholds[t, 1], thresholds[t, 2]
        leaf0, leaf1, leaf2, leaf3 = steps[t, 0], steps[t, 1], steps[t, 2], steps[t, 3]
        for x in range(count):
            leaf_left = leaf0 if left[x] <= limit1 else leaf1
            leaf_right = leaf2 if right[x] <= limit2 else leaf3
            score = np.int16(running[x] + (leaf_left if root[x] <= limit0 else leaf_right))
            running[x] = score
            if score < lowest[x]:
                lowest[x] = score


@kernel()
def _cut_into_segments(
    first: int, end: int, lowest: NDArray[np.int16], fewest_steps: np.int16, starts: NDArray[np.int64]
) -> int:
    """Starts of segments that hold every place with a window left; how many there are."""
    count = 0
    covered = 0
    for x in range(end - first):
        if x >= covered and lowest[x] >= fewest_steps:
            starts[count] = first + x
            count += 1
            covered = x + SEGMENT
    return count


@kernel()
def add_trees(
    grids: NDArray[np.uint8],
    starts: NDArray[np.int64],
    offsets: NDArray[np.int32],
    thresholds: NDArray[np.uint8],
    leaves: NDArray[np.float32],
    rejection_threshold: np.float32,
    running: NDArray[np.float32],
) -> None:
    """Add trees to the running scores of segments.

    Args:
        grids: what the trees look at.
        starts: (N,) first places of the segments.
        offsets: (T, 3) places of the nodes' features from a window's own.
        thresholds: (T, 3).
        leaves: (T, 4).
        rejection_threshold: a score that falls below it becomes `DROPPED`, for good.
        running: (N or more, SEGMENT) running scores.
    """
    for t in range(len(offsets)):
        offset0, offset1, offset2 = _index(offsets[t, 0]), _index(offsets[t, 1]), _index(offsets[t, 2])
        limit0, limit1, limit2 = thresholds[t, 0], thresholds[t, 1], thresholds[t, 2]
        leaf0, leaf1, leaf2, leaf3 = leaves[t, 0], leaves[t, 1], leaves[t, 2], leaves[t, 3]
        for segment in range(len(starts)):
            i = _index(segment)
            start = _index(starts[i])
            root, left, right = start + offset0, start + offset1, start + offset2
            for lane in range(SEGMENT):
                x = _index(lane)
                leaf_left = leaf0 if grids[left + x] <= limit1 else leaf1
                leaf_right = leaf2 if grids[right + x] <= limit2 else leaf3
                score = running[i, x] + (leaf_left if grids[root + x] <= limit0 else leaf_right)
                running[i, x] = score if score >= rejection_threshold else DROPPED


@kernel()
def _drop_dead(
    starts: NDArray[np.int64],
    running: NDArray[np.float32],
    count: int,
    rejection_threshold: np.float32,
) -> int:
    """Close the ranks over segments without a window left; how many remain."""
    alive = 0
    for i in range(count):
        highest = DROPPED
        for x in range(SEGMENT):
            highest = max(highest, running[i, x])
        if highest >= rejection_threshold:
            starts[alive] = starts[i]
            for x in range(SEGMENT):
                running[alive, x] = running[i, x]
            alive += 1
    return alive
