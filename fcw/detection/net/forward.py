"""What a net says of many small windows, in kernels of our own: in less than half the time of OpenCV's dnn.

Windows lie side by side: the innermost axis of all memory is the window, so that a row of pixels of all
windows is one long row of numbers. A convolution then is a sum of such rows, each shifted and multiplied by
one weight, which the compiler turns into SIMD code however small the windows are. Four outputs are summed at
once, of three neighbouring columns: each number loaded is used four times, each sum three times before it is
stored again.

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

FloatArray = NDArray[np.float32]

AT_ONCE = 4
"""Outputs that are summed together."""
TAPS = 3
"""Columns of a convolution."""
MOST_TOGETHER = 24
"""Windows side by side: what a layer holds of so many stays in a core's own cache."""
STEP = 8
"""Windows side by side are a multiple of it: the numbers of a register."""
CHUNK = 48
"""Numbers of the hidden layer's inputs at once: their weights stay in the nearest cache."""


class _Layer(NamedTuple):
    """A convolution as the kernel reads it.

    Attributes:
        weights: (outputs / 4, 9 * inputs, 4), in the order input, row, column.
        biases: (outputs / 4, 4).
        shape: inputs, their padded rows and columns, stride, outputs and their rows.
        taps: (3,) columns of the row that the first output is summed from.
        source: what it looks at: inputs, rows, columns, windows.
        to: (columns,) places of its outputs in a row of `target`,
        to_shape: and that array's rows, columns, and first row.
        target: where its outputs go.
    """

    weights: FloatArray
    biases: FloatArray
    shape: NDArray[np.int64]
    taps: NDArray[np.int64]
    source: FloatArray
    to: NDArray[np.int64]
    to_shape: NDArray[np.int64]
    target: FloatArray


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
        self._layers = {
            together: _layers(layers.convolutions, sides, together)
            for together in range(STEP, MOST_TOGETHER + 1, STEP)
        }
        first = layers.convolutions[0]
        self._first_places = _places(side_px, first.stride)
        rows = -(-count // CHUNK) * CHUNK
        self._hidden_weights = np.zeros((rows, len(layers.hidden)), np.float32)
        self._hidden_weights[:count] = layers.hidden.T
        self._hidden_biases, self._output, self._output_biases = (
            layers.hidden_biases,
            np.ascontiguousarray(layers.output.T),
            layers.output_biases,
        )
        self._sums = aligned_zeros((AT_ONCE, MOST_TOGETHER * max(sides)), np.float32)
        self._scales = np.empty((2, MOST_TOGETHER), np.float32)

    def __call__(self, windows: NDArray[np.uint8]) -> FloatArray:
        """(N, outputs) of (N, side, side, 3) BGR windows, each seen as `normalised` shows it."""
        count = len(windows)
        flat = windows.reshape(count, -1)
        steps = -(-count // STEP)
        hidden = np.empty((steps * STEP, self._hidden_weights.shape[1]), np.float32)
        parts = -(-steps * STEP // MOST_TOGETHER)
        for part in range(parts):
            first, end = part * steps // parts * STEP, (part + 1) * steps // parts * STEP
            together = end - first
            _forward(
                flat[first:end],
                self._side_px,
                self._least_contrast,
                self._first_places,
                self._scales,
                self._layers[together],
                self._sums,
                self._hidden_weights,
                self._hidden_biases,
                hidden[first:end],
            )
        return hidden[:count] @ self._output + self._output_biases


def _places(columns: int, stride: int) -> NDArray[np.int64]:
    """(columns,) where in a row, which has one more on either side, a convolution wants its columns."""
    padded = np.arange(1, columns + 1)
    return padded if stride == 1 else padded % 2 * (columns // 2 + 1) + padded // 2


def _layers(convolutions: tuple[Convolution, ...], sides: list[int], together: int) -> tuple[_Layer, ...]:
    """The convolutions with memory for so many windows."""
    counts = [each.weights.shape[1] for each in convolutions]
    memories = [
        aligned_zeros((count * (side + 2) ** 2 * together,), np.float32)
        for count, side in zip(counts, sides, strict=False)
    ]
    last = len(convolutions[-1].weights) * sides[-1] ** 2
    memories.append(aligned_zeros((-(-last // CHUNK) * CHUNK * together,), np.float32))
    made = []
    for i, each in enumerate(convolutions):
        outputs, inputs = each.weights.shape[:2]
        side, to_side = sides[i], sides[i + 1]
        blocks = -(-outputs // AT_ONCE)
        weights = np.zeros((blocks * AT_ONCE, inputs * 3 * TAPS), np.float32)
        weights[:outputs] = each.weights.reshape(outputs, -1)
        biases = np.zeros(blocks * AT_ONCE, np.float32)
        biases[:outputs] = each.biases
        is_last = i + 1 == len(convolutions)
        ring = 0 if is_last else 1
        made.append(
            _Layer(
                np.ascontiguousarray(weights.reshape(blocks, AT_ONCE, -1).transpose(0, 2, 1)),
                biases.reshape(blocks, AT_ONCE),
                np.array([inputs, side + 2, side + 2, each.stride, outputs, to_side]),
                np.array([0, 1, 2] if each.stride == 1 else [0, side // 2 + 1, 1]),
                memories[i],
                np.arange(to_side) if is_last else _places(to_side, convolutions[i + 1].stride),
                np.array([to_side + 2 * ring, to_side + 2 * ring, ring]),
                memories[i + 1],
            )
        )
    return tuple(made)


@kernel()
def _forward(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    first_places: NDArray[np.int64],
    scales: FloatArray,
    layers: tuple[_Layer, ...],
    sums: FloatArray,
    hidden_weights: FloatArray,
    hidden_biases: FloatArray,
    hidden: FloatArray,
) -> None:
    """The hidden layer's numbers, (windows side by side, H), of (N, side * side * 3) windows."""
    together = len(hidden)
    _normalise(windows, side, least_contrast, first_places, together, scales, layers[0].source)
    for number in range(len(layers)):
        _convolve(layers[number], together, sums)
    inputs = layers[len(layers) - 1].target.reshape(-1, together)
    for n in range(together):
        for i in range(len(hidden_biases)):
            hidden[n, i] = hidden_biases[i]
    width, weights = len(hidden_biases), hidden_weights.reshape(-1)
    for chunk in range(0, len(hidden_weights), CHUNK):
        for n in range(0, together, AT_ONCE):
            sum0, sum1, sum2, sum3 = hidden[n], hidden[n + 1], hidden[n + 2], hidden[n + 3]
            for k in range(chunk, chunk + CHUNK, TAPS):
                start = k * width
                _add(weights, start, start + width, start + 2 * width, inputs, k, n, sum0, sum1, sum2, sum3)
    for n in range(together):
        for i in range(width):
            hidden[n, i] = max(hidden[n, i], np.float32(0))


@inner_kernel(no_alias=True)
def _normalise(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    places: NDArray[np.int64],
    together: int,
    scales: FloatArray,
    out: FloatArray,
) -> None:
    """Each window without its brightness, over its contrast, beside the others; the last one repeated."""
    count = len(windows)
    for n in range(count):
        total, squares = np.int64(0), np.int64(0)
        for i in range(windows.shape[1]):
            value = np.int64(windows[n, i])
            total += value
            squares += value * value
        mean = total / windows.shape[1]
        deviation = np.sqrt(max(squares / windows.shape[1] - mean * mean, 0.0))
        scales[0, n], scales[1, n] = mean, 1 / (deviation + least_contrast)
    pitch = (side + 2) * together
    for channel in range(3):
        for row in range(side):
            start = (channel * (side + 2) + row + 1) * pitch
            for column in range(side):
                source, to = (row * side + column) * 3 + channel, start + places[column] * together
                for n in range(count):
                    out[to + n] = (np.float32(windows[n, source]) - scales[0, n]) * scales[1, n]


@inner_kernel()
def _convolve(layer: _Layer, together: int, sums: FloatArray) -> None:
    inputs, rows, columns = layer.shape[0], layer.shape[1], layer.shape[2]
    stride, outputs, to_rows = layer.shape[3], layer.shape[4], layer.shape[5]
    pitch, length = columns * together, len(layer.to) * together
    tap0, tap1, tap2 = layer.taps[0] * together, layer.taps[1] * together, layer.taps[2] * together
    sum0, sum1, sum2, sum3 = sums[0, :length], sums[1, :length], sums[2, :length], sums[3, :length]
    source, target = layer.source, layer.target
    for row in range(to_rows):
        for block in range(len(layer.weights)):
            weights = layer.weights[block]
            _begin(layer.biases[block], sum0, sum1, sum2, sum3)
            for channel in range(inputs):
                for down in range(3):
                    start = (channel * rows + row * stride + down) * pitch
                    _add(
                        source,
                        start + tap0,
                        start + tap1,
                        start + tap2,
                        weights,
                        TAPS * (3 * channel + down),
                        0,
                        sum0,
                        sum1,
                        sum2,
                        sum3,
                    )
            for q in range(min(AT_ONCE, outputs - block * AT_ONCE)):
                output = block * AT_ONCE + q
                start = (output * layer.to_shape[0] + row + layer.to_shape[2]) * layer.to_shape[1]
                _put(sums, q, layer.to, together, start * together, target)


@inner_kernel(no_alias=True)
def _begin(
    biases: FloatArray, sum0: FloatArray, sum1: FloatArray, sum2: FloatArray, sum3: FloatArray
) -> None:
    """Four sums before anything is added."""
    bias0, bias1, bias2, bias3 = biases[0], biases[1], biases[2], biases[3]
    for i in range(len(sum0)):
        sum0[i], sum1[i], sum2[i], sum3[i] = bias0, bias1, bias2, bias3


@inner_kernel(no_alias=True)
def _put(
    sums: FloatArray, which: int, places: NDArray[np.int64], together: int, start: int, target: FloatArray
) -> None:
    """A row of outputs to where the next layer looks for them."""
    for column in range(len(places)):
        source, to = np.uint64(column * together), np.uint64(start + places[column] * together)
        for unit in range(together // STEP):
            for lane in range(STEP):  # of a fixed length: two instructions
                n = np.uint64(unit * STEP + lane)
                target[to + n] = max(sums[which, source + n], np.float32(0))


@inner_kernel(no_alias=True)
def _add(
    source: FloatArray,
    start0: int,
    start1: int,
    start2: int,
    weights: FloatArray,
    first: int,
    column: int,
    sum0: FloatArray,
    sum1: FloatArray,
    sum2: FloatArray,
    sum3: FloatArray,
) -> None:
    """Add three rows of `source` to four sums, times their weights: (3, 4) from `first` and `column` on."""
    w00, w01, w02, w03 = (
        weights[first, column],
        weights[first, column + 1],
        weights[first, column + 2],
        weights[first, column + 3],
    )
    w10, w11, w12, w13 = (
        weights[first + 1, column],
        weights[first + 1, column + 1],
        weights[first + 1, column + 2],
        weights[first + 1, column + 3],
    )
    w20, w21, w22, w23 = (
        weights[first + 2, column],
        weights[first + 2, column + 1],
        weights[first + 2, column + 2],
        weights[first + 2, column + 3],
    )
    at0, at1, at2 = np.uint64(start0), np.uint64(start1), np.uint64(start2)
    for x in range(len(sum0)):
        i = np.uint64(x)
        a, b, c = source[at0 + i], source[at1 + i], source[at2 + i]
        sum0[i] += w00 * a + w10 * b + w20 * c
        sum1[i] += w01 * a + w11 * b + w21 * c
        sum2[i] += w02 * a + w12 * b + w22 * c
        sum3[i] += w03 * a + w13 * b + w23 * c
