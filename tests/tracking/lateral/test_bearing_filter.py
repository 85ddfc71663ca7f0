"""The filter of bearings: where a vehicle crosses our path, whatever is wrong with its distance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.across.bearing_filter import BearingFilter

DT_S = 1 / 30


def follow(lateral_m, across_mps, distance_m, closing_mps, scale=1.0, turn_radps=0.0, noise=None):
    """The filter after a second of steady motion, whose distance is believed so many times as large as it is.

    Returns:
        It, the believed place across, and the true place at contact.
    """
    rng, heading_rad = np.random.default_rng(noise), 0.0
    sigma = 0.002
    found = BearingFilter(lateral_m / distance_m, sigma, scale * distance_m, turn_radps)
    at_contact_m = lateral_m + across_mps * distance_m / closing_mps
    for _ in range(30):
        found.predict(DT_S, turn_radps, scale * closing_mps, scale * distance_m)
        lateral_m += across_mps * DT_S
        distance_m -= closing_mps * DT_S
        heading_rad += turn_radps * DT_S
        off = 0.0 if noise is None else rng.normal(0, sigma)
        found.correct(lateral_m / distance_m - heading_rad + off, sigma)
    return found, lateral_m, distance_m, at_contact_m


@given(
    st.floats(-25, 25),
    st.floats(-12, 12),
    st.floats(45, 70),
    st.floats(5, 20),
    st.floats(0.7, 1.4),
    st.floats(-0.1, 0.1),
)
def test_a_wrong_distance_makes_the_place_at_contact_wrong_in_the_same_part_alone(
    lateral_m, across_mps, distance_m, closing_mps, scale, turn_radps
):
    found, now_m, left_m, true_m = follow(lateral_m, across_mps, distance_m, closing_mps, scale, turn_radps)
    seen_mps = found.across_mps(scale * now_m, scale * closing_mps, scale * left_m)
    assert seen_mps is not None
    own_mps = seen_mps + turn_radps * scale * left_m
    then_m = scale * now_m + own_mps * left_m / closing_mps
    # Of what is on a collision course nothing is wrong; the rate of what passes grows while it is learnt.
    assert then_m == pytest.approx(scale * true_m, rel=0.06, abs=0.05)


def test_its_sigma_holds_the_true_rate_two_times_in_three_or_oftener():
    within = []
    for seed in range(200):
        found, now_m, left_m, _ = follow(-20.0, 5.0, 50.0, 12.0, noise=seed)
        seen_mps = found.across_mps(now_m, 12.0, left_m)
        assert seen_mps is not None
        within.append(abs(seen_mps - 5.0) < found.across_sigma_mps)
    assert np.mean(within) > 0.62


def test_where_our_turning_is_not_known_it_tells_no_speed():
    found = BearingFilter(0.4, 0.002, 50.0)
    found.predict(DT_S, None, 12.0, 50.0)
    found.correct(0.4, 0.002)
    assert found.across_mps(20.0, 12.0, 50.0) is None


@pytest.mark.parametrize("unknown_frames", [1, 9, 30])
@pytest.mark.parametrize("turn_radps", [-0.17, 0.09])
def test_turning_that_was_not_known_for_a_while_is_no_motion_of_what_stands(turn_radps, unknown_frames):
    bearing, distance_m = 0.3, 25.0
    found = BearingFilter(bearing, 0.002, distance_m, turn_radps)
    known = [True] * 30 + [False] * unknown_frames + [True] * 10
    for is_known in known:
        bearing -= turn_radps * DT_S
        found.predict(DT_S, turn_radps if is_known else None, 0.0, distance_m)
        found.correct(bearing, 0.002)
        across_mps = found.across_mps(bearing * distance_m, 0.0, distance_m)
        if is_known:
            assert across_mps == pytest.approx(-turn_radps * distance_m, abs=found.across_sigma_mps)
        else:
            assert across_mps is None


def test_a_jump_is_no_motion_and_another_part_of_it_neither():
    found, lateral_m, distance_m, _ = follow(-20.0, 4.8, 50.0, 12.0)
    bearing, before_mps = lateral_m / distance_m, found.across_mps(lateral_m, 12.0, distance_m)
    found.correct(bearing + 0.1, 0.002)
    assert found.across_mps(lateral_m, 12.0, distance_m) == before_mps
    found.displace(bearing - 0.1, 0.002)
    assert found.across_mps(lateral_m, 12.0, distance_m) == before_mps
