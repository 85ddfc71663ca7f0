"""The second stage: trees over locally decorrelated channels, on the windows that pass the cascade.

W. Nam, P. Dollár and J. H. Han, "Local decorrelation for improved pedestrian detection" (NIPS 2014): each
channel is filtered with the leading eigenvectors of its own 5x5 neighbourhoods' covariance, and trees with
splits along the axes do nearly as well as oblique ones. Filtering everything is dear; here the filters are
applied only where windows survive.

All is in integers, so that training and scanning agree to the bit: a response is the sum of products of
filter weights and stored channel values; less the filter's mean and divided by a power of two, it fills the
256 steps that trees are grown over. Responses are taken where the filter lies within the window.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.cascade import DROPPED, SEGMENT, SLACK, Segments, add_trees
from fcw.detection.jit import kernel
from fcw.detection.model import (
    CHANNEL_COUNT,
    FILTER_CELLS,
    FILTERS_PER_CHANNEL,
    SecondStage,
    Window,
)

WEIGHT_STEPS = 100
"""A filter's weights, of unit norm, are stored as int8 in hundredths."""
SPREAD = 3.5
"""Standard deviations on either side of the mean that the 256 steps must hold."""
_BLOCK = 16
"""Cells side by side of which all have responses or none."""
_SEGMENTS = 128
"""Segments that trees run over at a time: their scores stay in the nearest cache."""
_CHUNK = 1024
"""Windows filtered at a time in training, which bounds its memory."""


def learn_filters(
    features: NDArray[np.uint8], window: Window
) -> tuple[NDArray[np.int8], NDArray[np.int32], NDArray[np.uint8]]:
    """Filters of each channel, from windows of background.

    Args:
        features: (N, F) uint8.
        window: the windows' size.

    Returns:
        Weights (10, 4, 5, 5), each filter's mean response (10, 4), and the power of two (10, 4) by which
        responses are divided.
    """
    grids = features.reshape(len(features), CHANNEL_COUNT, window.cells, window.cells)
    weights = np.zeros((CHANNEL_COUNT, FILTERS_PER_CHANNEL, FILTER_CELLS, FILTER_CELLS), np.int8)
    means = np.zeros(weights.shape[:2], np.int32)
    shifts = np.zeros(weights.shape[:2], np.uint8)
    for channel in range(CHANNEL_COUNT):
        patches = np.lib.stride_tricks.sliding_window_view(
            grids[:, channel], (FILTER_CELLS, FILTER_CELLS), (1, 2)
        )[:, ::2, ::2]
        patches = patches.reshape(-1, FILTER_CELLS**2).astype(np.float32)
        _, vectors = np.linalg.eigh(np.cov(patches, rowvar=False))
        leading = vectors[:, ::-1][:, :FILTERS_PER_CHANNEL].T
        # An eigenvector's sign is arbitrary: its largest weight is made positive, for repeatable files.
        largest = np.take_along_axis(leading, np.abs(leading).argmax(axis=1)[:, None], axis=1)
        filters = np.rint(leading * np.sign(largest) * WEIGHT_STEPS)
        weights[channel] = filters.reshape(FILTERS_PER_CHANNEL, FILTER_CELLS, FILTER_CELLS)
        responses = patches @ filters.T.astype(np.float32)
        means[channel] = np.rint(responses.mean(axis=0))
        steps = np.maximum(responses.std(axis=0) * SPREAD / 128, 1.0)
        shifts[channel] = np.ceil(np.log2(steps))
    return weights, means, shifts


def decorrelated(
    features: NDArray[np.uint8],
    window: Window,
    weights: NDArray[np.int8],
    means: NDArray[np.int32],
    shifts: NDArray[np.uint8],
) -> NDArray[np.uint8]:
    """Responses of windows in 256 steps: what the second stage's trees are grown over.

    Args:
        features: (N, F) uint8.
        window: the windows' size.
        weights: (10, 4, 5, 5) from `learn_filters`, as the other two.
        means: (10, 4).
        shifts: (10, 4).

    Returns:
        (N, 10 * 4 * 12 * 12) uint8 for the default window, in the order channel, filter, row, column.
    """
    places = window.cells - FILTER_CELLS + 1
    out = np.empty((len(features), CHANNEL_COUNT, FILTERS_PER_CHANNEL, places, places), np.uint8)
    for first in range(0, len(features), _CHUNK):
        chunk = slice(first, first + _CHUNK)
        grids = features[chunk].reshape(-1, CHANNEL_COUNT, window.cells, window.cells)
        patches = np.lib.stride_tricks.sliding_window_view(grids, (FILTER_CELLS, FILTER_CELLS), (2, 3))
        patches = patches.reshape(*patches.shape[:4], -1)
        for channel in range(CHANNEL_COUNT):
            # Sums of 25 products of at most 100 * 255 are exact in float32.
            filters = weights[channel].reshape(FILTERS_PER_CHANNEL, -1).T.astype(np.float32)
            responses = (patches[:, channel].astype(np.float32) @ filters).astype(np.int32)
            steps = ((responses - means[channel]) >> shifts[channel].astype(np.int32)) + 128
            out[chunk, channel] = np.clip(steps, 0, 255).transpose(0, 3, 1, 2)
    return out.reshape(len(features), int(np.prod(out.shape[1:])))


class SecondStageScorer:
    """Scores windows by a second stage, in memory it keeps: one instance for each thread.

    Windows that pass the cascade lie side by side, and share most of their responses. These are computed
    once, for rectangles of a level's cells, into planes like those of the channels; the trees then run over
    segments of places as the cascade's do.
    """

    def __init__(self, stage: SecondStage, window: Window) -> None:
        self._features, self._window = stage.trees.feature.astype(np.int64), window
        self._thresholds = np.ascontiguousarray(stage.trees.threshold, np.uint8)
        self._leaves = np.ascontiguousarray(stage.trees.leaf, np.float32)
        # Sums of 25 products of at most 100 * 255 are exact in float32, which vectorises best.
        self._weights = np.ascontiguousarray(stage.weights.reshape(-1, FILTER_CELLS**2), np.float32)
        self._means = stage.means.reshape(-1).astype(np.float32)
        self._parts = (0.5 ** stage.shifts.reshape(-1).astype(np.float64)).astype(np.float32)
        self._offsets: dict[tuple[int, int], NDArray[np.int64]] = {}
        self._responses = np.empty(0, np.uint8)
        self._extents = np.empty((2, 0), np.int64)
        self._rectangle = np.empty((2, 0), np.float32)
        self._segments = Segments(_SEGMENTS)

    def score(
        self,
        grids: NDArray[np.uint8],
        rows: int,
        row_pitch: int,
        places: NDArray[np.int64],
        out: NDArray[np.float32],
    ) -> None:
        """Score windows.

        Args:
            grids: planar channels, flat, and after them `SLACK` elements that do not matter.
            rows: rows of cells in a channel.
            row_pitch: elements from a row of cells to the next.
            places: (N,) of the windows in the first channel, ascending.
            out: (N,) receives their scores.
        """
        offsets = self._offsets_in(rows, row_pitch)
        side = self._window.cells - FILTER_CELLS + 1
        _respond_around(
            grids,
            rows,
            row_pitch,
            side,
            places,
            self._weights,
            self._means,
            self._parts,
            self._extents,
            self._rectangle[0],
            self._rectangle[1],
            self._responses,
        )
        _score(
            self._responses,
            places,
            offsets,
            self._thresholds,
            self._leaves,
            self._segments.starts,
            self._segments.running,
            out,
        )

    def _offsets_in(self, rows: int, row_pitch: int) -> NDArray[np.int64]:
        """Places of the trees' responses from a window's own, with memory for grids of this size."""
        key = rows, row_pitch
        if key not in self._offsets:
            side = self._window.cells - FILTER_CELLS + 1
            shape = (CHANNEL_COUNT * FILTERS_PER_CHANNEL, side, side)
            plane, row, column = np.unravel_index(self._features, shape)
            self._offsets[key] = plane * rows * row_pitch + row * row_pitch + column
            blocks = row_pitch // _BLOCK + 1
            self._extents = np.empty((2, max(blocks, self._extents.shape[1])), np.int64)
            cells = rows * (blocks * _BLOCK + FILTER_CELLS - 1)
            self._rectangle = np.empty((2, max(cells, self._rectangle.shape[1])), np.float32)
            responses = shape[0] * rows * row_pitch + SLACK
            self._responses = np.empty(max(responses, len(self._responses)), np.uint8)
        return self._offsets[key]


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
    offsets: NDArray[np.int64],
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
