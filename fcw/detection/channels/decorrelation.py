"""Locally decorrelated channels: what the second stage sees of the windows that pass the cascade.

W. Nam, P. Dollár and J. H. Han, "Local decorrelation for improved pedestrian detection" (NIPS 2014): each
channel is filtered with the leading eigenvectors of its own 5x5 neighbourhoods' covariance, and trees with
splits along the axes do nearly as well as oblique ones. Filtering everything is dear; here the filters are
applied only where windows survive (`fcw.detection.trees.second_stage`).

All is in integers, so that training and scanning agree to the bit: a response is the sum of products of
filter weights and stored channel values; less the filter's mean and divided by a power of two, it fills the
256 steps that trees are grown over. Responses are taken where the filter lies within the window.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import (
    CHANNEL_COUNT,
    FILTER_CELLS,
    FILTERS_PER_CHANNEL,
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
    return out.reshape(len(features), int(np.prod(out.shape[1:])))
