"""Convolutions of a whole picture's planes, in kernels of our own: in 0.6 of the time of OpenCV's dnn.

Where a convolution goes two columns and two rows a step, its planes are parted into four, of even and odd
rows and columns. All that one product of its sums takes from then lies side by side, from the first row of
outputs to the last: a plane is one long row of numbers to `fcw.kernels.products`, whatever its width. Sums
between the rows, of what lies around the planes, are made as well, and left where they are.
"""

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


class PlaneConvolution:
    """A convolution of planes of one size, in memory it keeps: one for each thread.

    Args:
        convolution: its weights.
        height: of the planes; even where the convolution goes two rows a step.
        width: likewise.

    Raises:
        ValueError: planes of this size cannot be halved.
    """

    def __init__(self, convolution: Convolution, height: int, width: int) -> None:
        outputs, inputs = convolution.weights.shape[:2]
        stride = convolution.stride
        if height % stride or width % stride:
            raise ValueError(f"planes of {width}x{height}, which cannot be halved")
        rows, columns = height // stride + 3 - stride, width // stride + 3 - stride
        self._geometry = _Geometry(stride, rows, columns, outputs, height // stride, width // stride)
        parts = inputs * stride**2
        self._source = aligned_zeros((parts * rows * columns + TILE_COLUMNS,), np.float32)
        places = np.arange(3)
        part = (
            np.arange(inputs)[:, None, None] * stride + places[:, None] % stride
        ) * stride + places % stride
        inside = places[:, None] // stride * columns + places // stride
        self._offsets = (part * rows * columns + inside).reshape(-1)
        blocks = -(-outputs // TILE_ROWS)
        weights = np.zeros((blocks * TILE_ROWS, inputs * 9), np.float32)
        weights[:outputs] = convolution.weights.reshape(outputs, -1)
        self._weights = weights.reshape(blocks, TILE_ROWS, -1).transpose(0, 2, 1).reshape(-1)
        self._biases = convolution.biases.astype(np.float32)
        in_tiles = -(-self._geometry.to_rows * columns // TILE_COLUMNS) * TILE_COLUMNS
        self._sums = aligned_zeros((TILE_ROWS, in_tiles), np.float32)
        self._outputs = np.zeros((outputs, height // stride, width // stride), np.float32)

    def __call__(self, planes: FloatArray, least: float = 0.0) -> FloatArray:
        """(outputs, rows, columns) of (inputs, height, width) planes; `least` where they would be less.

        They are in memory that the next call overwrites.
        """
        geometry, outputs = self._geometry, self._outputs
        _convolve(
            np.ascontiguousarray(planes, np.float32),
            geometry,
            self._source,
            self._offsets,
            self._weights,
            self._biases,
            np.float32(least),
            self._sums,
            outputs,
        )
        return outputs


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
