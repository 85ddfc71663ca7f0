"""Memory for the kernels that starts on a cache line's boundary.

The widest registers are as long as a cache line. Loads and stores that straddle two lines cost twice, and
where a row starts in the middle of a line all of them do: summing up the orientations takes half the time
with rows that start where a line does. NumPy promises 16 bytes.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

LINE_BYTES = 64


def aligned_zeros(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray:
    """An array of zeros that starts on a cache line's boundary."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.zeros(size + LINE_BYTES, np.uint8)
    first = -memory.ctypes.data % LINE_BYTES
    return memory[first : first + size].view(dtype).reshape(shape)


def aligned_row(count: int, dtype: DTypeLike) -> int:
    """Elements from a row of so many to the next, for each to start on a cache line's boundary."""
    per_line = LINE_BYTES // np.dtype(dtype).itemsize
    return -(-count // per_line) * per_line


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
