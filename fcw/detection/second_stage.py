"""The second stage: trees over locally decorrelated channels (`fcw.detection.decorrelation`)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.cascade import DROPPED, SEGMENT, SLACK, add_trees
from fcw.detection.jit import kernel
from fcw.detection.model import (
    CHANNEL_COUNT,
    FILTER_CELLS,
    FILTERS_PER_CHANNEL,
    BoostedTrees,
    SecondStage,
    Window,
)

_BLOCK = 16
"""Cells side by side of which all have responses or none."""
_SEGMENTS = 128
"""Segments that trees run over at a time: their scores stay in the nearest cache."""


class SecondStageScorer(NamedTuple):
    """A second stage as the kernels read it, and memory for their work: one for each thread.

    Windows that pass the cascade lie side by side, and share most of their responses. These are computed
    once, for rectangles of a level's cells, into planes like those of the channels; the trees then run over
    segments of places as the cascade's do.

    Attributes:
        thresholds: (T, 3) uint8; without trees no window has a score.
        leaves: (T, 4) float32.
        weights: (40, 25) float32: sums of 25 products of at most 100 * 255 are exact, and vectorise best.
        means: (40,) float32.
        parts: (40,) float32, what responses are multiplied by.
        side: responses of a window both ways.
        extents: (2, blocks) int64, memory for the rows of blocks with windows.
        cells: memory for a rectangle of cells.
        sums: memory for its sums.
        responses: memory for the responses of a level.
        starts: (S,) int64, memory for the first places of segments.
        running: (S, SEGMENT) float32, memory for their running scores.
    """

    thresholds: NDArray[np.uint8]
    leaves: NDArray[np.float32]
    weights: NDArray[np.float32]
    means: NDArray[np.float32]
    parts: NDArray[np.float32]
    side: int
    extents: NDArray[np.int64]
    cells: NDArray[np.float32]
    sums: NDArray[np.float32]
    responses: NDArray[np.uint8]
    starts: NDArray[np.int64]
    running: NDArray[np.float32]


def prepare_second_stage(
    stage: SecondStage | None, window: Window, grids: Sequence[tuple[int, int]]
) -> SecondStageScorer:
    """`grids`: rows and columns of the levels' grids. Without a stage: one without trees."""
    stage = stage or _NO_STAGE
    most_columns = max((columns for _, columns in grids), default=0)
    blocks = most_columns // _BLOCK + 1
    most_cells = max((rows * columns for rows, columns in grids), default=0)
    rectangle = max((rows for rows, _ in grids), default=0) * (blocks * _BLOCK + FILTER_CELLS - 1)
    planes = CHANNEL_COUNT * FILTERS_PER_CHANNEL
    return SecondStageScorer(
        np.array(stage.trees.threshold, np.uint8, order="C"),
        np.array(stage.trees.leaf, np.float32, order="C"),
        stage.weights.reshape(planes, FILTER_CELLS**2).astype(np.float32),
        stage.means.reshape(-1).astype(np.float32),
        (0.5 ** stage.shifts.reshape(-1).astype(np.float64)).astype(np.float32),
        window.cells - FILTER_CELLS + 1,
        np.empty((2, blocks), np.int64),
        np.empty(rectangle, np.float32),
        np.empty(rectangle, np.float32),
        np.empty(planes * most_cells + SLACK, np.uint8),
        np.empty(_SEGMENTS, np.int64),
        np.empty((_SEGMENTS, SEGMENT), np.float32),
    )


def response_offsets(
    stage: SecondStage | None, window: Window, rows: int, row_pitch: int
) -> NDArray[np.int32]:
    """(T, 3) places of the trees' responses from a window's own, in planes of a grid of this size."""
    side = window.cells - FILTER_CELLS + 1
    shape = (CHANNEL_COUNT * FILTERS_PER_CHANNEL, side, side)
    features = (stage or _NO_STAGE).trees.feature.astype(np.int64)
    plane, row, column = np.unravel_index(features, shape)
    return (plane * rows * row_pitch + row * row_pitch + column).astype(np.int32)


_NO_STAGE = SecondStage(
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL, FILTER_CELLS, FILTER_CELLS), np.int8),
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL), np.int32),
    np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL), np.uint8),
    BoostedTrees(np.zeros((0, 3), np.uint16), np.zeros((0, 3), np.uint8), np.zeros((0, 4), np.float32)),
)


@kernel()
def run_second_stage(
    grids: NDArray[np.uint8],
    rows: int,
    row_pitch: int,
    offsets: NDArray[np.int32],
    scorer: SecondStageScorer,
    places: NDArray[np.int64],
    scores: NDArray[np.float32],
) -> None:
    """Score windows of a level.

    Args:
        grids: planar channels, flat, and after them `SLACK` elements that do not matter.
        rows: rows of cells in a channel.
        row_pitch: elements from a row of cells to the next.
        offsets: (T, 3) from `response_offsets`.
        scorer: from `prepare_second_stage`.
        places: (N,) of the windows in the first channel, ascending.
        scores: (N,) receives their scores.
    """
    _respond_around(
        grids,
        rows,
        row_pitch,
        scorer.side,
        places,
        scorer.weights,
        scorer.means,
        scorer.parts,
        scorer.extents,
        scorer.cells,
        scorer.sums,
        scorer.responses,
    )
    _score(
        scorer.responses,
        places,
        offsets,
        scorer.thresholds,
        scorer.leaves,
        scorer.starts,
        scorer.running,
        scores,
    )


@kernel()
def _respond_around(
    grids: NDArray[np.uint8],
    rows: int,
    row_pitch: int,
    side: int,
    places: NDArray[np.int64],
    weights: NDArray[np.float32],
    means: NDArray[np.float32],
    parts: NDArray[np.float32],
    extents: NDArray[np.int64],
    cells: NDArray[np.float32],
    sums: NDArray[np.float32],
    responses: NDArray[np.uint8],
) -> None:
    """Responses where windows have them, `side` both ways: in rectangles of blocks `_BLOCK` cells wide."""
    blocks = row_pitch // _BLOCK + 1
    first_row, end_row = extents[0], extents[1]
    first_row[:] = rows
    end_row[:] = 0
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
            for channel in range(CHANNEL_COUNT):
                at = channel * rows * row_pitch
                _unpack(
                    grids,
                    at,
                    row_pitch,
                    top,
                    bottom + FILTER_CELLS - 1,
                    left,
                    right + FILTER_CELLS - 1,
                    cells,
                )
                for plane in range(channel * FILTERS_PER_CHANNEL, (channel + 1) * FILTERS_PER_CHANNEL):
                    width = right - left + FILTER_CELLS - 1
                    _filter(cells, width, (bottom - top) * width, weights[plane], -means[plane], sums)
                    at = plane * rows * row_pitch
                    _store_steps(sums, parts[plane], responses, at, row_pitch, top, bottom, left, right)
        block += 1


@kernel()
def _unpack(
    grids: NDArray[np.uint8],
    at: int,
    row_pitch: int,
    top: int,
    bottom: int,
    left: int,
    right: int,
    cells: NDArray[np.float32],
) -> None:
    """A rectangle of one channel as floating point numbers, row after row without gaps."""
    width = right - left
    for row in range(top, bottom):
        first, to = at + row * row_pitch + left, (row - top) * width
        stored, here = grids[first : first + width], cells[to : to + width]
        for x in range(width):
            here[x] = np.float32(stored[x])


@kernel()
def _filter(
    cells: NDArray[np.float32],
    width: int,
    count: int,
    weights: NDArray[np.float32],
    constant: np.float32,
    sums: NDArray[np.float32],
) -> None:
    """Correlate a rectangle with a filter as if it were one row; the last columns mix two rows, unused."""
    total = sums[: count - FILTER_CELLS + 1]
    total[:] = constant
    for row in range(FILTER_CELLS):
        here, w = cells[row * width :], weights[row * FILTER_CELLS : (row + 1) * FILTER_CELLS]
        wa, wb, wc, wd, we = w[0], w[1], w[2], w[3], w[4]
        for x in range(len(total)):
            total[x] += (
                wa * here[x] + wb * here[x + 1] + wc * here[x + 2] + wd * here[x + 3] + we * here[x + 4]
            )


@kernel()
def _store_steps(
    sums: NDArray[np.float32],
    part: np.float32,
    responses: NDArray[np.uint8],
    at: int,
    row_pitch: int,
    top: int,
    bottom: int,
    left: int,
    right: int,
) -> None:
    """Sums in a rectangle, in 256 steps, into a plane of responses."""
    width = right - left
    for row in range(top, bottom):
        first, source = at + row * row_pitch + left, (row - top) * (width + FILTER_CELLS - 1)
        steps, total = responses[first : first + width], sums[source : source + width]
        for x in range(width):
            step = np.floor(total[x] * part) + np.float32(128)
            steps[x] = np.uint8(min(max(step, np.float32(0)), np.float32(255)))


@kernel()
def _score(
    responses: NDArray[np.uint8],
    places: NDArray[np.int64],
    offsets: NDArray[np.int32],
    thresholds: NDArray[np.uint8],
    leaves: NDArray[np.float32],
    starts: NDArray[np.int64],
    running: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Scores of windows in ascending places, as many segments at a time as there is room for."""
    done = 0
    while done < len(places):
        last, segments = done, 0
        while last < len(places):
            if segments == 0 or places[last] >= starts[segments - 1] + SEGMENT:
                if segments == len(starts):
                    break
                starts[segments] = places[last]
                segments += 1
            last += 1
        running[:segments] = np.float32(0)
        add_trees(responses, starts[:segments], offsets, thresholds, leaves, DROPPED, running)
        segment = 0
        for i in range(done, last):
            while places[i] >= starts[segment] + SEGMENT:
                segment += 1
            out[i] = running[segment, places[i] - starts[segment]]
        done = last
