"""The gap that a driver needs, against the motion itself."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.warning.driver import EXPECTED_DRIVER, Driver, needed_distance_m
from fcw.warning.rule import Approach


@given(
    own_mps=st.floats(5, 40),
    lead_part=st.floats(0, 1),
    braking_mps2=st.floats(0.6, 7.9),
    gap_m=st.floats(1, 120),
)
def test_the_gap_needed_behind_a_braking_lead_is_that_of_the_motion_itself(
    own_mps, lead_part, braking_mps2, gap_m
):
    lead_mps = own_mps * lead_part
    approach = Approach(closing_mps=own_mps - lead_mps, acceleration_mps2=braking_mps2, own_mps=own_mps)
    needed_m = needed_distance_m(approach, EXPECTED_DRIVER)
    # The same motion in steps of a millisecond.
    used_m, most_m, step_s, time_s = 0.0, 0.0, 0.001, 0.0
    while own_mps > 0:
        braking = EXPECTED_DRIVER.braking_mps2 if time_s > EXPECTED_DRIVER.reaction_s else 0.0
        used_m += (own_mps - lead_mps) * step_s
        most_m = max(most_m, used_m)
        own_mps -= braking * step_s
        lead_mps = max(lead_mps - braking_mps2 * step_s, 0.0)
        time_s += step_s
    assert needed_m == pytest.approx(most_m, abs=0.05 + 0.001 * most_m)


@given(st.floats(0, 50), st.floats(0.5, 50), st.floats(-8, 0))
def test_for_a_lead_that_keeps_its_speed_the_gap_is_that_of_the_driver_model_and_less_if_we_brake(
    closing_mps, own_mps, braking_mps2
):
    driver = Driver(reaction_s=1.2, braking_mps2=4.0)
    expected_m = closing_mps * 1.2 + closing_mps**2 / 8
    constant = Approach(closing_mps=closing_mps, own_mps=own_mps)
    assert needed_distance_m(constant, driver) == pytest.approx(expected_m)
    easing = Approach(closing_mps=closing_mps, acceleration_mps2=braking_mps2, own_mps=own_mps)
    assert needed_distance_m(easing, driver) <= expected_m + 1e-9
    unknown = Approach(closing_mps=closing_mps)
    assert needed_distance_m(unknown, driver) == pytest.approx(expected_m)


@given(st.floats(0, 50), st.floats(0, 8), st.floats(0, 1000))
def test_where_the_own_speed_is_unknown_a_lead_brakes_until_we_do(closing_mps, braking_mps2, own_mps):
    driver = Driver(reaction_s=1.2, braking_mps2=4.0)
    then_mps = closing_mps + 1.2 * braking_mps2
    expected_m = 1.2 * (closing_mps + then_mps) / 2 + then_mps**2 / 8
    unknown = Approach(closing_mps=closing_mps, acceleration_mps2=braking_mps2)
    assert needed_distance_m(unknown, driver) == pytest.approx(expected_m)
    if own_mps - closing_mps >= 1.2 * braking_mps2:  # the lead still drives when we brake
        assert needed_distance_m(replace(unknown, own_mps=own_mps), driver) >= expected_m - 1e-6
