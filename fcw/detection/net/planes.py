"""Convolutions of a whole picture's planes in 8-bit integers.

Weights are quantised to bytes with one scale for each output. The input planes are quantised to bytes, too,
with one scale from zero to their largest value; outputs are float32 again (Jacob et al. 2018). No training or
measurement is needed for it, and on cameras left out it finds as much as float32.

A word holds the bytes of four planes. For a convolution of stride 2, the words are split into four parts, of
even and odd rows and columns. The words that one product of all sums needs are then contiguous, from the
first row of outputs to the last: a part is one long row of words to `fcw.kernels.products`, whatever its
width. Sums between the rows, in the padding, are computed as well and then set to zero; each row of all
planes ends with `BEYOND` of these zeros.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.byte_weights import ByteWeights, in_tiles
from fcw.detection.net.row_pairs import (
    FILTERS,
    LOWER,
    PAIRS,
    UPPER,
    filter_rows,
    row_offsets,
    to_row_pairs,
)
from fcw.kernels.inner import inner_kernel
from fcw.kernels.products import (
    TILE_COLUMNS,
    TILE_ROWS,
    WORD_BYTES,
    sum_products,
    sum_products_of_pairs,
)

FloatArray = NDArray[np.float32]
WordArray = NDArray[np.int32]


BEYOND = 2
"""Zeros at the end of each row of planes: the padding to the right of it, and to the left of the next row."""
SUMMED = 16384
"""Number of squares of bytes that can be summed in 32 bits."""


class PlaneConvolution(NamedTuple):
    """A convolution for planes of one size, in the form that kernels read; made by `plane_convolution`.

    Attributes:
        weights: see `ByteWeights`.
        scales: (outputs,) see `ByteWeights`.
        totals: (outputs,) see `ByteWeights`.
        biases: (outputs,) see `ByteWeights`.
        offsets: offsets of the words of all products from the first one's.
        inputs: number of planes, rows and columns of the input.
        outputs: number of planes, rows and columns of the output.
        part_rows: number of rows of a part, including padding.
        stride: 1 or 2.
        by_row_pairs: whether two rows of outputs are computed at once.
    """

    weights: WordArray
    scales: FloatArray
    totals: FloatArray
    biases: FloatArray
    offsets: NDArray[np.int64]
    inputs: tuple[int, int, int]
    outputs: tuple[int, int, int]
    part_rows: int
    stride: int
    by_row_pairs: bool

    @property
    def word_count(self) -> int:
        """Number of words for its inputs, including those that tiles read beyond the end."""
        words, pitch = -(-self.inputs[0] // WORD_BYTES), self.outputs[2] + BEYOND
        filtered = FILTERS * PAIRS * -(-self.outputs[1] // 2) if self.by_row_pairs else 0
        return words * (self.stride**2 * self.part_rows + filtered) * pitch + TILE_COLUMNS + BEYOND

    @property
    def sum_count(self) -> int:
        """Number of sums that it needs memory for."""
        pitch = self.outputs[2] + BEYOND
        if self.by_row_pairs:
            return FILTERS * TILE_ROWS * in_tiles(-(-self.outputs[1] // 2) * pitch)
        return TILE_ROWS * in_tiles(self.outputs[1] * pitch)

    @property
    def output_count(self) -> int:
        """Number of output values, including padding."""
        count, rows, columns = self.outputs
        return count * rows * (columns + BEYOND)


def plane_convolution(weights: ByteWeights, height: int, width: int) -> PlaneConvolution:
    """Make a convolution for planes of a size.

    Raises:
        ValueError: the stride is 2, and planes of this size cannot be halved.
    """
    stride, words = weights.stride, -(-weights.inputs // WORD_BYTES)
    if height % stride or width % stride:
        raise ValueError(f"planes of {width}x{height}, which cannot be halved")
    part_rows, pitch = height // stride + 3 - stride, width // stride + BEYOND
    if weights.by_row_pairs:
        offsets = row_offsets(words, -(-height // 2), pitch)
    else:
        places = np.arange(3)
        part = (np.arange(words)[:, None, None] * stride + places[:, None] % stride) * stride
        inside = places[:, None] // stride * pitch + places // stride
        offsets = ((part + places % stride) * part_rows * pitch + inside).reshape(-1)
    return PlaneConvolution(
        weights.weights,
        weights.scales,
        weights.totals,
        weights.biases,
        offsets,
        (weights.inputs, height, width),
        (weights.outputs, height // stride, width // stride),
        part_rows,
        stride,
        weights.by_row_pairs,
    )


@inner_kernel()
def put_picture(
    picture: NDArray[np.uint8],
    convolution: PlaneConvolution,
    least_contrast: float,
    words: WordArray,
    work: WordArray,
) -> tuple[np.float32, np.float32]:
    """Write a picture as the input of a convolution of stride 2, for kernels to call.

    Args:
        picture: (height, width, 3), contiguous.
        convolution: the convolution.
        least_contrast: grey levels added to the picture's standard deviation.
        words: memory for the convolution's inputs, at least `word_count`.
        work: working memory, at least `sum_count`.

    Returns:
        Scale and zero point of the bytes, by which they stand for the picture with its mean subtracted and
        divided by its contrast.
    """
    mean, deviation = mean_and_deviation(picture.reshape(-1), 0, picture.size)
    _fill_ring(convolution, np.int32(np.rint(mean)) * np.int32(0x010101), words)
    _put_pixels(picture, work)
    _part(work, convolution.inputs, convolution.part_rows, 0, words)
    return np.float32(1.0 / (deviation + least_contrast)), np.float32(mean)


@inner_kernel()
def put_planes(
    planes: FloatArray, convolution: PlaneConvolution, words: WordArray, work: WordArray
) -> tuple[np.float32, np.float32]:
    """Write planes as bytes, as the input of a convolution, for kernels to call.

    Args:
        planes: flat, not negative; each row ends with `BEYOND` zeros.
        convolution: the convolution.
        words: memory for the convolution's inputs, at least `word_count`.
        work: working memory, at least `sum_count`.

    Returns:
        Scale and zero point of the bytes.
    """
    count, height, width = convolution.inputs
    size = height * (width + BEYOND)
    step = max(_largest(planes, count * size), np.float32(1e-30)) / np.float32(255)
    inverse = np.float32(1) / step
    _fill_ring(convolution, np.int32(0), words)
    for plane in range(count):
        word, byte = plane // WORD_BYTES, plane % WORD_BYTES
        if convolution.stride == 1:
            to = (word * convolution.part_rows + 1) * (width + BEYOND) + 1
            _put_bytes(planes, plane * size, size, inverse, byte, words, to)
        else:
            _put_bytes(planes, plane * size, size, inverse, byte, work, 0)
            if byte + 1 == WORD_BYTES or plane + 1 == count:
                _part(work, convolution.inputs, convolution.part_rows, word, words)
    return step, np.float32(0)


@inner_kernel()
def convolve(
    convolution: PlaneConvolution,
    step: np.float32,
    zero: np.float32,
    least: np.float32,
    words: WordArray,
    sums: WordArray,
    outputs: FloatArray,
) -> None:
    """Compute a convolution of inputs that were written as words, for kernels to call.

    Args:
        convolution: the convolution.
        step: scale of the inputs' bytes.
        zero: zero point of the inputs' bytes.
        least: lower bound of the outputs; 0 for a ReLU.
        words: the inputs.
        sums: working memory, at least `sum_count`. Like `words`, it begins at a cache line.
        outputs: memory for the outputs, at least `output_count`; each row ends with `BEYOND` zeros.
    """
    count, rows, columns = convolution.outputs
    pitch, size = columns + BEYOND, rows * (columns + BEYOND)
    if convolution.by_row_pairs:
        word_count = -(-convolution.inputs[0] // WORD_BYTES)
        filter_rows(words, word_count, convolution.part_rows, pitch, _filtered_at(convolution))
    for block in range(0, count, TILE_ROWS):
        if convolution.by_row_pairs:
            sums_pitch = _sum_row_pairs(convolution, block, words, sums)
        else:
            sums_pitch = _sum_rows(convolution, block, words, sums)
        for q in range(min(TILE_ROWS, count - block)):
            scale, to = step * convolution.scales[block + q], (block + q) * size
            bias = convolution.biases[block + q] - scale * zero * convolution.totals[block + q]
            if convolution.by_row_pairs:
                for row in range(rows):
                    start = ((LOWER if row % 2 else UPPER) * TILE_ROWS + q) * sums_pitch + row // 2 * pitch
                    _put_outputs(sums, start, pitch, scale, bias, least, outputs, to + row * pitch)
            else:
                _put_outputs(sums, q * sums_pitch, size, scale, bias, least, outputs, to)
    for row in range(count * rows):
        for beyond in range(columns, pitch):
            outputs[row * pitch + beyond] = 0


@inner_kernel()
def _sum_rows(convolution: PlaneConvolution, block: int, words: WordArray, sums: WordArray) -> int:
    """Sums of a block of outputs; returns the number of sums from one output's to the next one's."""
    _, rows, columns = convolution.outputs
    size, weights = rows * (columns + BEYOND), block * len(convolution.offsets)
    pitch = -(-size // TILE_COLUMNS) * TILE_COLUMNS
    for first in range(0, size - BEYOND, TILE_COLUMNS):
        sum_products(
            words, first, convolution.offsets, convolution.weights, weights, TILE_ROWS, sums, first, pitch
        )
    return pitch


@inner_kernel()
def _sum_row_pairs(convolution: PlaneConvolution, block: int, words: WordArray, sums: WordArray) -> int:
    """Like `_sum_rows`, for pairs of rows; see `fcw.detection.net.row_pairs`."""
    _, rows, columns = convolution.outputs
    size = (rows + 1) // 2 * (columns + BEYOND)
    pitch = -(-size // TILE_COLUMNS) * TILE_COLUMNS
    filter_size = -(-convolution.inputs[0] // WORD_BYTES) * PAIRS * size
    for each in range(FILTERS):
        source, target = _filtered_at(convolution) + each * filter_size, each * TILE_ROWS * pitch
        weights = (block * FILTERS + each * TILE_ROWS) * len(convolution.offsets)
        for first in range(0, size - BEYOND, TILE_COLUMNS):
            sum_products_of_pairs(
                words,
                source + first,
                convolution.offsets,
                convolution.weights,
                weights,
                TILE_ROWS,
                sums,
                target + first,
                pitch,
            )
    to_row_pairs(sums, 0, TILE_ROWS * pitch, TILE_ROWS * pitch)
    return pitch


@inner_kernel()
def _filtered_at(convolution: PlaneConvolution) -> int:
    """Where the output of `filter_rows` begins in the words, behind the bytes."""
    words = -(-convolution.inputs[0] // WORD_BYTES)
    return words * convolution.part_rows * (convolution.outputs[2] + BEYOND)


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
    for i in range(count):
        value = np.float32(sums[np.uint64(start + i)]) * scale + bias
        outputs[np.uint64(to + i)] = max(value, least)


@inner_kernel()
def mean_and_deviation(numbers: NDArray[np.uint8], start: int, count: int) -> tuple[float, float]:
    """Mean and standard deviation of `count` bytes from `start` on, for kernels to call."""
    total, squares = np.int64(0), np.int64(0)
    for first in range(start, start + count, SUMMED):
        some, some_squares = np.int32(0), np.int32(0)
        for i in range(first, min(first + SUMMED, start + count)):
            value = np.int32(numbers[np.uint64(i)])
            some += value
            some_squares += value * value
        total += some
        squares += some_squares
    mean = total / count
    return mean, math.sqrt(max(squares / count - mean * mean, 0.0))


@inner_kernel(no_alias=True)
def _put_pixels(picture: NDArray[np.uint8], words: WordArray) -> None:
    """Write one word per pixel; rows have room for the padding."""
    height, width, _ = picture.shape
    for row in range(height):
        start = row * (width + BEYOND)
        for column in range(width):
            low = np.int32(picture[row, column, 0]) | np.int32(picture[row, column, 1]) << np.int32(8)
            words[start + column] = low | np.int32(picture[row, column, 2]) << np.int32(16)


@inner_kernel()
def _fill_ring(convolution: PlaneConvolution, ring: np.int32, words: WordArray) -> None:
    """Fill the padding around the inputs, in all parts of the words."""
    rows, pitch = convolution.part_rows, convolution.outputs[2] + BEYOND
    parts = -(-convolution.inputs[0] // WORD_BYTES) * convolution.stride**2
    for start in range(0, parts * rows * pitch, rows * pitch):
        last = start + (rows - 1) * pitch
        for column in range(pitch):
            words[start + column] = words[last + column] = ring
        for row in range(start, last, pitch):
            words[row] = words[row + pitch - BEYOND] = words[row + pitch - 1] = ring


@inner_kernel()
def _largest(numbers: FloatArray, count: int) -> np.float32:
    """The largest of numbers that are not negative, by their bits, which have the same order.

    For the floats themselves, LLVM does not vectorise this loop.
    """
    bits, most = numbers.view(np.int32), np.int32(0)
    for i in range(count):
        most = max(most, bits[i])
    largest = np.int32(most)  # numba views only what has one definition
    return largest.view(np.float32)


@inner_kernel(no_alias=True)
def _put_bytes(
    numbers: FloatArray, start: int, count: int, inverse: np.float32, byte: int, words: WordArray, to: int
) -> None:
    """Write numbers as byte number `byte` of words; the first byte clears the words."""
    bits, kept = np.int32(8 * byte), np.int32(-1 if byte else 0)
    for i in range(count):
        value = np.int32(numbers[np.uint64(start + i)] * inverse + np.float32(0.5))
        place = np.uint64(to + i)
        words[place] = words[place] & kept | min(value, np.int32(255)) << bits


@inner_kernel(no_alias=True)
def _part(work: WordArray, shape: tuple[int, int, int], part_rows: int, word: int, words: WordArray) -> None:
    """Split a plane of words into even and odd rows and columns, inside the padding."""
    _, height, width = shape
    half, pitch = width // 2, width // 2 + BEYOND
    for row in range(height):
        start = row * (width + BEYOND)
        to = ((word * 4 + (row + 1) % 2 * 2) * part_rows + (row + 1) // 2) * pitch
        odd = to + part_rows * pitch
        for column in range(half):
            words[np.uint64(odd + column)] = work[np.uint64(start + 2 * column)]
        for column in range(half):
            words[np.uint64(to + column + 1)] = work[np.uint64(start + 2 * column + 1)]
