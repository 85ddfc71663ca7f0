"""Weights of convolutions as bytes, in the order in which the kernels read them.

The weights of each output have their own scale (Jacob et al. 2018). No training or measurement is needed for
it.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.net.onnx_layers import Convolution
from fcw.detection.net.row_pairs import ROW_PAIRS_PAY, row_weights
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, WORD_BYTES, as_weights

FloatArray = NDArray[np.float32]


class ByteWeights:
    """A convolution's weights as bytes, in the order in which they are read, for inputs of any size.

    Args:
        convolution: the convolution.
        by_row_pairs: whether two rows of outputs are computed at once if its stride is 1
            (`fcw.detection.net.row_pairs`).

    Attributes:
        inputs: number of input planes.
        outputs: number of output planes.
        stride: 1 or 2.
        by_row_pairs: whether two rows of outputs are computed at once.
        weights: in blocks of `TILE_ROWS` outputs. In each block, the order is word of inputs, row, column,
            output, or that of `row_weights`.
        scales: (outputs,) value of one step of a weight.
        totals: (outputs,) sum of the weights, in steps.
        biases: (outputs,) biases.
    """

    def __init__(self, convolution: Convolution, by_row_pairs: bool = ROW_PAIRS_PAY) -> None:
        self.outputs, self.inputs = convolution.weights.shape[:2]
        self.stride = convolution.stride
        self.by_row_pairs = by_row_pairs and self.stride == 1
        steps, self.scales = in_bytes(convolution.weights.reshape(self.outputs, -1))
        self.totals = steps.sum(axis=1, dtype=np.float32)
        blocks, words = -(-self.outputs // TILE_ROWS), -(-self.inputs // WORD_BYTES)
        weights = np.zeros((blocks * TILE_ROWS, words * WORD_BYTES, 9), np.int8)
        weights[: self.outputs, : self.inputs] = steps.reshape(self.outputs, self.inputs, 9)
        if self.by_row_pairs:
            self.weights = row_weights(weights.reshape(*weights.shape[:2], 3, 3))
        else:
            ordered = weights.reshape(blocks, TILE_ROWS, words, WORD_BYTES, 9).transpose(0, 2, 4, 1, 3)
            self.weights = as_weights(ordered)
        self.biases = convolution.biases.astype(np.float32)


def in_bytes(weights: FloatArray) -> tuple[NDArray[np.int8], FloatArray]:
    """(outputs, inputs) weights in steps, and each output's step, 127 of which are its largest weight."""
    scales = np.maximum(np.abs(weights).max(axis=1), np.float32(1e-30)) / np.float32(127)
    return np.rint(weights / scales[:, None]).astype(np.int8), scales


def in_tiles(count: int) -> int:
    """A count rounded up to whole tiles."""
    return -(-count // TILE_COLUMNS) * TILE_COLUMNS
