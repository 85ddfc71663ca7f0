"""What a net says of many small windows, in kernels of our own and in bytes.

`TOGETHER` windows lie side by side: the innermost axis of all memory is the window, so that a row of pixels
of these windows is one long row of words. A convolution then is a sum of such rows, each shifted and
multiplied by one word of weights, which fills the widest registers however small the windows are
(`fcw.kernels.products`); and what a layer holds of so few windows stays in a core's own cache.

As in `fcw.detection.net.planes` weights and numbers are bytes, four planes of them in a word; each window has
a scale of its own, so that it is seen alike in any company.

Rows and columns lie around each layer's numbers that stand for zeros. Before a convolution that goes two
columns a step a row's columns are parted, first the even, then the odd ones: what its sums take from is then
side by side.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.onnx_layers import Convolution, Layers
from fcw.detection.net.planes import PlaneWeights, in_bytes, in_tiles, mean_and_deviation
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel
from fcw.kernels.products import (
    TILE_COLUMNS,
    TILE_ROWS,
    WORD_BYTES,
    sum_products,
    sum_products_of_signed,
)

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]

TOGETHER = 8
"""Windows side by side: a multiple of a tile's rows, of which the hidden layer's are windows."""


class _Layer(NamedTuple):
    """A convolution as the kernel reads it.

    Attributes:
        weights: as of `PlaneWeights`, and likewise the three next ones.
        scales: (outputs,)
        totals: (outputs,)
        biases: (outputs,).
        shape: words from a row that its outputs are summed from to the next one's; rows of outputs, and
            their columns.
        offsets: where its products find their words, from the first one's.
        source: what it looks at: words of inputs, rows, columns, windows; and what tiles read beyond.
    """

    weights: WordArray
    scales: FloatArray
    totals: FloatArray
    biases: FloatArray
    shape: NDArray[np.int64]
    offsets: NDArray[np.int64]
    source: WordArray


class _Target(NamedTuple):
    """Where a layer's outputs go, as bytes.

    Attributes:
        places: (columns,) of an output in a row.
        shape: rows, columns, and the first row.
        words: words of outputs, rows, columns, windows.
    """

    places: NDArray[np.int64]
    shape: NDArray[np.int64]
    words: WordArray


class _Hidden(NamedTuple):
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


class _Work(NamedTuple):
    """What the kernel works in.

    Attributes:
        sums: (TILE_ROWS, at least a row of outputs) of a convolution.
        values: a convolution's outputs: planes, rows, columns, windows.
        largest: (columns, windows) of them, flat.
        steps: likewise, what a byte's step is in each window, the same in all columns.
        inverses: likewise, how many of them one is.
        zeros: likewise, which byte is zero.
    """

    sums: WordArray
    values: FloatArray
    largest: FloatArray
    steps: FloatArray
    inverses: FloatArray
    zeros: FloatArray


class ForwardPass:
    """A net that looks at windows of one size, in memory it keeps: one for each thread.

    Args:
        layers: of the net.
        side_px: of the windows.
        least_contrast: as of `fcw.detection.net.look.normalised`.

    Raises:
        ValueError: windows of this size do not fit the layers.
    """

    def __init__(self, layers: Layers, side_px: int, least_contrast: float) -> None:
        self._side_px, self._least_contrast = side_px, np.float32(least_contrast)
        sides = [side_px]
        for each in layers.convolutions:
            if sides[-1] % each.stride:
                raise ValueError(f"windows of {side_px} px, which the net cannot halve so often")
            sides.append(sides[-1] // each.stride)
        outputs = [len(each.weights) for each in layers.convolutions]
        if layers.hidden.shape[1] != outputs[-1] * sides[-1] ** 2:
            raise ValueError(f"a net for other windows than of {side_px} px")
        self._layers = tuple(map(_layer, layers.convolutions, sides))
        self._first_places = _places(side_px, layers.convolutions[0].stride)
        self._targets = (
            *map(_target, self._layers[1:], layers.convolutions[1:], sides[1:]),
            _last_target(outputs[-1], sides[-1]),
        )
        self._hidden = _hidden(layers, outputs[-1])
        self._hidden_count = len(layers.hidden)
        self._output, self._output_biases = np.ascontiguousarray(layers.output.T), layers.output_biases
        row, most = (
            TOGETHER * max(sides),
            max(n * side**2 for n, side in zip(outputs, sides[1:], strict=True)),
        )
        self._work = _Work(
            aligned_zeros((TILE_ROWS, in_tiles(row)), np.int32),
            aligned_zeros((most * TOGETHER,), np.float32),
            *(aligned_zeros((row,), np.float32) for _ in range(4)),
        )

    def __call__(self, windows: NDArray[np.uint8]) -> FloatArray:
        """(N, outputs) of (N, side, side, 3) BGR windows, each seen as `normalised` shows it."""
        count = len(windows)
        hidden = np.empty((-(-count // TOGETHER) * TOGETHER, len(self._hidden.biases)), np.float32)
        _forward(
            np.ascontiguousarray(windows).reshape(count, -1),
            self._side_px,
            self._least_contrast,
            self._first_places,
            self._layers,
            self._targets,
            self._hidden,
            self._work,
            hidden,
        )
        return hidden[:count, : self._hidden_count] @ self._output + self._output_biases


def _places(columns: int, stride: int) -> NDArray[np.int64]:
    """(columns,) where in a row, which has one more on either side, a convolution wants its columns."""
    padded = np.arange(1, columns + 1)
    return padded if stride == 1 else padded % 2 * (columns // 2 + 1) + padded // 2


def _layer(convolution: Convolution, side: int) -> _Layer:
    """A convolution of windows of this side, with memory."""
    weights = PlaneWeights(convolution)
    pitch = (side + 2) * TOGETHER
    columns = np.array([0, 1, 2] if weights.stride == 1 else [0, side // 2 + 1, 1]) * TOGETHER
    words = -(-weights.inputs // WORD_BYTES)
    rows = (np.arange(words)[:, None] * (side + 2) + np.arange(3)) * pitch
    to_side = side // weights.stride
    return _Layer(
        weights.weights,
        weights.scales,
        weights.totals,
        weights.biases,
        np.array([weights.stride * pitch, to_side, to_side]),
        (rows[:, :, None] + columns).reshape(-1),
        aligned_zeros((words * (side + 2) * pitch + TILE_COLUMNS,), np.int32),
    )


def _target(following: _Layer, convolution: Convolution, side: int) -> _Target:
    """Where the next convolution looks for its inputs, of this side."""
    return _Target(_places(side, convolution.stride), np.array([side + 2, side + 2, 1]), following.source)


def _last_target(outputs: int, side: int) -> _Target:
    """Where the hidden layer looks for them."""
    words = -(-outputs // WORD_BYTES) * side**2 * TOGETHER
    return _Target(np.arange(side), np.array([side, side, 0]), aligned_zeros((words,), np.int32))


def _hidden(layers: Layers, planes: int) -> _Hidden:
    outputs, inputs = layers.hidden.shape
    count, words = in_tiles(outputs), -(-planes // WORD_BYTES)
    steps, scales = in_bytes(layers.hidden)
    weights = np.zeros((count, words * WORD_BYTES, inputs // planes), np.int8)
    weights[:outputs, :planes] = steps.reshape(outputs, planes, -1)
    blocks = weights.reshape(-1, TILE_COLUMNS, words, WORD_BYTES, inputs // planes).transpose(0, 2, 4, 1, 3)
    beyond = (0, count - outputs)
    return _Hidden(
        np.ascontiguousarray(blocks).reshape(-1).view(np.int32),
        np.pad(scales, beyond),
        np.pad(layers.hidden_biases.astype(np.float32), beyond),
        np.arange(words * inputs // planes) * TILE_COLUMNS,
    )


@kernel()
def _forward(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    first_places: NDArray[np.int64],
    layers: tuple[_Layer, ...],
    targets: tuple[_Target, ...],
    dense: _Hidden,
    work: _Work,
    hidden: FloatArray,
) -> None:
    """The hidden layer's numbers, one row a window, of (N, side * side * 3) windows."""
    inputs, numbers = targets[len(targets) - 1].words, work.sums.reshape(-1)
    for first in range(0, len(hidden), TOGETHER):
        together = windows[first : first + TOGETHER]
        _see(together, side, least_contrast, first_places, layers[0].source, work.steps, work.zeros)
        for number in range(len(layers)):
            _convolve(layers[number], work)
            _put_in_bytes(layers[number], work, targets[number])
        for column in range(0, hidden.shape[1], TILE_COLUMNS):
            weights = column * len(dense.offsets)
            for n in range(0, TOGETHER, TILE_ROWS):
                sum_products_of_signed(
                    dense.weights, weights, dense.offsets, inputs, n, TOGETHER, numbers, 0, TILE_COLUMNS
                )
                for i in range(TILE_ROWS):
                    for j in range(TILE_COLUMNS):
                        value = np.float32(numbers[i * TILE_COLUMNS + j]) * work.steps[n + i]
                        value = value * dense.scales[column + j] + dense.biases[column + j]
                        hidden[first + n + i, column + j] = max(value, np.float32(0))


@inner_kernel(no_alias=True)
def _see(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    places: NDArray[np.int64],
    out: WordArray,
    steps: FloatArray,
    zeros: FloatArray,
) -> None:
    """Windows beside each other, and by what they are without their brightness and over their contrast."""
    pitch, last, pixels = side + 2, side + 1, windows.reshape(-1)
    for n in range(len(windows)):
        mean, deviation = mean_and_deviation(pixels, n * windows.shape[1], windows.shape[1])
        for i in range(n, len(steps), TOGETHER):
            steps[i], zeros[i] = np.float32(1 / (deviation + least_contrast)), np.float32(mean)
        ring = np.int32(np.rint(mean)) * np.int32(0x010101)
        for i in range(pitch):
            out[i * TOGETHER + n] = out[(last * pitch + i) * TOGETHER + n] = ring
            out[i * pitch * TOGETHER + n] = out[(i * pitch + last) * TOGETHER + n] = ring
        for row in range(side):
            for column in range(side):
                place = np.uint64((row * side + column) * 3)
                word = np.int32(windows[n, place]) | np.int32(windows[n, place + np.uint64(1)]) << np.int32(8)
                word |= np.int32(windows[n, place + np.uint64(2)]) << np.int32(16)
                out[((row + 1) * pitch + places[column]) * TOGETHER + n] = word


@inner_kernel()
def _convolve(layer: _Layer, work: _Work) -> None:
    row_step, to_rows, to_columns = layer.shape[0], layer.shape[1], layer.shape[2]
    numbers, pitch, width = work.sums.reshape(-1), work.sums.shape[1], to_columns * TOGETHER
    work.largest[:width] = 0
    for row in range(to_rows):
        for first in range(0, len(layer.biases), TILE_ROWS):
            weights = first * len(layer.offsets)
            for x in range(0, width, TILE_COLUMNS):
                sum_products(
                    layer.source,
                    row * row_step + x,
                    layer.offsets,
                    layer.weights,
                    weights,
                    TILE_ROWS,
                    numbers,
                    x,
                    pitch,
                )
            for q in range(min(TILE_ROWS, len(layer.biases) - first)):
                number = first + q
                _put(
                    numbers,
                    q * pitch,
                    (layer.scales[number], layer.totals[number], layer.biases[number]),
                    work.steps,
                    work.zeros,
                    width,
                    work.largest,
                    work.values,
                    (number * to_rows + row) * width,
                )


@inner_kernel(no_alias=True)
def _put(
    sums: WordArray,
    source: int,
    weights: tuple[np.float32, np.float32, np.float32],
    steps: FloatArray,
    zeros: FloatArray,
    count: int,
    largest: FloatArray,
    values: FloatArray,
    to: int,
) -> None:
    """A row of outputs, and how large they become."""
    scale, total, bias = weights
    for i in range(count):
        x = np.uint64(i)
        above = np.float32(sums[np.uint64(source + i)]) - zeros[x] * total
        value = max(above * (steps[x] * scale) + bias, np.float32(0))
        values[np.uint64(to + i)] = value
        largest[x] = max(largest[x], value)


@inner_kernel()
def _put_in_bytes(layer: _Layer, work: _Work, target: _Target) -> None:
    """A convolution's outputs to where the next layer looks for them."""
    rows, columns, outputs = layer.shape[1], layer.shape[2], len(layer.biases)
    for n in range(TOGETHER):
        large = np.float32(1e-30)
        for column in range(columns):
            large = max(large, work.largest[column * TOGETHER + n])
        for i in range(n, len(work.steps), TOGETHER):
            work.steps[i], work.zeros[i] = large / np.float32(255), np.float32(0)
            work.inverses[i] = np.float32(255) / large
    row_words, width = work.sums.reshape(-1), columns * TOGETHER
    for word in range(-(-outputs // WORD_BYTES)):
        first = word * WORD_BYTES
        for row in range(rows):
            for byte in range(min(WORD_BYTES, outputs - first)):
                start = ((first + byte) * rows + row) * width
                _put_byte(work.values, start, work.inverses, byte, row_words, width)
            to = (word * target.shape[0] + row + target.shape[2]) * target.shape[1] * TOGETHER
            _put_row(row_words, target.places, target.words, to)


@inner_kernel(no_alias=True)
def _put_byte(
    values: FloatArray, start: int, inverses: FloatArray, byte: int, words: WordArray, count: int
) -> None:
    """A row of numbers as so manieth byte of words; the first one clears them."""
    bits, kept = np.int32(8 * byte), np.int32(-1 if byte else 0)
    for i in range(count):
        x = np.uint64(i)
        value = np.int32(values[np.uint64(start + i)] * inverses[x] + np.float32(0.5))
        words[x] = words[x] & kept | min(value, np.int32(255)) << bits


@inner_kernel(no_alias=True)
def _put_row(row: WordArray, places: NDArray[np.int64], words: WordArray, to: int) -> None:
    """A row of words to its columns' places."""
    for column in range(len(places)):
        source, place = np.uint64(column * TOGETHER), np.uint64(to + places[column] * TOGETHER)
        for lane in range(TOGETHER):
            words[place + np.uint64(lane)] = row[source + np.uint64(lane)]
