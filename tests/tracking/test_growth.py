"""Shift and scale of points by mathematics: exact ones, wrong ones among them, and their scatter."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.picture.growth import fit_growth


def scattered(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, 48, count) + 1j * rng.uniform(0, 40, count)


@given(scale=st.floats(0.7, 1.4), x=st.floats(-9, 9), y=st.floats(-9, 9), seed=st.integers(0, 99))
def test_shift_and_scale_are_found_though_a_third_of_the_points_is_elsewhere(scale, x, y, seed):
    before = scattered(24, seed)
    after = scale * before + complex(x, y)
    after[::3] += 6 * np.exp(1j * np.arange(8))
    growth = fit_growth(before, after, 1.0)
    assert growth is not None
    assert growth.scale == pytest.approx(scale, abs=1e-9)
    assert growth.shift == pytest.approx(complex(x, y), abs=1e-7)
    assert growth.agree == 16


def test_the_sigma_of_the_scale_is_how_much_it_scatters():
    before, rng = scattered(20), np.random.default_rng(1)
    logs, sigmas = [], []
    for _ in range(400):
        noise = 0.2 * (rng.standard_normal(20) + 1j * rng.standard_normal(20))
        growth = fit_growth(before, 1.05 * before + noise, 2.0)
        assert growth is not None
        logs.append(math.log(growth.scale))
        sigmas.append(growth.log_scale_sigma)
    assert np.std(logs) == pytest.approx(np.mean(sigmas), rel=0.1)
    assert np.mean(logs) == pytest.approx(math.log(1.05), abs=0.001)


@pytest.mark.parametrize("count", [0, 5])
def test_too_few_points_say_nothing(count):
    assert fit_growth(scattered(count), scattered(count), 1.0) is None


def test_points_that_go_apart_by_chance_say_nothing():
    assert fit_growth(scattered(20, 1), scattered(20, 2), 1.0) is None


def test_points_on_one_spot_say_nothing():
    assert fit_growth(np.full(9, 3 + 4j), np.full(9, 5 + 4j), 1.0) is None
