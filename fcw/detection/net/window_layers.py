"""Layers of a net that looks at small windows, as the kernels of `fcw.detection.net.forward` read them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.byte_weights import ByteWeights, in_bytes, in_tiles
from fcw.detection.net.onnx_layers import Convolution, Layers
from fcw.detection.net.row_pairs import FILTERS, PAIRS, row_offsets
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.products import TILE_COLUMNS, WORD_BYTES

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]

TOGETHER = 8
"""Windows side by side: a multiple of a tile's rows, of which the hidden layer's are windows."""


class WindowLayer(NamedTuple):
    """A convolution as the kernel reads it.

    Attributes:
        weights: as of `ByteWeights`, and likewise the three next ones.
        scales: (outputs,)
        totals: (outputs,)
        biases: (outputs,).
        shape: words from a row that its outputs are summed from to the next one's; rows of outputs, and
            their columns.
        offsets: where its products find their words, from the first one's.
        source: what it looks at: words of inputs, rows, columns, windows; what is made of these by
            `filter_rows`; and what tiles read beyond.
        filtered: where the latter begins; zero where two rows are not summed at once.
    """

    weights: WordArray
    scales: FloatArray
    totals: FloatArray
    biases: FloatArray
    shape: NDArray[np.int64]
    offsets: NDArray[np.int64]
    source: WordArray
    filtered: int


class Target(NamedTuple):
    """Where a layer's outputs go, as bytes.

    Attributes:
        places: (columns,) of an output in a row.
        shape: rows, columns, and the first row.
        words: words of outputs, rows, columns, windows.
    """

    places: NDArray[np.int64]
    shape: NDArray[np.int64]
    words: WordArray


class HiddenLayer(NamedTuple):
    """The first dense layer as the kernel reads it.

    Attributes:
        weights: its outputs' in blocks of `TILE_COLUMNS`; in each the order is word of inputs, output.
        scales: (H,) of as many outputs as there are in whole blocks, what one of a weight's steps is.
        biases: (H,).
        offsets: where the weights of a word of inputs are in a block.
    """

    weights: WordArray
    scales: FloatArray
    biases: FloatArray
    offsets: NDArray[np.int64]


def places_in_row(columns: int, stride: int) -> NDArray[np.int64]:
    """(columns,) where in a row, which has one more on either side, a convolution wants its columns."""
    padded = np.arange(1, columns + 1)
    return padded if stride == 1 else padded % 2 * (columns // 2 + 1) + padded // 2


def window_layer(convolution: Convolution, side: int, by_row_pairs: bool) -> WindowLayer:
    """A convolution of windows of this side, with memory; `by_row_pairs` as of `ByteWeights`."""
    weights = ByteWeights(convolution, by_row_pairs)
    pitch, to_side = (side + 2) * TOGETHER, side // weights.stride
    words = -(-weights.inputs // WORD_BYTES)
    count, pair_rows = words * (side + 2) * pitch, -(-side // 2)
    if weights.by_row_pairs:
        row_pitch, filtered = pitch, count
        count += FILTERS * words * PAIRS * pair_rows * pitch
        offsets = row_offsets(words, pair_rows, pitch, TOGETHER)
    else:
        row_pitch, filtered = weights.stride * pitch, 0
        columns = np.array([0, 1, 2] if weights.stride == 1 else [0, side // 2 + 1, 1]) * TOGETHER
        rows = (np.arange(words)[:, None] * (side + 2) + np.arange(3)) * pitch
        offsets = (rows[:, :, None] + columns).reshape(-1)
    return WindowLayer(
        weights.weights,
        weights.scales,
        weights.totals,
        weights.biases,
        np.array([row_pitch, to_side, to_side]),
        offsets,
        aligned_zeros((count + TILE_COLUMNS,), np.int32),
        filtered,
    )


def target_of(following: WindowLayer, convolution: Convolution, side: int) -> Target:
    """Where the next convolution looks for its inputs, of this side."""
    return Target(
        places_in_row(side, convolution.stride), np.array([side + 2, side + 2, 1]), following.source
    )


def last_target(outputs: int, side: int) -> Target:
    """Where the hidden layer looks for them."""
    words = -(-outputs // WORD_BYTES) * side**2 * TOGETHER
    return Target(np.arange(side), np.array([side, side, 0]), aligned_zeros((words,), np.int32))


def hidden_layer(layers: Layers, planes: int) -> HiddenLayer:
    """A net's first dense layer, of so many planes."""
    outputs, inputs = layers.hidden.shape
    count, words = in_tiles(outputs), -(-planes // WORD_BYTES)
    steps, scales = in_bytes(layers.hidden)
    weights = np.zeros((count, words * WORD_BYTES, inputs // planes), np.int8)
    weights[:outputs, :planes] = steps.reshape(outputs, planes, -1)
    blocks = weights.reshape(-1, TILE_COLUMNS, words, WORD_BYTES, inputs // planes).transpose(0, 2, 4, 1, 3)
    beyond = (0, count - outputs)
    return HiddenLayer(
        np.ascontiguousarray(blocks).reshape(-1).view(np.int32),
        np.pad(scales, beyond),
        np.pad(layers.hidden_biases.astype(np.float32), beyond),
        np.arange(words * inputs // planes) * TILE_COLUMNS,
    )
