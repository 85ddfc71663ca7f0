"""The small grey picture that own motion follows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.motion.flow.corners import small_grey


@given(st.integers(1, 7), st.integers(7, 40), st.integers(7, 60), st.integers(0, 1000))
def test_each_pixel_is_the_mean_of_the_green_ones_that_it_stands_for(factor, height, width, seed):
    picture = np.random.default_rng(seed).integers(0, 256, (height, width, 3)).astype(np.uint8)
    rows, columns = height // factor, width // factor
    green = picture[: rows * factor, : columns * factor, 1].reshape(rows, factor, columns, factor)
    assert small_grey(picture, factor) == pytest.approx(np.floor(green.mean(axis=(1, 3)) + 1e-9))


def test_the_brightest_picture_stays_as_bright():
    assert np.all(small_grey(np.full((80, 64, 3), 255, np.uint8), 16) == 255)
