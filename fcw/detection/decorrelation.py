"""The second stage: trees over locally decorrelated channels, on the windows that pass the cascade.

W. Nam, P. Dollár and J. H. Han, "Local decorrelation for improved pedestrian detection" (NIPS 2014): each
channel is filtered with the leading eigenvectors of its own 5x5 neighbourhoods' covariance, and trees with
splits along the axes do nearly as well as oblique ones. Filtering everything is dear; here the filters are
applied to surviving windows only, and of those only where a tree asks.

All is in integers, so that training and scanning agree to the bit: a response is the sum of products of
filter weights and stored channel values; less the filter's mean and divided by a power of two, it fills the
256 steps that trees are grown over. Responses are taken where the filter lies within the window.
"""

import numpy as np
from numpy.typing import NDArray

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
    return out.reshape(len(features), -1)


class SecondStageScorer:
    """Scores windows by a second stage, its trees laid out for the kernel."""

    def __init__(self, stage: SecondStage, window: Window) -> None:
        places = window.cells - FILTER_CELLS + 1
        shape = (CHANNEL_COUNT, FILTERS_PER_CHANNEL, places, places)
        channel, number, row, column = np.unravel_index(stage.trees.feature.astype(np.int64), shape)
        self._cells = window.cells
        self._offsets = (channel * window.cells + row) * window.cells + column
        self._filters = channel * FILTERS_PER_CHANNEL + number
        # Sums of 25 products of at most 100 * 255 are exact in float32, which vectorises best.
        self._weights = np.ascontiguousarray(stage.weights.reshape(-1, FILTER_CELLS**2), np.float32)
        # The step (response - mean >> shift) + 128 is at most t where the response is below this limit.
        steps = stage.trees.threshold.astype(np.int64) + 1 - 128
        limits = (steps << stage.shifts[channel, number].astype(np.int64)) + stage.means[channel, number]
        self._limits = np.where(stage.trees.threshold == 255, np.inf, limits).astype(np.float32)
        self._leaves = np.ascontiguousarray(stage.trees.leaf, np.float32)

    def scores(self, features: NDArray[np.uint8]) -> NDArray[np.float32]:
        """(N,) scores of windows with these (N, F) features."""
        out = np.zeros(len(features), np.float32)
        planes = np.empty(features.shape[::-1], np.uint8)
        responses = np.empty((3, len(features)), np.float32)
        _score(
            np.ascontiguousarray(features),
            planes,
            self._cells,
            self._offsets,
            self._filters,
            self._weights,
            self._limits,
            self._leaves,
            responses,
            out,
        )
        return out


@kernel()
def _score(
    features: NDArray[np.uint8],
    planes: NDArray[np.uint8],
    cells: int,
    offsets: NDArray[np.int64],
    filters: NDArray[np.int64],
    weights: NDArray[np.float32],
    limits: NDArray[np.float32],
    leaves: NDArray[np.float32],
    responses: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Tree by tree over all windows at once; `planes` and `responses` are scratch."""
    for feature in range(len(planes)):
        plane = planes[feature]
        for index in range(len(plane)):
            plane[index] = features[index, feature]
    for t in range(len(offsets)):
        for node in range(3):
            response, filter_weights = responses[node], weights[filters[t, node]]
            response[:] = np.float32(0)
            for row in range(FILTER_CELLS):
                first = offsets[t, node] + row * cells
                a, b, c, d, e = (
                    planes[first],
                    planes[first + 1],
                    planes[first + 2],
                    planes[first + 3],
                    planes[first + 4],
                )
                at = row * FILTER_CELLS
                wa, wb, wc = filter_weights[at], filter_weights[at + 1], filter_weights[at + 2]
                wd, we = filter_weights[at + 3], filter_weights[at + 4]
                for index in range(len(response)):
                    response[index] += (
                        wa * np.float32(a[index])
                        + wb * np.float32(b[index])
                        + wc * np.float32(c[index])
                        + wd * np.float32(d[index])
                        + we * np.float32(e[index])
                    )
        root, left, right = responses[0], responses[1], responses[2]
        limit0, limit1, limit2 = limits[t, 0], limits[t, 1], limits[t, 2]
        leaf0, leaf1, leaf2, leaf3 = leaves[t, 0], leaves[t, 1], leaves[t, 2], leaves[t, 3]
        for index in range(len(out)):
            leaf_left = leaf0 if left[index] < limit1 else leaf1
            leaf_right = leaf2 if right[index] < limit2 else leaf3
            out[index] += leaf_left if root[index] < limit0 else leaf_right
