"""Linear equations within kernels."""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.inner import inner_kernel


@inner_kernel()
def eliminate(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> None:  # pragma: no cover - compiled
    """Solve `matrix` x = `right` for a positive definite matrix, by Gauss; x is left in `right`.

    Such a matrix needs no pivots. Its values are lost.
    """
    count = len(right)
    for pivot in range(count):
        for row in range(pivot + 1, count):
            part = matrix[row, pivot] / matrix[pivot, pivot]
            right[row] -= part * right[pivot]
            for column in range(pivot + 1, count):
                matrix[row, column] -= part * matrix[pivot, column]
    for row in range(count - 1, -1, -1):
        for column in range(row + 1, count):
            right[row] -= matrix[row, column] * right[column]
        right[row] /= matrix[row, row]
