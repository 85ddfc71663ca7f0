"""Halved pictures against plain numpy and against OpenCV."""

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.detection.channels.halving import halve_rows
from fcw.kernels.jit import rows_of_bytes


def halved(picture: NDArray[np.uint8], first: int, end: int) -> NDArray[np.uint8]:
    """Rows of the picture halved by the kernel."""
    width = picture.shape[1] // 2
    out = np.empty(((end - first) // 2, 3 * width), np.uint8)
    halve_rows(rows_of_bytes(picture), first, np.empty(6 * width, np.uint16), out)
    return out.reshape(-1, width, 3)


@given(st.integers(1, 40), st.integers(2, 90), st.data())
def test_each_pixel_is_the_mean_of_four_rounded_half_up(pairs: int, width: int, data: st.DataObject) -> None:
    picture = np.random.default_rng(width).integers(0, 256, (2 * pairs + 1, width, 3), np.uint8)
    first = data.draw(st.integers(0, 2 * pairs - 1))
    end = first + 2 * data.draw(st.integers(1, (2 * pairs + 1 - first) // 2))
    four = picture[first:end, : width // 2 * 2].reshape((end - first) // 2, 2, width // 2, 2, 3).astype(int)
    np.testing.assert_array_equal(halved(picture, first, end), (four.sum(axis=(1, 3)) + 2) // 4)


def test_a_picture_is_halved_as_opencv_does_it() -> None:
    picture = np.random.default_rng(0).integers(0, 256, (48, 640, 3), np.uint8)
    expected = cv2.resize(picture, (320, 24), interpolation=cv2.INTER_AREA)
    np.testing.assert_array_equal(halved(picture, 0, 48), expected)
