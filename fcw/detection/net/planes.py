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
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, WORD_BYTES, sum_products

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]


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
        inputs: planes that it takes.
        outputs: planes that it gives.
        stride: 1 or 2.
        weights: the outputs' in blocks of `TILE_ROWS`; in each the order is word of inputs, row, column,
            output.
        scales: (outputs,) what one of a weight's steps is.
        totals: (outputs,) sums of the weights, in steps.
        biases: (outputs,).
    """

    def __init__(self, convolution: Convolution) -> None:
        self.outputs, self.inputs = convolution.weights.shape[:2]
        self.stride = convolution.stride
        steps, self.scales = in_bytes(convolution.weights.reshape(self.outputs, -1))
        self.totals = steps.sum(axis=1, dtype=np.float32)
        blocks, words = -(-self.outputs // TILE_ROWS), -(-self.inputs // WORD_BYTES)
        weights = np.zeros((blocks * TILE_ROWS, words * WORD_BYTES, 9), np.int8)
        weights[: self.outputs, : self.inputs] = steps.reshape(self.outputs, self.inputs, 9)
        ordered = weights.reshape(blocks, TILE_ROWS, words, WORD_BYTES, 9).transpose(0, 2, 4, 1, 3)
        self.weights = np.ascontiguousarray(ordered).reshape(-1).view(np.int32)
        self.biases = convolution.biases.astype(np.float32)


def in_bytes(weights: FloatArray) -> tuple[NDArray[np.int8], FloatArray]:
    """(outputs, inputs) weights in whole steps, 127 of which are an output's largest; and the steps."""
    scales = np.maximum(np.abs(weights).max(axis=1), np.float32(1e-30)) / np.float32(127)
    return np.rint(weights / scales[:, None]).astype(np.int8), scales


class PlaneConvolution(NamedTuple):
    """A convolution of planes of one size, as kernels read it; `plane_convolution` makes it.

    Attributes:
        weights: as of `PlaneWeights`, and likewise the three next ones.
        scales: (outputs,)
        totals: (outputs,)
        biases: (outputs,).
        offsets: where its products find their words, from the first one's.
        inputs: planes, rows and columns that it takes.
        outputs: planes, rows and columns that it gives.
        part: rows and columns of a part, with the ring of zeros.
        stride: 1 or 2.
    """

    weights: WordArray
    scales: FloatArray
    totals: FloatArray
    biases: FloatArray
    offsets: NDArray[np.int64]
    inputs: tuple[int, int, int]
    outputs: tuple[int, int, int]
    part: tuple[int, int]
    stride: int

    @property
    def word_count(self) -> int:
        """Words that it needs for its inputs, and what tiles read beyond."""
        words = -(-self.inputs[0] // WORD_BYTES)
        return words * self.stride**2 * math.prod(self.part) + TILE_COLUMNS

    @property
    def sum_count(self) -> int:
        """Sums that it needs room for."""
        return TILE_ROWS * in_tiles(self.outputs[1] * self.part[1])


def plane_convolution(weights: PlaneWeights, height: int, width: int) -> PlaneConvolution:
    """A convolution of planes of a size.

    Raises:
        ValueError: planes of this size cannot be halved.
    """
    stride, words = weights.stride, -(-weights.inputs // WORD_BYTES)
    if height % stride or width % stride:
        raise ValueError(f"planes of {width}x{height}, which cannot be halved")
    rows, columns = height // stride + 3 - stride, width // stride + 3 - stride
    places = np.arange(3)
    part = (np.arange(words)[:, None, None] * stride + places[:, None] % stride) * stride + places % stride
    inside = places[:, None] // stride * columns + places // stride
    return PlaneConvolution(
        weights.weights,
        weights.scales,
        weights.totals,
        weights.biases,
        (part * rows * columns + inside).reshape(-1),
        (weights.inputs, height, width),
        (weights.outputs, height // stride, width // stride),
        (rows, columns),
        stride,
    )


def in_tiles(count: int) -> int:
    """So many numbers, or as many more as fill the last tile."""
    return -(-count // TILE_COLUMNS) * TILE_COLUMNS


@inner_kernel()
def convolve(
    planes: FloatArray,
    convolution: PlaneConvolution,
    least: np.float32,
    words: WordArray,
    sums: WordArray,
    outputs: FloatArray,
) -> None:
    """A convolution of planes, for kernels to call.

    Args:
        planes: flat, what it takes.
        convolution: of what size they are and what is made of them.
        least: no output is less.
        words: flat memory to work in, at least `word_count`.
        sums: likewise `sum_count`; both start where a cache line does.
        outputs: flat memory for what it gives; it may be the planes' own.
    """
    count, to_rows, to_columns = convolution.outputs
    pitch, weight_count = convolution.part[1], TILE_ROWS * len(convolution.offsets)
    step, zero = _put_in_bytes(planes, convolution.inputs, convolution.stride, convolution.part, words)
    length = (to_rows - 1) * pitch + to_columns
    sums_pitch = -(-length // TILE_COLUMNS) * TILE_COLUMNS
    for block in range(0, count, TILE_ROWS):
        for first in range(0, length, TILE_COLUMNS):
            sum_products(
                words,
                first,
                convolution.offsets,
                convolution.weights,
                block // TILE_ROWS * weight_count,
                TILE_ROWS,
                sums,
                first,
                sums_pitch,
            )
        for q in range(min(TILE_ROWS, count - block)):
            scale = step * convolution.scales[block + q]
            bias = convolution.biases[block + q] - scale * zero * convolution.totals[block + q]
            for row in range(to_rows):
                to = ((block + q) * to_rows + row) * to_columns
                start = q * sums_pitch + row * pitch
                _put_outputs(sums, start, to_columns, scale, bias, least, outputs, to)


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
def least_and_largest(numbers: FloatArray, count: int) -> tuple[np.float32, np.float32]:
    """Of the first so many numbers and zero; by their bits, as of floats LLVM makes no SIMD code here.

    Bits of numbers from zero on are ordered as the numbers are; those below zero the other way round, and
    without a sign they come after all others.
    """
    high, low = np.int32(0), np.uint32(0)
    signed, unsigned = numbers.view(np.int32), numbers.view(np.uint32)
    for i in range(count):
        high, low = max(high, signed[i]), max(low, unsigned[i])
    least, most = np.uint32(low), np.int32(high)  # numba views only what has one definition
    return min(least.view(np.float32), np.float32(0)), most.view(np.float32)


@inner_kernel(no_alias=True)
def _put_in_bytes(
    planes: FloatArray,
    shape: tuple[int, int, int],
    stride: int,
    part_shape: tuple[int, int],
    source: WordArray,
) -> tuple[np.float32, np.float32]:
    """Planes as bytes, parted, with a ring of zeros; returns what a step is, and which byte is zero."""
    count, height, width = shape
    rows, pitch = part_shape
    low, high = least_and_largest(planes, count * height * width)
    step = max(high - low, np.float32(1e-30)) / np.float32(255)
    inverse, zero = np.float32(1) / step, np.int32(np.rint(-low / step))
    offset = np.float32(zero) + np.float32(0.5)
    ring = np.int32(zero * 0x01010101)
    words = -(-count // WORD_BYTES)
    for part in range(words * stride**2):  # what is written over right after as well
        start = part * rows * pitch
        last = start + (rows - 1) * pitch
        for column in range(pitch):
            source[start + column] = source[last + column] = ring
        for row in range(start, last, pitch):
            source[row] = source[row + pitch - 1] = ring
    for plane in range(count):
        word, byte = plane // WORD_BYTES, plane % WORD_BYTES
        for row in range(height):
            part, at = (word * stride + (row + 1) % stride) * stride, (row + 1) // stride
            for first in range(stride):
                to = ((part + (first + 1) % stride) * rows + at) * pitch + (first + 1) // stride
                start, columns = (plane * height + row) * width + first, width // stride
                if stride == 1:
                    _put_row(planes, start, 1, columns, inverse, offset, byte, source, to)
                else:
                    _put_row(planes, start, 2, columns, inverse, offset, byte, source, to)
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
