"""What a net says of many small windows, in kernels of our own: in a quarter of the time of OpenCV's dnn.

`TOGETHER` windows lie side by side: the innermost axis of all memory is the window, so that a row of pixels
of these windows is one long row of numbers. A convolution then is a sum of such rows, each shifted and
multiplied by one weight, which fills the widest registers however small the windows are
(`fcw.kernels.products`); and what a layer holds of so few windows stays in a core's own cache.

Rows and columns of zeros lie around each layer's numbers. Before a convolution that goes two columns a step
a row's columns are parted, first the even, then the odd ones: what its sums take from is then side by side.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.onnx_layers import Convolution, Layers
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, sum_products

FloatArray = NDArray[np.float32]

TOGETHER = 8
"""Windows side by side: a multiple of a tile's rows, of which the hidden layer's are windows."""


class _Layer(NamedTuple):
    """A convolution as the kernel reads it.

    Attributes:
        weights: the outputs' in blocks of `TILE_ROWS`; in each the order is input, row, column, output.
        biases: (outputs,).
        shape: elements from a row that its outputs are summed from to the next one's; outputs and their rows.
        offsets: (9 * inputs,) where its products find their numbers, from the first one's.
        source: what it looks at: inputs, rows, columns, windows; and what tiles read beyond.
        to: (columns,) places of its outputs in a row of `target`,
        to_shape: and that array's rows, columns, and first row.
        target: where its outputs go.
    """

    weights: FloatArray
    biases: FloatArray
    shape: NDArray[np.int64]
    offsets: NDArray[np.int64]
    source: FloatArray
    to: NDArray[np.int64]
    to_shape: NDArray[np.int64]
    target: FloatArray


class _Hidden(NamedTuple):
    """The first dense layer as the kernel reads it.

    Attributes:
        weights: its outputs' in blocks of `TILE_COLUMNS`; in each the order is input, output.
        biases: (H,), of as many outputs as there are in whole blocks.
        offsets: (inputs,) where the inputs' weights are in a block.
    """

    weights: FloatArray
    biases: FloatArray
    offsets: NDArray[np.int64]


class ForwardPass:
    """A net that looks at windows of one size, in memory it keeps: one for each thread.

    Args:
        layers: of the net.
        side_px: of the windows.
        least_contrast: as of `fcw.detection.net.looks.normalised`.

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
        count = len(layers.convolutions[-1].weights) * sides[-1] ** 2
        if layers.hidden.shape[1] != count:
            raise ValueError(f"a net for other windows than of {side_px} px")
        self._layers = _layers(layers.convolutions, sides)
        self._first_places = _places(side_px, layers.convolutions[0].stride)
        self._hidden = _hidden(layers)
        self._hidden_count = len(layers.hidden)
        self._output, self._output_biases = np.ascontiguousarray(layers.output.T), layers.output_biases
        self._sums = aligned_zeros((TILE_ROWS, _in_tiles(TOGETHER * max(sides))), np.float32)

    def __call__(self, windows: NDArray[np.uint8]) -> FloatArray:
        """(N, outputs) of (N, side, side, 3) BGR windows, each seen as `normalised` shows it."""
        count = len(windows)
        hidden = np.empty((-(-count // TOGETHER) * TOGETHER, len(self._hidden.biases)), np.float32)
        _forward(
            windows.reshape(count, -1),
            self._side_px,
            self._least_contrast,
            self._first_places,
            self._layers,
            self._sums,
            self._hidden,
            hidden,
        )
        return hidden[:count, : self._hidden_count] @ self._output + self._output_biases


def _in_tiles(count: int) -> int:
    """So many numbers, or as many more as fill the last tile."""
    return -(-count // TILE_COLUMNS) * TILE_COLUMNS


def _places(columns: int, stride: int) -> NDArray[np.int64]:
    """(columns,) where in a row, which has one more on either side, a convolution wants its columns."""
    padded = np.arange(1, columns + 1)
    return padded if stride == 1 else padded % 2 * (columns // 2 + 1) + padded // 2


def _layers(convolutions: tuple[Convolution, ...], sides: list[int]) -> tuple[_Layer, ...]:
    """The convolutions, with memory."""
    memories = [
        aligned_zeros((each.weights.shape[1] * (side + 2) ** 2 * TOGETHER + TILE_COLUMNS,), np.float32)
        for each, side in zip(convolutions, sides, strict=False)
    ]
    last = len(convolutions[-1].weights) * sides[-1] ** 2
    memories.append(aligned_zeros((last * TOGETHER,), np.float32))
    made = []
    for i, each in enumerate(convolutions):
        outputs, inputs = each.weights.shape[:2]
        side, to_side = sides[i], sides[i + 1]
        blocks = -(-outputs // TILE_ROWS)
        weights = np.zeros((blocks * TILE_ROWS, inputs * 9), np.float32)
        weights[:outputs] = each.weights.reshape(outputs, -1)
        pitch = (side + 2) * TOGETHER
        columns = np.array([0, 1, 2] if each.stride == 1 else [0, side // 2 + 1, 1]) * TOGETHER
        rows = (np.arange(inputs)[:, None] * (side + 2) + np.arange(3)) * pitch
        is_last = i + 1 == len(convolutions)
        ring = 0 if is_last else 1
        made.append(
            _Layer(
                weights.reshape(blocks, TILE_ROWS, -1).transpose(0, 2, 1).reshape(-1),
                each.biases,
                np.array([each.stride * pitch, outputs, to_side]),
                (rows[:, :, None] + columns).reshape(-1),
                memories[i],
                np.arange(to_side) if is_last else _places(to_side, convolutions[i + 1].stride),
                np.array([to_side + 2 * ring, to_side + 2 * ring, ring]),
                memories[i + 1],
            )
        )
    return tuple(made)


def _hidden(layers: Layers) -> _Hidden:
    outputs, inputs = layers.hidden.shape
    weights, biases = np.zeros((_in_tiles(outputs), inputs), np.float32), np.zeros(_in_tiles(outputs))
    weights[:outputs], biases[:outputs] = layers.hidden, layers.hidden_biases
    blocks = weights.reshape(-1, TILE_COLUMNS, inputs).transpose(0, 2, 1)
    return _Hidden(blocks.reshape(-1), biases.astype(np.float32), np.arange(inputs) * TILE_COLUMNS)


@kernel()
def _forward(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    first_places: NDArray[np.int64],
    layers: tuple[_Layer, ...],
    sums: FloatArray,
    dense: _Hidden,
    hidden: FloatArray,
) -> None:
    """The hidden layer's numbers, one row a window, of (N, side * side * 3) windows."""
    inputs = layers[len(layers) - 1].target
    width, numbers = hidden.shape[1], hidden.reshape(-1)
    for first in range(0, len(hidden), TOGETHER):
        together = windows[first : first + TOGETHER]
        _normalise(together, side, least_contrast, first_places, layers[0].source)
        for number in range(len(layers)):
            _convolve(layers[number], sums)
        for column in range(0, width, TILE_COLUMNS):
            weights = column * len(dense.offsets)
            for n in range(0, TOGETHER, TILE_ROWS):
                to = (first + n) * width + column
                sum_products(dense.weights, weights, dense.offsets, inputs, n, TOGETHER, numbers, to, width)
    for n in range(len(hidden)):
        for i in range(width):
            hidden[n, i] = max(hidden[n, i] + dense.biases[i], np.float32(0))


@inner_kernel(no_alias=True)
def _normalise(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    places: NDArray[np.int64],
    out: FloatArray,
) -> None:
    """Each window without its brightness, over its contrast, beside the others."""
    count = len(windows)
    for n in range(count):
        total, squares = np.int64(0), np.int64(0)
        for i in range(windows.shape[1]):
            value = np.int64(windows[n, i])
            total += value
            squares += value * value
        mean = total / windows.shape[1]
        deviation = np.sqrt(max(squares / windows.shape[1] - mean * mean, 0.0))
        mean, scale = np.float32(mean), np.float32(1 / (deviation + least_contrast))
        for channel in range(3):
            for row in range(side):
                source, start = row * side * 3 + channel, (channel * (side + 2) + row + 1) * (side + 2)
                for column in range(side):
                    value = np.float32(windows[n, source + 3 * column])
                    out[(start + places[column]) * TOGETHER + n] = (value - mean) * scale


@inner_kernel()
def _convolve(layer: _Layer, sums: FloatArray) -> None:
    row_step, outputs, to_rows = layer.shape[0], layer.shape[1], layer.shape[2]
    numbers, pitch, block_size = sums.reshape(-1), sums.shape[1], TILE_ROWS * len(layer.offsets)
    for row in range(to_rows):
        for first in range(0, outputs, TILE_ROWS):
            weights = first // TILE_ROWS * block_size
            for x in range(0, len(layer.to) * TOGETHER, TILE_COLUMNS):
                start = row * row_step + x
                sum_products(
                    layer.source,
                    start,
                    layer.offsets,
                    layer.weights,
                    weights,
                    TILE_ROWS,
                    numbers,
                    x,
                    pitch,
                )
            for q in range(min(TILE_ROWS, outputs - first)):
                start = ((first + q) * layer.to_shape[0] + row + layer.to_shape[2]) * layer.to_shape[1]
                _put(sums, q, layer.biases[first + q], layer.to, start * TOGETHER, layer.target)


@inner_kernel(no_alias=True)
def _put(
    sums: FloatArray, which: int, bias: np.float32, places: NDArray[np.int64], start: int, target: FloatArray
) -> None:
    """A row of outputs to where the next layer looks for them."""
    for column in range(len(places)):
        source, to = np.uint64(column * TOGETHER), np.uint64(start + places[column] * TOGETHER)
        for lane in range(TOGETHER):
            n = np.uint64(lane)
            target[to + n] = max(sums[which, source + n] + bias, np.float32(0))
