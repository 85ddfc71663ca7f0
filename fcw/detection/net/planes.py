"""Convolutions of a whole picture's planes, in kernels of our own: in 0.6 of the time of OpenCV's dnn.

Where a convolution goes two columns and two rows a step, its planes are parted into four, of even and odd
rows and columns. All that one product of its sums takes from then lies side by side, from the first row of
outputs to the last: a plane is one long row of numbers to `fcw.kernels.products`, whatever its width. Sums
between the rows, of what lies around the planes, are made as well, and left where they are.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.onnx_layers import Convolution
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.jit import kernel
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, sum_products

FloatArray = NDArray[np.float32]


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
    """

    def __init__(self) -> None:
        self._numbers = aligned_zeros((0,), np.float32)

    def of(self, *shape: int) -> FloatArray:
        """An array at its beginning; it holds what was left there."""
        count = math.prod(shape)
        if count > len(self._numbers):
            self._numbers = aligned_zeros((count,), np.float32)
        return self._numbers[:count].reshape(shape)


class PlaneWeights:
    """A convolution's weights in the order in which they are read, for planes of any size.

    Attributes:
        inputs: planes that it takes.
        outputs: planes that it gives.
        stride: 1 or 2.
        weights: the outputs' in blocks of `TILE_ROWS`; in each the order is input, row, column, output.
        biases: (outputs,).
    """

    def __init__(self, convolution: Convolution) -> None:
        self.outputs, self.inputs = convolution.weights.shape[:2]
        self.stride = convolution.stride
        blocks = -(-self.outputs // TILE_ROWS)
        weights = np.zeros((blocks * TILE_ROWS, self.inputs * 9), np.float32)
        weights[: self.outputs] = convolution.weights.reshape(self.outputs, -1)
        self.weights = weights.reshape(blocks, TILE_ROWS, -1).transpose(0, 2, 1).reshape(-1)
        self.biases = convolution.biases.astype(np.float32)


class PlaneConvolution:
    """A convolution of planes of one size: one for each thread.

    Args:
        weights: of the convolution.
        height: of the planes; even where the convolution goes two rows a step.
        width: likewise.
        scratch: what it works in, with others of its thread.

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
            weights.weights,
            weights.biases,
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
    source: FloatArray,
    offsets: NDArray[np.int64],
    weights: FloatArray,
    biases: FloatArray,
    least: np.float32,
    sums: FloatArray,
    outputs: FloatArray,
) -> None:
    stride, pitch = geometry.stride, geometry.columns
    for part in range(len(planes) * stride**2):  # the ring of zeros, and what is written over right after
        start = part * geometry.rows * pitch
        last = start + (geometry.rows - 1) * pitch
        for column in range(pitch):
            source[start + column] = source[last + column] = 0
        for row in range(start, last, pitch):
            source[row] = source[row + pitch - 1] = 0
    for plane in range(len(planes)):
        for row in range(planes.shape[1]):
            part = (plane * stride + (row + 1) % stride) * stride
            at = (row + 1) // stride
            for first in range(stride):
                start = ((part + (first + 1) % stride) * geometry.rows + at) * pitch + (first + 1) // stride
                for column in range(planes.shape[2] // stride):
                    source[start + column] = planes[plane, row, first + stride * column]
    numbers, count = sums.reshape(-1), (geometry.to_rows - 1) * pitch + geometry.to_columns
    for block in range(0, geometry.outputs, TILE_ROWS):
        for first in range(0, count, TILE_COLUMNS):
            sum_products(
                source,
                first,
                offsets,
                weights,
                block * len(offsets),
                TILE_ROWS,
                numbers,
                first,
                sums.shape[1],
            )
        for q in range(min(TILE_ROWS, geometry.outputs - block)):
            bias = biases[block + q]
            for row in range(geometry.to_rows):
                for column in range(geometry.to_columns):
                    outputs[block + q, row, column] = max(sums[q, row * pitch + column] + bias, least)
