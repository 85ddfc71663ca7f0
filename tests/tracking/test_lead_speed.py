"""The prior of a vehicle's own speed against numerical integration, and what it makes of a standing one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.lead_speed import SpeedPrior, with_own_speed, without_own_speed
from fcw.tracking.range.state import RangeState

PRIOR = SpeedPrior()


def state(closing_mps, sigma_mps, at_distance_mps=None):
    """Of a well-known camera: no error of the distance is in the closing speed."""
    at_distance_mps = sigma_mps if at_distance_mps is None else at_distance_mps
    return RangeState(60.0, 0.1, closing_mps, sigma_mps, at_distance_mps, 0.5, 1.0, 1.7, 4.2, 0.1, 0.1)


def density(x, mean, sigma):
    return np.exp(-0.5 * ((x - mean) / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))


@given(st.floats(0.0, 40.0), st.floats(-20.0, 40.0), st.floats(0.3, 12.0))
def test_mean_and_sigma_are_those_of_bayes_rule(own_mps, closing_mps, sigma_mps):
    found = with_own_speed(state(closing_mps, sigma_mps), own_mps, PRIOR)
    speeds_mps = np.linspace(-120.0, 160.0, 28_001)
    belief = density(speeds_mps, own_mps - closing_mps, sigma_mps) * (
        PRIOR.standing_share * density(speeds_mps, 0.0, PRIOR.standing_sigma_mps)
        + (1 - PRIOR.standing_share)
        * (
            PRIOR.oncoming_share * density(speeds_mps, -own_mps, PRIOR.travelling_sigma_mps)
            + (1 - PRIOR.oncoming_share) * density(speeds_mps, own_mps, PRIOR.travelling_sigma_mps)
        )
    )
    belief /= belief.sum()
    mean_mps = float(belief @ speeds_mps)
    assert found.closing_speed_mps == pytest.approx(own_mps - mean_mps, abs=1e-3)
    sigma = math.sqrt(float(belief @ (speeds_mps - mean_mps) ** 2))
    assert found.closing_speed_sigma_mps == pytest.approx(sigma, abs=1e-3)
    assert found.distance_m == 60.0


def test_what_may_stand_is_believed_to_stand():
    found = with_own_speed(state(16.0, 3.0), 19.0, PRIOR)
    assert 17.0 < found.closing_speed_mps < 19.0


@pytest.mark.parametrize(("own_mps", "sigma_mps"), [(25.0, 5.0), (22.0, 4.0), (14.0, 3.0)])
def test_what_comes_towards_us_does_not_stand(own_mps, sigma_mps):
    # It drives as fast as we do. Where all are taken to stand or to travel our way, 14 to 25 m/s of 28 to 50.
    found = with_own_speed(state(2 * own_mps - sigma_mps / 2, sigma_mps), own_mps, PRIOR)
    assert found.closing_speed_mps == pytest.approx(2 * own_mps, rel=0.1)
    assert found.closing_speed_sigma_mps > sigma_mps / 2


def test_what_surely_travels_keeps_its_closing_speed():
    found = with_own_speed(state(3.0, 0.3), 20.0, PRIOR)
    assert found.closing_speed_mps == pytest.approx(3.0, abs=0.01)
    assert found.closing_speed_sigma_mps == pytest.approx(0.3, abs=0.01)


@given(st.floats(-80.0, 40.0), st.floats(0.1, 100.0))
def test_without_own_speed_the_closing_speed_is_what_traffic_allows(closing_mps, sigma_mps):
    found = without_own_speed(state(closing_mps, sigma_mps), PRIOR)
    speeds_mps = np.linspace(-200.0, 200.0, 40_001)
    belief = density(speeds_mps, closing_mps, sigma_mps) * density(speeds_mps, 0.0, PRIOR.closing_sigma_mps)
    belief /= belief.sum()
    mean_mps = float(belief @ speeds_mps)
    assert found.closing_speed_mps == pytest.approx(mean_mps, abs=1e-3)
    spread_mps = math.sqrt(float(belief @ (speeds_mps - mean_mps) ** 2))
    assert found.closing_speed_sigma_mps == pytest.approx(spread_mps, abs=1e-3)


def test_what_is_known_but_for_the_scale_keeps_its_time_to_contact():
    # 40 m/s give or take 16 by the lens, half a metre a second by the picture.
    found = without_own_speed(state(40.0, 16.0, 0.5), PRIOR)
    assert found.closing_speed_mps == pytest.approx(40.0, rel=0.01)
    assert found.closing_speed_sigma_mps == pytest.approx(16.0, rel=0.01)
    assert found.closing_speed_sigma_at_distance_mps == pytest.approx(0.5, rel=0.01)


def test_what_the_own_speed_errs_is_not_said_of_a_vehicle_that_stands():
    # It stands for sure; the closing speed is known no better than the own speed is.
    standing = with_own_speed(state(15.0, 3.0), 15.0, SpeedPrior(standing_share=1 - 1e-9), own_sigma_mps=0.6)
    assert standing.closing_speed_sigma_mps == pytest.approx(0.66, abs=0.03)
