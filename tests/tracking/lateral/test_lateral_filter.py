"""The filter of lateral positions: unbiased, honest about its sigmas, slower where the noise is larger."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.across.lateral_filter import JERKINESS_M2PS3, RATE_SIGMA_MPS, LateralFilter


def settled(sigma_m, rate_mps, seed, dt_s=1 / 30, seconds=3.0):
    rng = np.random.default_rng(seed)
    found = LateralFilter(rng.normal(0, sigma_m), sigma_m)
    time_s = 0.0
    while time_s < seconds:
        time_s += dt_s
        found.predict(dt_s)
        found.correct(rate_mps * time_s + rng.normal(0, sigma_m), sigma_m)
    return found, rate_mps * time_s


@pytest.mark.parametrize("sigma_m", [0.02, 0.2])
def test_a_steady_motion_is_found_without_bias(sigma_m):
    rates = [settled(sigma_m, 0.8, seed)[0].rate_mps for seed in range(200)]
    assert np.mean(rates) == pytest.approx(0.8, abs=0.05)


def test_its_sigmas_are_those_of_motions_as_it_believes_in():
    dt_s, sigma_m, errors = 1 / 30, 0.1, []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        place = rate = 0.0
        found = LateralFilter(rng.normal(0, sigma_m), sigma_m)
        for _ in range(90):
            place += rate * dt_s
            rate += rng.normal(0, np.sqrt(JERKINESS_M2PS3 * dt_s))
            found.predict(dt_s)
            found.correct(place + rng.normal(0, sigma_m), sigma_m)
        off_m, off_mps = found.lateral_m - place, found.rate_mps - rate
        errors.append((off_m / found.sigma_m, off_mps / found.rate_sigma_mps))
    spread = np.std(np.array(errors), axis=0)
    assert spread == pytest.approx([1.0, 1.0], abs=0.12)


def test_the_noisier_the_boxes_the_longer_it_averages():
    near, _ = settled(0.02, 0.0, 0)
    far, _ = settled(0.3, 0.0, 0)
    assert near.rate_sigma_mps < far.rate_sigma_mps < 0.6
    assert near.sigma_m < far.sigma_m < 0.3


def test_a_jump_of_what_is_followed_is_no_motion():
    # Another part of it is boxed from here on, half a metre aside: in a tenth of a second, 5 m/s.
    found, place_m = settled(0.05, 0.3, 0)
    before_mps, sigma_mps = found.rate_mps, found.rate_sigma_mps
    for step in range(1, 11):
        found.predict(0.1)
        found.correct(place_m + 0.5 + 0.03 * step, 0.05)
        assert found.lateral_m == pytest.approx(place_m + 0.5 + 0.03 * step, abs=0.1)
        assert found.rate_mps == pytest.approx(before_mps, abs=2.5 * sigma_mps)


def test_after_two_jumps_in_a_row_its_rate_is_known_no_better_than_at_first():
    found, place_m = settled(0.05, 0.0, 0)
    for jumped_m, sigma_mps in ((0.8, found.rate_sigma_mps), (1.6, RATE_SIGMA_MPS)):
        found.predict(0.1)
        found.correct(place_m + jumped_m, 0.05)
        assert found.rate_sigma_mps == pytest.approx(sigma_mps, rel=0.5)


@pytest.mark.parametrize("rate_mps", [-10.0, 5.0, 10.0])
def test_who_crosses_fast_when_it_is_found_is_seen_to_do_so_in_a_third_of_a_second(rate_mps):
    found, _ = settled(0.1, rate_mps, 1, dt_s=0.1, seconds=0.3)
    assert found.rate_mps == pytest.approx(rate_mps, rel=0.25)


def test_what_stands_beside_our_way_does_not_seem_to_come_in_where_its_closing_speed_is_too_high():
    # Parked 2.4 m aside; we drive at 6 m/s, 7.5 are believed, so that its distance is mended in each frame.
    found, dt_s, lag = LateralFilter(-2.4, 0.05), 1 / 30, 0.96
    for distance_m in np.arange(20.0, 5.0, -6.0 * dt_s):
        expected_m = lag * distance_m - 7.5 * dt_s
        found.predict(dt_s)
        found.scale(lag * (distance_m - 6.0 * dt_s) / expected_m)
        found.correct(-2.4, 0.05)
    assert abs(found.rate_mps) < 0.6  # 0.74 if all of it counted as wrong before


@given(st.lists(st.floats(-8.0, 8.0), min_size=2, max_size=60), st.floats(-1.0, 1.0))
def test_what_is_learnt_of_its_motion_is_the_same_however_we_turn(sweeps_mps, rate_mps):
    dt_s, swept_m = 0.05, 0.0
    straight, turning = LateralFilter(0.0, 0.1, 0.0), LateralFilter(0.0, 0.1, sweeps_mps[0])
    for step, sweep_mps in enumerate(sweeps_mps[1:], 1):
        swept_m += sweep_mps * dt_s
        place_m = rate_mps * step * dt_s
        straight.predict(dt_s, 0.0)
        straight.correct(place_m, 0.1)
        turning.predict(dt_s, sweep_mps)
        turning.correct(place_m + swept_m, 0.1)
        assert turning.rate_mps - sweep_mps == pytest.approx(straight.rate_mps, abs=1e-6)
        assert turning.lateral_m - swept_m == pytest.approx(straight.lateral_m, abs=1e-6)


def test_while_our_turning_is_not_known_it_is_learnt_with_the_rate():
    # We turn throughout; it is known, then not, and known again: nothing jumps at any of these moments.
    found, place_m, rates_mps = LateralFilter(0.0, 0.05, -2.0), 0.0, []
    for step in range(90):
        place_m -= 2.0 / 30
        found.predict(1 / 30, None if 30 <= step < 60 else -2.0)
        found.correct(place_m, 0.05)
        rates_mps.append(found.rate_mps)
    assert rates_mps == pytest.approx([-2.0] * 90, abs=1e-6)


@pytest.mark.parametrize("sweep_mps", [0.0, -3.0])
def test_who_brakes_across_the_road_is_known_to_half_a_second_later(sweep_mps):
    # 6 m/s for two seconds, then less by 3 m/s each second; we turn steadily, or not at all.
    dt_s, told = 1 / 30, []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        found, place_m = LateralFilter(-20.0, 0.05, sweep_mps), -20.0
        for step in range(105):
            place_m += (6.0 - 3.0 * max(step * dt_s - 2.0, 0.0) + sweep_mps) * dt_s
            found.predict(dt_s, sweep_mps)
            found.correct(place_m + rng.normal(0, 0.05), 0.05)
            if step in {58, 75}:
                told.append(found.slowing_mps2)
    steadily, half_a_second_later = told[::2], told[1::2]
    assert np.mean(steadily) < 0.1
    assert 1.0 < np.mean(half_a_second_later) < 3.0
    assert np.mean(np.array(half_a_second_later) > 3.0) < 0.16


def test_where_our_turning_is_not_known_nobody_is_known_to_slow():
    found, place_m = LateralFilter(-20.0, 0.05), -20.0
    for step in range(90):
        place_m += (6.0 - 2.0 * step / 30) / 30
        found.predict(1 / 30)
        found.correct(place_m, 0.05)
        assert found.slowing_mps2 == 0.0
