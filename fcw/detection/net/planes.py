"""Convolutions of a whole picture's planes, in kernels of our own and in bytes.

Weights are bytes, each output's with a scale of its own, and so are the planes while they are convolved, with
one scale from the least to the largest number of the picture in hand; what comes out is float32 again (Jacob
et al. 2018). Nothing is learnt or measured for it, and on cameras left out as much is found as with float32.

Four planes lie in a word's bytes. Where a convolution goes two columns and two rows a step, the words are
parted into four parts, of even and odd rows and columns. All that one product of its sums takes from then
lies side by side, from the first row of outputs to the last: a part is one long row of words to
`fcw.kernels.products`, whatever its width. Sums between the rows, of what lies around the planes, are made as
well, and left where they are.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.onnx_layers import Convolution
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, WORD_BYTES, sum_products

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]


class _Geometry(NamedTuple):
    """Where a convolution's numbers lie.

    Attributes:
        stride: 1 or 2.
        rows: of a parted plane, with the ring of zeros.
        columns: likewise, and so elements from one of its rows to the next.
        outputs: planes of them.
        to_rows: of an output.
        to_columns: of an output.
    """

    stride: int
    rows: int
    columns: int
    outputs: int
    to_rows: int
    to_columns: int


class Scratch:
    """Numbers that one computation needs while it runs, and the next one may overwrite: for one thread.

    It is as large as the largest of them asked for.

    Args:
        dtype: of the numbers, four bytes each.
    """

    def __init__(self, dtype: type = np.float32) -> None:
        self._numbers = aligned_zeros((0,), dtype)

    def of(self, *shape: int) -> NDArray[Any]:
        """An array at its beginning; it holds what was left there."""
        count = math.prod(shape)
        if count > len(self._numbers):
            self._numbers = aligned_zeros((count,), self._numbers.dtype.type)
        return self._numbers[:count].reshape(shape)


class PlaneWeights:
    """A convolution's weights in bytes, in the order in which they are read, for planes of any size.

    Attributes:
        inputs: words of planes that it takes.
        outputs: planes that it gives.
        stride: 1 or 2.
        weights: the outputs' in blocks of `TILE_ROWS`; in each the order is word of inputs, row, column,
            output.
        scales: (outputs,) what one of a weight's steps is.
        totals: (outputs,) sums of the weights, in steps.
        biases: (outputs,).
    """

    def __init__(self, convolution: Convolution) -> None:
        self.outputs, inputs = convolution.weights.shape[:2]
        self.inputs, self.stride = -(-inputs // WORD_BYTES), convolution.stride
        steps, self.scales = in_bytes(convolution.weights.reshape(self.outputs, -1))
        self.totals = steps.sum(axis=1, dtype=np.float32)
        blocks = -(-self.outputs // TILE_ROWS)
        weights = np.zeros((blocks * TILE_ROWS, self.inputs * WORD_BYTES, 9), np.int8)
        weights[: self.outputs, :inputs] = steps.reshape(self.outputs, inputs, 9)
        words = weights.reshape(blocks, TILE_ROWS, self.inputs, WORD_BYTES, 9).transpose(0, 2, 4, 1, 3)
        self.weights = np.ascontiguousarray(words).reshape(-1).view(np.int32)
        self.biases = convolution.biases.astype(np.float32)


def in_bytes(weights: FloatArray) -> tuple[NDArray[np.int8], FloatArray]:
    """(outputs, inputs) weights in whole steps, 127 of which are an output's largest; and the steps."""
    scales = np.maximum(np.abs(weights).max(axis=1), np.float32(1e-30)) / np.float32(127)
    return np.rint(weights / scales[:, None]).astype(np.int8), scales


class PlaneConvolution:
    """A convolution of planes of one size: one for each thread.

    Args:
        weights: of the convolution.
        height: of the planes; even where the convolution goes two rows a step.
        width: likewise.
        scratch: what it works in, with others of its thread: of int32.

    Raises:
        ValueError: planes of this size cannot be halved.
    """

    def __init__(self, weights: PlaneWeights, height: int, width: int, scratch: Scratch) -> None:
        stride = weights.stride
        if height % stride or width % stride:
            raise ValueError(f"planes of {width}x{height}, which cannot be halved")
        self._weights, self._scratch = weights, scratch
        rows, columns = height // stride + 3 - stride, width // stride + 3 - stride
        self._geometry = _Geometry(stride, rows, columns, weights.outputs, height // stride, width // stride)
        places = np.arange(3)
        part = (
            np.arange(weights.inputs)[:, None, None] * stride + places[:, None] % stride
        ) * stride + places % stride
        inside = places[:, None] // stride * columns + places // stride
        self._offsets = (part * rows * columns + inside).reshape(-1)
        # In whole tiles, as both start on a cache line's boundary.
        self._source_count = _in_tiles(weights.inputs * stride**2 * rows * columns + TILE_COLUMNS)
        self._sums_pitch = _in_tiles(height // stride * columns)

    def __call__(self, planes: FloatArray, outputs: Scratch, least: float = 0.0) -> FloatArray:
        """(outputs, rows, columns) of (inputs, height, width) planes; `least` where they would be less.

        Args:
            planes: they may be in the memory of the outputs, and are overwritten then.
            outputs: memory for what is returned.
            least: no output is less.
        """
        geometry, weights = self._geometry, self._weights
        memory = self._scratch.of(self._source_count + TILE_ROWS * self._sums_pitch)
        convolved = outputs.of(geometry.outputs, geometry.to_rows, geometry.to_columns)
        _convolve(
            np.ascontiguousarray(planes, np.float32),
            geometry,
            memory[: self._source_count],
            self._offsets,
            (weights.weights, weights.scales, weights.totals, weights.biases),
            np.float32(least),
            memory[self._source_count :].reshape(TILE_ROWS, -1),
            convolved,
        )
        return convolved


def _in_tiles(count: int) -> int:
    """So many numbers, or as many more as fill the last tile."""
    return -(-count // TILE_COLUMNS) * TILE_COLUMNS


@kernel()
def _convolve(
    planes: FloatArray,
    geometry: _Geometry,
    source: WordArray,
    offsets: NDArray[np.int64],
    weights: tuple[WordArray, FloatArray, FloatArray, FloatArray],
    least: np.float32,
    sums: WordArray,
    outputs: FloatArray,
) -> None:
    pitch = geometry.columns
    weight_words, scales, totals, biases = weights
    step, zero = _put_in_bytes(planes, geometry.stride, geometry.rows, pitch, source)
    numbers, convolved = sums.reshape(-1), outputs.reshape(-1)
    count = (geometry.to_rows - 1) * pitch + geometry.to_columns
    for block in range(0, geometry.outputs, TILE_ROWS):
        for first in range(0, count, TILE_COLUMNS):
            sum_products(
                source,
                first,
                offsets,
                weight_words,
                block * len(offsets),
                TILE_ROWS,
                numbers,
                first,
                sums.shape[1],
            )
        for q in range(min(TILE_ROWS, geometry.outputs - block)):
            scale = step * scales[block + q]
            bias = biases[block + q] - scale * zero * totals[block + q]
            for row in range(geometry.to_rows):
                to = ((block + q) * geometry.to_rows + row) * geometry.to_columns
                start = q * sums.shape[1] + row * pitch
                _put_outputs(numbers, start, geometry.to_columns, scale, bias, least, convolved, to)


@inner_kernel(no_alias=True)
def _put_outputs(
    sums: WordArray,
    start: int,
    count: int,
    scale: np.float32,
    bias: np.float32,
    least: np.float32,
    outputs: FloatArray,
    to: int,
) -> None:
    for column in range(count):
        value = np.float32(sums[np.uint64(start + column)]) * scale + bias
        outputs[np.uint64(to + column)] = max(value, least)


@inner_kernel()
def least_and_largest(numbers: FloatArray) -> tuple[np.float32, np.float32]:
    """Of so many float32 and zero; by their bits, as of floats LLVM makes no SIMD code here.

    Bits of numbers from zero on are ordered as the numbers are; those below zero the other way round, and
    without a sign they come after all others.
    """
    high, low = np.int32(0), np.uint32(0)
    signed, unsigned = numbers.view(np.int32), numbers.view(np.uint32)
    for i in range(len(numbers)):
        high, low = max(high, signed[i]), max(low, unsigned[i])
    least, most = np.uint32(low), np.int32(high)  # numba views only what has one definition
    return min(least.view(np.float32), np.float32(0)), most.view(np.float32)


@inner_kernel(no_alias=True)
def _put_in_bytes(
    planes: FloatArray, stride: int, rows: int, pitch: int, source: WordArray
) -> tuple[np.float32, np.float32]:
    """Planes as bytes, parted, with a ring of zeros; returns what a step is, and which byte is zero."""
    low, high = least_and_largest(planes.reshape(-1))
    step = max(high - low, np.float32(1e-30)) / np.float32(255)
    inverse, zero = np.float32(1) / step, np.int32(np.rint(-low / step))
    offset = np.float32(zero) + np.float32(0.5)
    ring = np.int32(zero * 0x01010101)
    words = -(-len(planes) // WORD_BYTES)
    for part in range(words * stride**2):  # what is written over right after as well
        start = part * rows * pitch
        last = start + (rows - 1) * pitch
        for column in range(pitch):
            source[start + column] = source[last + column] = ring
        for row in range(start, last, pitch):
            source[row] = source[row + pitch - 1] = ring
    height, width = planes.shape[1:]
    numbers = planes.reshape(-1)
    for plane in range(len(planes)):
        word, byte = plane // WORD_BYTES, plane % WORD_BYTES
        for row in range(height):
            part, at = (word * stride + (row + 1) % stride) * stride, (row + 1) // stride
            for first in range(stride):
                to = ((part + (first + 1) % stride) * rows + at) * pitch + (first + 1) // stride
                start, count = (plane * height + row) * width + first, width // stride
                if stride == 1:
                    _put_row(numbers, start, 1, count, inverse, offset, byte, source, to)
                else:
                    _put_row(numbers, start, 2, count, inverse, offset, byte, source, to)
    return step, np.float32(zero)


@inner_kernel(no_alias=True)
def _put_row(
    numbers: FloatArray,
    start: int,
    stride: int,
    count: int,
    inverse: np.float32,
    offset: np.float32,
    byte: int,
    source: WordArray,
    to: int,
) -> None:
    """Every number, or every other one, as so manieth byte of words; the first one clears them."""
    bits, kept = np.int32(8 * byte), np.int32(-1 if byte else 0)
    for column in range(count):
        value = np.int32(numbers[np.uint64(start + stride * column)] * inverse + offset)
        place = np.uint64(to + column)
        source[place] = source[place] & kept | min(value, np.int32(255)) << bits
