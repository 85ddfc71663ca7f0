"""Forward pass of a net over many small windows, in 8-bit integers.

`TOGETHER` windows are computed together. The innermost axis of all memory is the window, so that a row of
pixels of these windows is one long row of words. A convolution is then a sum of such rows, each shifted and
multiplied by one word of weights, which fills the widest registers however small the windows are
(`fcw.kernels.products`). And a layer of so few windows stays in a core's own cache.

As in `fcw.detection.net.planes`, weights and activations are bytes, with four planes in a word. Each window
has its own scale, so that its result does not depend on the windows beside it.

Each layer's activations have zero padding around them. For a convolution of stride 2, the columns of a row
are reordered, first the even, then the odd ones, so that the words of a sum are contiguous.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.byte_weights import in_tiles
from fcw.detection.net.onnx_layers import Layers
from fcw.detection.net.planes import mean_and_deviation
from fcw.detection.net.row_pairs import FILTERS, LOWER, PAIRS, ROW_PAIRS_PAY, UPPER, filter_rows, to_row_pairs
from fcw.detection.net.window_layers import (
    TOGETHER,
    HiddenLayer,
    Target,
    WindowLayer,
    hidden_layer,
    last_target,
    places_in_row,
    target_of,
    window_layer,
)
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel
from fcw.kernels.products import (
    TILE_COLUMNS,
    TILE_ROWS,
    WORD_BYTES,
    sum_products,
    sum_products_of_pairs,
    sum_products_of_signed,
)

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]


class _Work(NamedTuple):
    """Working memory of the kernel.

    Attributes:
        sums: (`FILTERS`, TILE_ROWS, at least a row of outputs) sums of a convolution.
        values: outputs of a convolution: planes, rows, columns, windows.
        largest: (columns, windows) largest outputs, flat.
        steps: (columns, windows) scale of the bytes of each window, the same in all columns, flat.
        inverses: (columns, windows) one over `steps`, flat.
        zeros: (columns, windows) zero point of the bytes, flat.
    """

    sums: WordArray
    values: FloatArray
    largest: FloatArray
    steps: FloatArray
    inverses: FloatArray
    zeros: FloatArray


class ForwardPass:
    """A net for windows of one size. It owns working memory, so each thread needs its own.

    Args:
        layers: the layers of the net.
        side_px: side of the windows.
        least_contrast: grey levels added to the contrast; see `fcw.detection.net.look.normalised`.
        by_row_pairs: see `ByteWeights`.

    Raises:
        ValueError: windows of this size do not fit the layers.
    """

    def __init__(
        self, layers: Layers, side_px: int, least_contrast: float, by_row_pairs: bool = ROW_PAIRS_PAY
    ) -> None:
        self._side_px, self._least_contrast = side_px, np.float32(least_contrast)
        sides = [side_px]
        for each in layers.convolutions:
            if sides[-1] % each.stride:
                raise ValueError(f"windows of {side_px} px, which the net cannot halve so often")
            sides.append(sides[-1] // each.stride)
        outputs = [len(each.weights) for each in layers.convolutions]
        if layers.hidden.shape[1] != outputs[-1] * sides[-1] ** 2:
            raise ValueError(f"a net for other windows than of {side_px} px")
        self._layers = tuple(
            window_layer(each, side, by_row_pairs)
            for each, side in zip(layers.convolutions, sides, strict=False)
        )
        self._first_places = places_in_row(side_px, layers.convolutions[0].stride)
        self._targets = (
            *map(target_of, self._layers[1:], layers.convolutions[1:], sides[1:]),
            last_target(outputs[-1], sides[-1]),
        )
        self._hidden = hidden_layer(layers, outputs[-1])
        self._hidden_count = len(layers.hidden)
        self._output, self._output_biases = np.ascontiguousarray(layers.output.T), layers.output_biases
        row, most = (
            TOGETHER * max(sides),
            max(n * side**2 for n, side in zip(outputs, sides[1:], strict=True)),
        )
        self._work = _Work(
            aligned_zeros((FILTERS, TILE_ROWS, in_tiles(row)), np.int32),
            aligned_zeros((most * TOGETHER,), np.float32),
            *(aligned_zeros((row,), np.float32) for _ in range(4)),
        )

    def __call__(self, windows: NDArray[np.uint8]) -> FloatArray:
        """(N, outputs) of (N, side, side, 3) BGR windows, which are normalised as by `normalised`."""
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


@kernel()
def _forward(
    windows: NDArray[np.uint8],
    side: int,
    least_contrast: np.float32,
    first_places: NDArray[np.int64],
    layers: tuple[WindowLayer, ...],
    targets: tuple[Target, ...],
    dense: HiddenLayer,
    work: _Work,
    hidden: FloatArray,
) -> None:
    """Compute the hidden layer, one row per window, of (N, side * side * 3) windows."""
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
    """Write windows as interleaved words, with the scale and zero point that normalise each of them."""
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
def _convolve(layer: WindowLayer, work: _Work) -> None:
    to_rows, width = layer.shape[1], layer.shape[2] * TOGETHER
    numbers, pitch = work.sums.reshape(-1), work.sums.shape[2]
    work.largest[:width] = 0
    if layer.filtered:
        words = len(layer.offsets) // (3 * PAIRS)
        filter_rows(layer.source, words, to_rows + 2, layer.shape[0], layer.filtered)
    at_once = 2 if layer.filtered else 1
    for row in range(0, to_rows, at_once):
        for first in range(0, len(layer.biases), TILE_ROWS):
            if layer.filtered:
                _sum_row_pair(layer, row // 2, first, width, numbers, pitch)
            else:
                _sum_row(layer, row, first, width, numbers, pitch)
            for q in range(min(TILE_ROWS, len(layer.biases) - first)):
                number = first + q
                for below in range(min(at_once, to_rows - row)):
                    _put(
                        numbers,
                        ((LOWER if below else UPPER) * TILE_ROWS + q) * pitch,
                        (layer.scales[number], layer.totals[number], layer.biases[number]),
                        work.steps,
                        work.zeros,
                        width,
                        work.largest,
                        work.values,
                        (number * to_rows + row + below) * width,
                    )


@inner_kernel()
def _sum_row(layer: WindowLayer, row: int, first: int, width: int, sums: WordArray, pitch: int) -> None:
    """Sum up a row of a block of outputs, which begins with output `first`."""
    source, weights = row * layer.shape[0], first * len(layer.offsets)
    for x in range(0, width, TILE_COLUMNS):
        sum_products(
            layer.source, source + x, layer.offsets, layer.weights, weights, TILE_ROWS, sums, x, pitch
        )


@inner_kernel()
def _sum_row_pair(layer: WindowLayer, pair: int, first: int, width: int, sums: WordArray, pitch: int) -> None:
    """Like `_sum_row`, for two rows; see `fcw.detection.net.row_pairs`."""
    size = len(layer.offsets) // 3 * ((layer.shape[1] + 1) // 2) * layer.shape[0]
    for each in range(FILTERS):
        source = layer.filtered + each * size + pair * layer.shape[0]
        weights = (first * FILTERS + each * TILE_ROWS) * len(layer.offsets)
        target = each * TILE_ROWS * pitch
        for x in range(0, width, TILE_COLUMNS):
            sum_products_of_pairs(
                layer.source,
                source + x,
                layer.offsets,
                layer.weights,
                weights,
                TILE_ROWS,
                sums,
                target + x,
                pitch,
            )
    for q in range(TILE_ROWS):
        to_row_pairs(sums, q * pitch, TILE_ROWS * pitch, width)


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
    """Write a row of outputs, and update the largest ones."""
    scale, total, bias = weights
    for i in range(count):
        x = np.uint64(i)
        above = np.float32(sums[np.uint64(source + i)]) - zeros[x] * total
        value = max(above * (steps[x] * scale) + bias, np.float32(0))
        values[np.uint64(to + i)] = value
        largest[x] = max(largest[x], value)


@inner_kernel()
def _put_in_bytes(layer: WindowLayer, work: _Work, target: Target) -> None:
    """Write a convolution's outputs as bytes, as the input of the next layer."""
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
    """Write a row of numbers as byte number `byte` of words; the first byte clears the words."""
    bits, kept = np.int32(8 * byte), np.int32(-1 if byte else 0)
    for i in range(count):
        x = np.uint64(i)
        value = np.int32(values[np.uint64(start + i)] * inverses[x] + np.float32(0.5))
        words[x] = words[x] & kept | min(value, np.int32(255)) << bits


@inner_kernel(no_alias=True)
def _put_row(row: WordArray, places: NDArray[np.int64], words: WordArray, to: int) -> None:
    """Write a row of words to the places of its columns."""
    for column in range(len(places)):
        source, place = np.uint64(column * TOGETHER), np.uint64(to + places[column] * TOGETHER)
        for lane in range(TOGETHER):
            words[place + np.uint64(lane)] = row[source + np.uint64(lane)]
