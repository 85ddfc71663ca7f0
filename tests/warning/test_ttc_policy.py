"""When the default policy warns: closed-form motion, standards' figures, and invariants."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.detection.types import Box
from fcw.tracking.types import Track
from fcw.warning.ttc_policy import TtcPolicy, TtcPolicySettings, describe, required_deceleration_mps2
from fcw.warning.types import WarningLevel, WarningState

FRAME_NS = 33_333_333


def lead(distance_m, closing_mps, sigma_mps=0.0, track_id=1):
    return Track(
        track_id=track_id,
        box=Box(600, 300, 80, 60),
        score=1.0,
        distance_m=distance_m,
        distance_low_m=distance_m * 0.95,
        distance_high_m=distance_m * 1.05,
        lateral_m=0.0,
        closing_speed_mps=closing_mps,
        closing_speed_sigma_mps=sigma_mps,
        ttc_s=distance_m / closing_mps if closing_mps > 0 else None,
        age_s=3.0,
        coasting=False,
        in_path=True,
    )


def level_at(distance_m, closing_mps, sigma_mps=0.0, ego_mps=None):
    return TtcPolicy().update(0, lead(distance_m, closing_mps, sigma_mps), ego_mps).level


def test_warning_where_a_driver_of_1_2_s_and_0_4_g_must_brake():
    # At 5 m/s: 6 m of reaction and 25 / (2 * 3.92266) = 3.19 m of braking; TTC 1.84 s.
    assert level_at(9.1, 5.0) == WarningLevel.WARNING
    assert TtcPolicy().update(0, lead(9.1, 5.0), None).rule == "required_deceleration"
    policy = TtcPolicy(TtcPolicySettings(warning_ttc_s=0.0))
    assert policy.update(0, lead(9.3, 5.0), None).level == WarningLevel.CAUTION


@pytest.mark.parametrize(
    ("closing_mph", "ttc_s"), [(45, 2.1), (25, 2.0)], ids=["standing lead", "lead at 20 mph"]
)
def test_nhtsa_vehicles_at_constant_speed_are_warned_of_in_time(closing_mph, ttc_s):
    closing_mps = closing_mph * 0.44704
    assert level_at(closing_mps * ttc_s, closing_mps) == WarningLevel.WARNING


def test_nhtsa_lead_braking_at_0_3_g_from_30_m_is_warned_of_at_2_4_s():
    policy, braking_mps2, ttc_s = TtcPolicy(), 0.3 * 9.80665, 0.0
    for frame in range(1, 120):
        time_s = frame / 30
        distance_m, closing_mps = 30 - braking_mps2 * time_s**2 / 2, braking_mps2 * time_s
        if policy.update(frame * FRAME_NS, lead(distance_m, closing_mps), 20.1).level == WarningLevel.WARNING:
            ttc_s = distance_m / closing_mps
            break
    assert ttc_s >= 2.4


@pytest.mark.parametrize("gap_m", [10, 20, 40])
def test_a_lead_braking_at_0_4_g_is_warned_of_no_later_than_its_driver_must_brake(gap_m):
    policy, braking_mps2, level = TtcPolicy(), 0.4 * 9.80665, WarningLevel.NONE
    for frame in range(300):
        time_s = frame / 30
        distance_m, closing_mps = gap_m - braking_mps2 * time_s**2 / 2, braking_mps2 * time_s
        level = policy.update(frame * FRAME_NS, lead(distance_m, closing_mps), 25.0).level
        if distance_m <= closing_mps * 1.2 + closing_mps**2 / (2 * braking_mps2):
            break
    assert level == WarningLevel.WARNING


@given(st.floats(0.5, 40), st.floats(4.01, 100), st.none() | st.floats(0, 60))
def test_no_caution_or_warning_above_a_ttc_of_4_s(closing_mps, ttc_s, ego_mps):
    assert level_at(closing_mps * ttc_s, closing_mps, ego_mps=ego_mps) <= WarningLevel.ADVISORY


@given(st.floats(1, 100), st.floats(-30, 0), st.floats(0, 20), st.none() | st.floats(0, 60))
def test_a_gap_that_does_not_close_never_warns(distance_m, closing_mps, sigma_mps, ego_mps):
    assert level_at(distance_m, closing_mps, sigma_mps, ego_mps) <= WarningLevel.ADVISORY


@given(st.floats(1, 100), st.floats(0, 40), st.floats(3.1, 40), st.floats(0, 2))
def test_oncoming_vehicles_never_warn(distance_m, ego_mps, excess_mps, sigma_mps):
    closing_mps = ego_mps + excess_mps + sigma_mps
    assert level_at(distance_m, closing_mps, sigma_mps, ego_mps) == WarningLevel.NONE


def test_an_unsure_closing_speed_makes_a_caution_but_no_warning():
    # 60 m at 18 m/s: the 0.4 g driver must brake within 62.9 m, and within 56.8 m at 17 m/s, which is
    # 18 m/s less a quarter of 4 m/s.
    assert level_at(60, 18, sigma_mps=0.1) == WarningLevel.WARNING
    assert level_at(60, 18, sigma_mps=4.0) == WarningLevel.CAUTION


def test_a_closing_speed_that_may_be_noise_raises_nothing():
    assert level_at(30, 20, sigma_mps=13.5) == WarningLevel.NONE
    assert level_at(30, 20, sigma_mps=13.2) == WarningLevel.WARNING


def test_a_track_of_a_few_frames_raises_nothing():
    young, older = (replace(lead(15, 15), age_s=age_s) for age_s in (0.7, 0.8))
    assert TtcPolicy().update(0, young, None).level == WarningLevel.NONE
    assert TtcPolicy().update(0, older, None).level == WarningLevel.WARNING


def test_following_too_closely_is_an_advisory_from_40_km_h_down_to_30():
    policy = TtcPolicy()
    states = []
    for index, ego_kmh in enumerate((39, 41, 31, 29)):
        # A headway of half a second, seconds apart so that the minimum duration is over.
        states.append(policy.update(index * 3 * 10**9, lead(ego_kmh / 3.6 * 0.5, 0.0), ego_kmh / 3.6))
    assert [state.level.name for state in states] == ["NONE", "ADVISORY", "ADVISORY", "NONE"]
    assert states[1].rule == "headway"
    assert states[1].headway_s == pytest.approx(0.5)


def test_no_advisory_without_the_own_speed():
    assert level_at(3.0, 0.0) == WarningLevel.NONE


def test_a_raised_level_is_held_with_wider_thresholds():
    policy = TtcPolicy()
    levels = [
        policy.update(index * 2 * 10**9, lead(ttc_s * 10, 10), None).level
        for index, ttc_s in enumerate((3.1, 2.6, 3.1, 3.6, 3.1))
    ]
    # At 10 m/s the driver models are reached at 2.47 and 3.39 s, the TTC rule at 2.7 s; held to
    # 1.25 times those.
    assert [level.name for level in levels] == ["CAUTION", "WARNING", "WARNING", "CAUTION", "CAUTION"]


def test_a_level_is_shown_for_its_minimum_duration_after_its_vehicle_is_gone():
    policy = TtcPolicy()
    policy.update(0, lead(10, 10, track_id=7), None)
    held = policy.update(900_000_000, None, None)
    assert (held.level, held.track_id, held.rule) == (WarningLevel.WARNING, 7, "required_deceleration")
    assert held.ttc_s is None
    assert policy.update(1_000_000_000, None, None) == WarningState(WarningLevel.NONE)


def test_time_that_goes_back_is_refused():
    policy = TtcPolicy()
    policy.update(5, None, None)
    with pytest.raises(ValueError, match="went back from 5 to 4"):
        policy.update(4, None, None)


leads = st.none() | st.builds(
    lead, st.floats(0, 120), st.floats(-30, 60), st.floats(0, 20), st.integers(1, 3)
)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 600_000_000), leads, st.none() | st.floats(0, 60)), max_size=60))
def test_no_level_is_lowered_before_its_minimum_duration_and_every_state_is_whole(steps):
    policy, minimum_ns = TtcPolicy(), 1_000_000_000
    time_ns, since_ns, before = 0, 0, WarningLevel.NONE
    for step_ns, track, ego_mps in steps:
        time_ns += step_ns
        state = policy.update(time_ns, track, ego_mps)
        if state.level < before:
            assert time_ns - since_ns >= minimum_ns
        if state.level != before:
            since_ns, before = time_ns, state.level
        assert (state.track_id is None) == (state.level == WarningLevel.NONE)
        assert bool(state.rule) == (state.level > WarningLevel.NONE)
        assert state.ttc_s is None or state.ttc_s >= 0


@given(st.floats(0.1, 200), st.floats(0.1, 60))
def test_required_deceleration_stops_the_closing_exactly_at_contact(distance_m, closing_mps):
    deceleration = required_deceleration_mps2(distance_m, closing_mps)
    assert deceleration is not None
    stopping_s = closing_mps / deceleration
    assert closing_mps * stopping_s - deceleration * stopping_s**2 / 2 == pytest.approx(distance_m)


def test_required_deceleration_of_a_gap_that_opens_is_none_and_at_contact_infinite():
    assert required_deceleration_mps2(10, 0) is None
    assert required_deceleration_mps2(0, 1) == math.inf


def test_description_gives_level_reason_vehicle_interval_and_figures():
    track = lead(18.0, 10.0, track_id=4)
    state = TtcPolicy().update(0, track, 20.0)
    assert describe(state, track) == (
        "warning: braking is due; vehicle 4 at 18.0 m (17.1 m to 18.9 m), closing at 36 km/h, "
        "collision in 1.8 s, needs 0.28 g, headway 0.9 s"
    )
    assert "59 ft (56 ft to 62 ft), closing at 22 mph" in describe(state, track, imperial=True)
    assert describe(state, None) == "warning: braking is due; vehicle 4 is no longer seen"
    assert describe(WarningState(WarningLevel.NONE), None) == "no warning"
