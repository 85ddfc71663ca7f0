"""Layers of a net for small windows, in the form that the kernels of `fcw.detection.net.forward` read."""

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
"""Number of windows that are computed together: a multiple of a tile's rows, which are windows in the hidden
layer."""


class WindowLayer(NamedTuple):
    """A convolution in the form that the kernel reads.

    Attributes:
        weights: see `ByteWeights`.
        scales: (outputs,) see `ByteWeights`.
        totals: (outputs,) see `ByteWeights`.
        biases: (outputs,) see `ByteWeights`.
        shape: words between two rows of input for consecutive rows of outputs; rows of outputs; columns of
            outputs.
        offsets: offsets of the words of all products from the first one's.
        source: the inputs: words of inputs, rows, columns, windows; then the output of `filter_rows`; then
            padding for tiles that read beyond the end.
        filtered: where the output of `filter_rows` begins; zero if two rows are not computed at once.
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
    """Where a layer's outputs are written as bytes, for the next layer.

    Attributes:
        places: (columns,) place of each output column in a row.
        shape: number of rows and columns, and the first row.
        words: the memory: words of outputs, rows, columns, windows.
    """

    places: NDArray[np.int64]
    shape: NDArray[np.int64]
    words: WordArray


class HiddenLayer(NamedTuple):
    """The first dense layer in the form that the kernel reads.

    Attributes:
        weights: in blocks of `TILE_COLUMNS` outputs. In each block, the order is word of inputs, output.
        scales: (H,) value of one step of a weight; H is the number of outputs in whole blocks.
        biases: (H,) biases.
        offsets: offsets of the weights for each word of inputs in a block.
    """

    weights: WordArray
    scales: FloatArray
    biases: FloatArray
    offsets: NDArray[np.int64]


def places_in_row(columns: int, stride: int) -> NDArray[np.int64]:
    """(columns,) places of the columns in a row with one column of padding on either side."""
    padded = np.arange(1, columns + 1)
    return padded if stride == 1 else padded % 2 * (columns // 2 + 1) + padded // 2


def window_layer(convolution: Convolution, side: int, by_row_pairs: bool) -> WindowLayer:
    """A convolution for windows with this side, and its memory; for `by_row_pairs`, see `ByteWeights`."""
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
    """Where the next convolution, with inputs of this side, reads them."""
    return Target(
        places_in_row(side, convolution.stride), np.array([side + 2, side + 2, 1]), following.source
    )


def last_target(outputs: int, side: int) -> Target:
    """Where the hidden layer reads its inputs."""
    words = -(-outputs // WORD_BYTES) * side**2 * TOGETHER
    return Target(np.arange(side), np.array([side, side, 0]), aligned_zeros((words,), np.int32))


def hidden_layer(layers: Layers, planes: int) -> HiddenLayer:
    """A net's first dense layer, for this number of input planes."""
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
