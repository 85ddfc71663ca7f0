"""Memory that starts where a cache line does."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fcw.kernels.aligned import LINE_BYTES, aligned_row, aligned_zeros


@given(st.integers(1, 5), st.integers(1, 300), st.sampled_from([np.uint8, np.int16, np.float32, np.float64]))
def test_every_row_starts_on_a_line(rows: int, count: int, dtype: type) -> None:
    row = aligned_row(count, dtype)
    array = aligned_zeros((rows, row), dtype)
    assert array.shape == (rows, row)
    assert array.dtype == dtype
    assert not array.any()
    assert count <= row < count + LINE_BYTES // array.itemsize
    assert all(line.ctypes.data % LINE_BYTES == 0 for line in array)


def test_arrays_are_of_their_own() -> None:
    first, second = aligned_zeros((4,), np.float32), aligned_zeros((4,), np.float32)
    first[:] = 1
    assert not second.any()
    assert first.all()
