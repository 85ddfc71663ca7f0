"""The second stage: trees over locally decorrelated channels (`fcw.detection.channels.decorrelation`)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import (
    CHANNEL_COUNT,
    FILTER_CELLS,
    FILTERS_PER_CHANNEL,
    BoostedTrees,
    SecondStage,
    Window,
)
from fcw.detection.trees.loops import DROPPED, SEGMENT, SLACK, add_trees
from fcw.kernels.aligned import aligned_row, aligned_zeros
from fcw.kernels.inner import inner_kernel

_BLOCK = 8
"""Columns of cells side by side of which all have responses or none."""
_BAND_CELLS = 1024
"""Cells of a rectangle that are filtered at a time: their sums stay in the nearest cache."""


class SecondStageScorer(NamedTuple):
    """A second stage as the kernels read it, and memory for their work: one for each thread.

    Attributes:
        thresholds: (T, 3) uint8; without trees no window has a score.
        leaves: (T, 4) float32.
        features: (3, T, 3) int32, plane, row and column of each node's response in the window.
        weights: (10, 4, 5, 5) float32: sums of 25 products of at most 100 * 255 are exact.
        means: (10, 4) float32.
        parts: (10, 4) float32, what responses are multiplied by.
        side: responses of a window both ways.
        extents: (2, blocks) int64, memory for the rows of blocks with windows.
        cells: memory for a band of cells.
        sums: (4, cells) memory for its sums.
        responses: memory for those of a rectangle.
        offsets: (T, 3) int32, memory for the places of nodes' responses in it from a window's own.
        starts: (S,) int64, memory for the first places of segments.
        running: (S, SEGMENT) float32, memory for their running scores.
    """

    thresholds: NDArray[np.uint8]
    leaves: NDArray[np.float32]
    features: NDArray[np.int32]
    weights: NDArray[np.float32]
    means: NDArray[np.float32]
    parts: NDArray[np.float32]
    side: int
    extents: NDArray[np.int64]
    cells: NDArray[np.float32]
    sums: NDArray[np.float32]
    responses: NDArray[np.uint8]
    offsets: NDArray[np.int32]
    starts: NDArray[np.int64]
    running: NDArray[np.float32]


def prepare_second_stage(
    stage: SecondStage | None, window: Window, grids: Sequence[tuple[int, int]]
) -> SecondStageScorer:
    """`grids`: rows and columns of the levels' grids. Without a stage: one without trees."""
    stage = stage or _NO_STAGE
    side = window.cells - FILTER_CELLS + 1
    features = np.unravel_index(stage.trees.feature.astype(np.int64), (_PLANES, side, side))
    most_rows = max((rows for rows, _ in grids), default=0)
    blocks = max((columns for _, columns in grids), default=0) // _BLOCK + 1
    widest = blocks * _BLOCK + FILTER_CELLS - 1
    band = max(_BAND_CELLS, widest) + (FILTER_CELLS - 1) * widest
    segments = most_rows * widest // SEGMENT + 1
    return SecondStageScorer(
        np.array(stage.trees.threshold, np.uint8, order="C"),
        np.array(stage.trees.leaf, np.float32, order="C"),
        np.array(features, np.int32, order="C"),
        np.array(stage.weights, np.float32, order="C"),
        np.array(stage.means, np.float32, order="C"),
        np.array(0.5**stage.shifts, np.float32, order="C"),
        side,
        np.empty((2, blocks), np.int64),
        aligned_zeros((band,), np.float32),
        aligned_zeros((FILTERS_PER_CHANNEL, aligned_row(band, np.float32)), np.float32),
        np.zeros(_PLANES * most_rows * widest + SLACK, np.uint8),
        np.empty(stage.trees.feature.shape, np.int32),
        np.empty(segments, np.int64),
        aligned_zeros((segments, SEGMENT), np.float32),
    )


_PLANES = CHANNEL_COUNT * FILTERS_PER_CHANNEL
_NO_STAGE = SecondStage(
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL, FILTER_CELLS, FILTER_CELLS), np.int8),
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL), np.int32),
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL), np.uint8),
    BoostedTrees(np.zeros((0, 3), np.uint16), np.zeros((0, 3), np.uint8), np.zeros((0, 4), np.float32)),
)


@inner_kernel(from_python=True)
def run_second_stage(
    grids: NDArray[np.uint8],
    rows: int,
    row_pitch: int,
    scorer: SecondStageScorer,
    places: NDArray[np.int64],
    scores: NDArray[np.float32],
) -> None:
    """Score windows of a level.

    Windows that pass the cascade lie side by side, and share most of their responses. These are computed
    once, for rectangles of a level's cells, into planes like those of the channels; the trees then run over
    segments of places as the cascade's do.

    Args:
        grids: planar channels, flat.
        rows: rows of cells in a channel.
        row_pitch: elements from a row of cells to the next.
        scorer: from `prepare_second_stage`.
        places: (N,) of the windows in the first channel, ascending.
        scores: (N,) receives their scores.
    """
    side, first_row, end_row = scorer.side, scorer.extents[0], scorer.extents[1]
    blocks = row_pitch // _BLOCK + 1
    for block in range(blocks):
        first_row[block], end_row[block] = rows, 0
    for place in places:
        row, column = place // row_pitch, place % row_pitch
        for block in range(column // _BLOCK, (column + side - 1) // _BLOCK + 1):
            first_row[block] = min(first_row[block], row)
            end_row[block] = max(end_row[block], row + side)
    block = 0
    while block < blocks:
        first, top, bottom = block, rows, 0
        while block < blocks and end_row[block] > 0:
            top, bottom = min(top, first_row[block]), max(bottom, end_row[block])
            block += 1
        if block > first:
            left, right = first * _BLOCK, min(block * _BLOCK, row_pitch - FILTER_CELLS + 1)
            _respond(grids, rows, row_pitch, top, bottom, left, right, scorer)
            _score(row_pitch, top, bottom, left, right, scorer, places, scores)
        block += 1


@inner_kernel()
def _respond(
    grids: NDArray[np.uint8],
    rows: int,
    row_pitch: int,
    top: int,
    bottom: int,
    left: int,
    right: int,
    scorer: SecondStageScorer,
) -> None:
    """Responses in a rectangle, which the filters overlap at its right; there the planes hold nothing."""
    width = right - left + FILTER_CELLS - 1
    plane_pitch = (bottom - top) * width
    band = max(_BAND_CELLS // width, 1)
    for row in range(top, bottom, band):
        count = (min(row + band, bottom) - row) * width
        for channel in range(CHANNEL_COUNT):
            at = (channel * rows + row) * row_pitch + left
            _unpack(grids, at, row_pitch, count // width + FILTER_CELLS - 1, width, scorer.cells)
            _filter(scorer.cells, width, count, scorer.weights[channel], scorer.means[channel], scorer.sums)
            for k in range(FILTERS_PER_CHANNEL):
                to = (channel * FILTERS_PER_CHANNEL + k) * plane_pitch + (row - top) * width
                _in_steps(scorer.sums[k], scorer.parts[channel, k], scorer.responses[to : to + count])


@inner_kernel(no_alias=True)
def _unpack(
    grids: NDArray[np.uint8], at: int, row_pitch: int, rows: int, width: int, cells: NDArray[np.float32]
) -> None:
    """A rectangle of one channel, from an element on, as floating point numbers without gaps."""
    for row in range(rows):
        first, to = at + row * row_pitch, row * width
        stored, here = grids[first : first + width], cells[to : to + width]
        for x in range(width):
            here[x] = np.float32(stored[x])


@inner_kernel(no_alias=True)
def _filter(
    cells: NDArray[np.float32],
    width: int,
    count: int,
    weights: NDArray[np.float32],
    means: NDArray[np.float32],
    sums: NDArray[np.float32],
) -> None:
    """Correlate a rectangle with a channel's filters as if it were one row, and subtract their means.

    The last columns of each row mix two rows, unused.

    Args:
        cells: the rectangle.
        width: its width.
        count: sums wanted; the last `FILTER_CELLS` - 1 of them are left out.
        weights: (4, 5, 5).
        means: (4,).
        sums: (4, count or more) receives them.
    """
    wanted = count - FILTER_CELLS + 1
    for k in range(FILTERS_PER_CHANNEL):
        total = sums[k]
        for x in range(wanted):
            total[x] = -means[k]
    for row in range(FILTER_CELLS):
        here = cells[row * width :]
        for x in range(wanted):  # the loops inside are unrolled: 20 products for 5 cells loaded
            for k in range(FILTERS_PER_CHANNEL):
                total = sums[k, x]
                for column in range(FILTER_CELLS):
                    total += weights[k, row, column] * here[x + column]
                sums[k, x] = total


@inner_kernel(no_alias=True)
def _in_steps(sums: NDArray[np.float32], part: np.float32, responses: NDArray[np.uint8]) -> None:
    """Sums in 256 steps."""
    for x in range(len(responses)):
        step = np.floor(sums[x] * part) + np.float32(128)
        responses[x] = np.uint8(min(max(step, np.float32(0)), np.float32(255)))


@inner_kernel()
def _score(
    row_pitch: int,
    top: int,
    bottom: int,
    left: int,
    right: int,
    scorer: SecondStageScorer,
    places: NDArray[np.int64],
    scores: NDArray[np.float32],
) -> None:
    """Scores of those windows whose responses lie in a rectangle."""
    width, starts, running = right - left + FILTER_CELLS - 1, scorer.starts, scorer.running
    _place_features(scorer.features, (bottom - top) * width, width, scorer.offsets)
    count = 0
    for place in places:
        if left <= place % row_pitch < right:
            here = (place // row_pitch - top) * width + place % row_pitch - left
            if count == 0 or here >= starts[count - 1] + SEGMENT:
                starts[count] = here
                for x in range(SEGMENT):
                    running[count, x] = np.float32(0)
                count += 1
    add_trees(
        scorer.responses,
        starts[:count],
        scorer.offsets,
        scorer.thresholds,
        scorer.leaves,
        DROPPED,
        DROPPED,
        running,
    )
    segment = 0
    for i in range(len(places)):
        if left <= places[i] % row_pitch < right:
            here = (places[i] // row_pitch - top) * width + places[i] % row_pitch - left
            while here >= starts[segment] + SEGMENT:
                segment += 1
            scores[i] = running[segment, here - starts[segment]]


@inner_kernel(no_alias=True)
def _place_features(
    features: NDArray[np.int32], plane_pitch: int, row_pitch: int, offsets: NDArray[np.int32]
) -> None:
    """Places of nodes' responses from a window's own, in planes of this size."""
    plane, row, column = features[0], features[1], features[2]
    plane_pitch32, row_pitch32 = np.int32(plane_pitch), np.int32(row_pitch)
    for t in range(len(offsets)):
        for node in range(3):
            offsets[t, node] = plane[t, node] * plane_pitch32 + row[t, node] * row_pitch32 + column[t, node]
