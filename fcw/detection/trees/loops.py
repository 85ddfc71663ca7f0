"""The loops that both scoring stages spend their time in: trees outside, neighbouring places inside.

A tree's numbers stay in registers, the features of places side by side lie side by side, and the places'
running scores do not wait for each other: the compiler makes SIMD code of the inner loops.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.inner import inner_kernel

SEGMENT = 32
"""Places of a segment: one of the widest registers in steps, two in single precision. The compiler unrolls
shorter loops instead of vectorising them; longer segments hold more places without a window left."""
SLACK = 2 * SEGMENT
"""Elements after the channels that segments at their end may read."""
DROPPED = np.float32(-1e30)
"""A score so low that no leaf changes it."""
_index = np.uint64
"""Indices in the inner loops are unsigned: signed ones are checked for being negative."""


@inner_kernel(no_alias=True)
def add_tree(
    root: NDArray[np.uint8],
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    thresholds: NDArray[np.uint8],
    steps: NDArray[np.int16],
    fewest_steps: np.int16,
    dropped_steps: np.int16,
    running: NDArray[np.int16],
) -> None:
    """Add a tree to the running scores of neighbouring places, given its nodes' features there."""
    limit0, limit1, limit2 = thresholds[0], thresholds[1], thresholds[2]
    leaf0, leaf1, leaf2, leaf3 = steps[0], steps[1], steps[2], steps[3]
    for x in range(len(root)):
        leaf_left = leaf0 if left[x] <= limit1 else leaf1
        leaf_right = leaf2 if right[x] <= limit2 else leaf3
        score = np.int16(running[x] + (leaf_left if root[x] <= limit0 else leaf_right))
        running[x] = score if score >= fewest_steps else dropped_steps


@inner_kernel(no_alias=True, from_python=True)
def add_trees(
    grids: NDArray[np.uint8],
    starts: NDArray[np.int64],
    offsets: NDArray[np.int32],
    thresholds: NDArray[np.uint8],
    leaves: NDArray[np.float32] | NDArray[np.int16],
    rejection_threshold: np.float32 | np.int16,
    dropped: np.float32 | np.int16,
    running: NDArray[np.float32] | NDArray[np.int16],
) -> None:
    """Add trees to the running scores of segments, in single precision or in 16 bit steps.

    Args:
        grids: what the trees look at.
        starts: (N,) first places of the segments.
        offsets: (T, 3) places of the nodes' features from a window's own.
        thresholds: (T, 3).
        leaves: (T, 4).
        rejection_threshold: a score that falls below it becomes `dropped`,
        dropped: which no leaf lifts above it again.
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
                leaf = leaf_left if grids[root + x] <= limit0 else leaf_right
                score = running.dtype.type(running[i, x] + leaf)
                running[i, x] = score if score >= rejection_threshold else dropped
