"""How windows are shown to the net."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.net.look import LEAST_CONTRAST, normalised


@given(st.floats(0.4, 1.0), st.floats(0.0, 100.0), st.integers(0, 1000))
def test_haze_and_exposure_change_little_of_what_the_net_sees(clear, air, seed):
    # Koschmieder: clear * colour + air, here without rounding to keep the law exact.
    windows = np.random.default_rng(seed).uniform(0, 150, (2, 24, 24, 3))
    hazy = clear * windows + air
    seen, seen_hazy = (normalised(each.astype(np.float32)) for each in (windows, hazy))  # pyright: ignore[reportArgumentType]
    deviation = windows.reshape(2, -1).std(axis=1)
    faded = clear * (deviation + LEAST_CONTRAST) / (clear * deviation + LEAST_CONTRAST)
    assert seen_hazy == pytest.approx(seen * faded[:, None, None, None], abs=1e-3)
    assert faded.min() > 0.8  # nearly nothing is lost, down to 0.4 of the light


def test_a_plain_wall_stays_plain():
    wall = np.full((1, 24, 24, 3), 90, np.uint8)
    wall[:, ::2] += 1
    assert np.abs(normalised(wall)).max() <= 0.5 / LEAST_CONTRAST


def test_the_net_is_given_channels_first():
    windows = np.zeros((1, 24, 24, 3), np.uint8)
    windows[0, 3, 5, 2] = 255
    given_ = normalised(windows)
    assert given_.shape == (1, 3, 24, 24)
    assert np.unravel_index(np.argmax(given_[0]), (3, 24, 24)) == (2, 3, 5)
