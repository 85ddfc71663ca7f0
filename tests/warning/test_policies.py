"""When the policies warn: closed-form motion, standards' figures, and invariants."""

import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from leads.warning_leads import make_lead as lead
from leads.warning_leads import threats_of_lead as threats
from searching import examples

from fcw.errors import UserError
from fcw.motion.path import assumed_path
from fcw.threat.threat import assess
from fcw.tracking.types import SeenBy
from fcw.warning.policies import DEFAULT_POLICY, POLICIES, make_policy, without_own_speed
from fcw.warning.types import WarningLevel, WarningState

FRAME_NS = 33_333_333
G_MPS2 = 9.80665


def level_at(distance_m, closing_mps, sigma_mps=0.0, *, own_mps=None, policy=DEFAULT_POLICY, **more):
    """The level after this has been seen for a second."""
    return settled(make_policy(policy), lead(distance_m, closing_mps, sigma_mps, **more), own_mps).level


def settled(policy, track, own_mps=None, *, from_ns=0, is_lead=True):
    seen = threats(track, own_mps, is_lead=is_lead)
    policy.update(from_ns, seen, own_mps)
    policy.update(from_ns + 6 * 10**8, seen, own_mps)
    return policy.update(from_ns + 10**9, seen, own_mps)


def brake(policy, gap_m, braking_mps2, own_mps, duration_s):
    """Distance, closing speed and state in each frame behind a lead that brakes, all known exactly."""
    for frame in range(round(duration_s * 30)):
        time_s = frame / 30
        distance_m, closing_mps = gap_m - braking_mps2 * time_s**2 / 2, braking_mps2 * time_s
        track = lead(distance_m, closing_mps, growth_mps2=braking_mps2)
        yield distance_m, closing_mps, policy.update(frame * FRAME_NS, threats(track, own_mps), own_mps)


def test_warning_where_a_driver_of_1_2_s_and_0_4_g_must_brake():
    # At 5 m/s: 6 m of reaction and 25 / (2 * 3.92266) = 3.19 m of braking; TTC 1.84 s.
    for policy in (DEFAULT_POLICY, "euro-ncap-driver"):
        assert level_at(9.1, 5.0, policy=policy) == WarningLevel.WARNING
        assert level_at(9.3, 5.0, policy=policy) == WarningLevel.CAUTION


def test_what_is_at_our_bumper_is_not_early_where_the_own_speed_is_unknown():
    assert level_at(0.0, 5.0) == WarningLevel.WARNING
    assert level_at(0.1, 5.0) == WarningLevel.WARNING


def test_caution_where_the_slowest_and_gentlest_driver_of_iso_15623_must_brake():
    # At 4 m/s: 8 m of reaction and 16 / 7.2 = 2.22 m of braking.
    assert level_at(10.2, 4.0) == WarningLevel.CAUTION
    assert level_at(10.3, 4.0) == WarningLevel.NONE


@pytest.mark.parametrize(
    ("closing_mph", "ttc_s"), [(45, 2.1), (25, 2.0)], ids=["standing lead", "lead at 20 mph"]
)
@pytest.mark.parametrize("policy", [DEFAULT_POLICY, "ttc", "euro-ncap-driver"])
def test_nhtsa_vehicles_at_constant_speed_are_warned_of_in_time(closing_mph, ttc_s, policy):
    closing_mps = closing_mph * 0.44704
    assert level_at(closing_mps * ttc_s, closing_mps, policy=policy) == WarningLevel.WARNING


def test_nhtsa_lead_braking_at_0_3_g_from_30_m_is_warned_of_at_2_4_s():
    frames = brake(make_policy(), 30, 0.3 * G_MPS2, 20.1, 4)
    ttc_s = next(d / v for d, v, state in frames if state.level == WarningLevel.WARNING)
    assert ttc_s >= 2.4


@pytest.mark.parametrize("policy", ["ttc", "euro-ncap-driver", "required-deceleration", DEFAULT_POLICY])
def test_a_gap_that_does_not_close_never_warns(policy):
    @given(st.floats(1, 100), st.floats(-30, 0), st.floats(0, 20), st.none() | st.floats(0, 60))
    def check(distance_m, closing_mps, sigma_mps, own_mps):
        level = level_at(distance_m, closing_mps, sigma_mps, own_mps=own_mps, policy=policy)
        assert level <= WarningLevel.ADVISORY

    check()


@pytest.mark.parametrize("policy", POLICIES)
def test_oncoming_vehicles_beside_our_path_or_far_away_never_warn(policy):
    @given(
        st.floats(1, 100),
        st.floats(5, 40),
        st.floats(3.1, 40),
        st.floats(0, 2),
        st.sampled_from([-3.5, 0.0, 3.5]),
    )
    def check(distance_m, own_mps, excess_mps, sigma_mps, lateral_m):
        closing_mps = own_mps + excess_mps + sigma_mps
        if lateral_m == 0:
            distance_m += 3.0 * closing_mps  # above the time at which one in our lane is warned of
        track = lead(distance_m, closing_mps, sigma_mps, lateral_m=lateral_m)
        shown = settled(make_policy(policy), track, own_mps, is_lead=False)
        assert shown.level == WarningLevel.NONE

    check()


def test_an_oncoming_vehicle_in_our_own_lane_is_warned_of():
    # 40 m at 30 m/s, of which 15 are ours.
    track = lead(40, 30, 1.0)
    assert settled(make_policy(), track, 15.0, is_lead=False).level == WarningLevel.WARNING


@pytest.mark.parametrize(
    ("lateral_m", "lateral_mps", "ttc_s", "level"),
    [
        (-1.5, 0.6, 1.2, WarningLevel.WARNING),  # an SUV comes in, half in our lane, its middle 1.5 m aside
        (1.2, 0.5, 0.8, WarningLevel.WARNING),  # a convertible leaves our lane too slowly
        (-1.35, -1.2, 1.2, WarningLevel.NONE),  # 25 % in our way, and out of it in time
        (-2.6, 0.0, 1.2, WarningLevel.NONE),  # parked beside it
    ],
)
def test_a_vehicle_half_in_the_path_is_warned_of_where_it_will_be_hit(lateral_m, lateral_mps, ttc_s, level):
    # It is not the lead: that is somebody far ahead.
    path = assumed_path(15.0)
    track = lead(ttc_s * 8.0, 8.0, 0.5, lateral_m=lateral_m, lateral_mps=lateral_mps)
    other = lead(60.0, 0.0, 0.5, track_id=2)
    threats_now = assess((track, other), 2, path, 15.0)
    policy = make_policy()
    state = [policy.update(step * 10**8, threats_now, 15.0) for step in range(12)][-1]
    assert state.level == level
    assert state.track_id == (1 if level else None)


def test_of_two_vehicles_the_more_urgent_one_is_warned_of_though_the_other_is_the_lead():
    near, urgent = lead(12.0, 0.5, 0.1, track_id=1), lead(25.0, 14.0, 0.5, track_id=2)
    policy, both = make_policy(), assess((near, urgent), 1, assumed_path(20.0), 20.0)
    state = [policy.update(step * 10**8, both, 20.0) for step in range(12)][-1]
    assert (state.level, state.track_id) == (WarningLevel.WARNING, 2)
    assert state.distance_m == 25.0


def test_caution_comes_before_warning_where_time_allows():
    # At 30 m/s 150 m are needed: 120 m are a TTC of 4 s.
    policy, track = make_policy(), threats(lead(120.0, 30.0), 30.0)
    levels = [policy.update(10**9 * (step >= 1) + step * 10**8, track, 30.0).level.name for step in range(6)]
    assert levels == ["NONE", "CAUTION", "CAUTION", "CAUTION", "WARNING", "WARNING"]


def test_no_warning_comes_above_the_time_at_which_one_may_be_needed():
    # 30 m/s need 150.7 m, a TTC of 5 s; 4.3 s are 129 m.
    assert level_at(140.0, 30.0) == WarningLevel.CAUTION
    assert [state.level for state in approach(130, 30.0, "normal")][-1] == WarningLevel.WARNING


def approach(to_m, closing_mps, timing):
    policy = make_policy(timing=timing)
    for step in range(60):
        track = lead(to_m + (59 - step) * closing_mps / 30 - 5, closing_mps)
        yield policy.update(step * FRAME_NS, threats(track, closing_mps), closing_mps)


def test_early_warns_before_normal_and_normal_before_late():
    firsts = {}
    for timing in ("early", "normal", "late"):
        states = list(approach(30, 12.0, timing))
        firsts[timing] = next(k for k, state in enumerate(states) if state.level == WarningLevel.WARNING)
    assert firsts["early"] < firsts["normal"] < firsts["late"]
    # At 12 m/s half a second is 6 m, and 0.4 s are 4.8 m: 15 and 12 frames.
    assert firsts["normal"] - firsts["early"] == pytest.approx(15, abs=1)
    assert firsts["late"] - firsts["normal"] == pytest.approx(12, abs=1)


def test_early_and_late_hold_behind_a_lead_that_brakes_too():
    def first(timing):
        policy = make_policy(timing=timing)
        for step in range(180):
            braked_s = step / 30
            track = lead(80.0 - 2.0 * braked_s**2, 4.0 * braked_s, growth_mps2=4.0)
            if policy.update(step * FRAME_NS, threats(track, 33.0), 33.0).level == WarningLevel.WARNING:
                return step
        raise AssertionError("never warned")

    assert first("early") < first("normal") < first("late")


@pytest.mark.parametrize("policy", POLICIES)
def test_every_frame_of_a_warning_has_every_figure_of_its_vehicle(policy):
    warner = make_policy(policy)
    for step in range(25):
        track = lead(9.0 - 0.2 * step, 6.0, 0.2, track_id=4) if step < 18 else None
        state = warner.update(step * 10**8, threats(track, 20.0), 20.0)
        if state.level > WarningLevel.NONE:
            assert state.track_id == 4
            figures = (state.distance_m, state.distance_low_m, state.distance_high_m, state.closing_speed_mps)
            more = (state.ttc_s, state.required_deceleration_mps2, state.headway_s, state.needed_distance_m)
            assert None not in (*figures, *more, state.overlap_m, state.collision_probability)
            assert state.assumes
            assert state.extrapolated == (step >= 18)


def test_a_lead_that_will_be_beside_the_path_at_contact_raises_nothing():
    # 16 m at 8 m/s: in two seconds it is 1.7 m to the left, or 1.9 m.
    assert level_at(16, 8, lateral_m=-1.0, lateral_mps=1.35) == WarningLevel.WARNING
    assert level_at(16, 8, lateral_m=-1.0, lateral_mps=1.45) == WarningLevel.NONE


def test_required_deceleration_counts_the_braking_of_the_lead():
    # 10 m/s and 20 m: after 0.75 s 12.5 m are left, and 4 m/s^2 are required; 0.68 g are 6.67.
    assert level_at(20, 10, own_mps=20, policy="required-deceleration") == WarningLevel.CAUTION
    braking = level_at(20, 10, own_mps=20, growth_mps2=3.0, policy="required-deceleration")
    assert braking == WarningLevel.WARNING


def test_rss_by_its_formula():
    # At 20 m/s behind 20 m/s: 20 + 1.75 + 23.5^2 / 8 - 400 / 16 = 65.78 m; 45 m where we do not speed up;
    # 20 m where the lead brakes no harder than we do.
    policies = {gap_m: level_at(gap_m, 0.0, own_mps=20.0, policy="rss") for gap_m in (65.8, 65.7, 44.9, 19.9)}
    assert [level.name for level in policies.values()] == ["NONE", "ADVISORY", "CAUTION", "WARNING"]


def test_a_danger_that_is_likely_enough_is_warned_of_before_it_is_certain():
    # At 18 m/s the driver needs 62.90 m, at 19 m/s 68.81: 5.91 m for each m/s of sigma, times 1.65.
    assert level_at(71.8, 18, sigma_mps=0.0) == WarningLevel.CAUTION
    assert level_at(72.6, 18, sigma_mps=1.0) == WarningLevel.WARNING
    assert level_at(72.7, 18, sigma_mps=1.0) == WarningLevel.CAUTION
    # 10 % of 75.3 m is 7.5 m.
    assert level_at(75.2, 18, spread=0.1) == WarningLevel.WARNING
    assert level_at(75.4, 18, spread=0.1) == WarningLevel.CAUTION


def test_a_standing_vehicle_is_the_fastest_thing_that_closes():
    assert level_at(71.7, 18, sigma_mps=1.0, own_mps=18.0) == WarningLevel.CAUTION


def test_a_lead_that_only_coasts_counts_as_one_that_keeps_its_speed():
    # 10 m at 4 m/s: the driver needs 6.8 m, and behind a lead that brakes at 1.1 m/s^2 11.6 m.
    growing = [level_at(10, 4, own_mps=20, growth_mps2=growth_mps2) for growth_mps2 in (0.9, 1.1)]
    assert growing == [WarningLevel.CAUTION, WarningLevel.WARNING]


@pytest.mark.parametrize(
    "what",
    [{"age_s": 0.25}, {"age_s": 0.7, "sigma_mps": 4.0}, {"seen_by": SeenBy.COASTING}, {"sigma_mps": 5.1}],
    ids=["just found", "young and not sure", "unseen", "perhaps noise"],
)
def test_what_is_not_evident_raises_nothing(what):
    assert level_at(15, 15) == WarningLevel.WARNING
    assert level_at(15, 15, **what) == WarningLevel.NONE


@pytest.mark.parametrize(("distance_m", "needed_ms"), [(23, 600), (14, 300)], ids=["far", "found late"])
def test_what_has_just_become_the_lead_raises_nothing(distance_m, needed_ms):
    policy = make_policy()
    settled(policy, lead(50, 0.0, track_id=1), 20.0)
    states = [
        policy.update(10**9 + ms * 10**6, threats(lead(distance_m, 10, track_id=2), 20.0), 20.0)
        for ms in (1, needed_ms - 10, needed_ms + 10)
    ]
    assert [state.level.name for state in states] == ["NONE", "NONE", "WARNING"]


def test_a_lead_far_away_in_time_raises_nothing():
    # Behind a lead that brakes hard the driver needs more than 20 m at 2.9 m/s, which is a TTC of 6.9 s.
    assert level_at(20, 2.9, own_mps=14, growth_mps2=6.0) == WarningLevel.WARNING
    assert level_at(20, 2.8, own_mps=14, growth_mps2=6.0) == WarningLevel.NONE


def test_nothing_is_raised_below_10_km_h():
    assert level_at(1, 2.7, own_mps=2.7) == WarningLevel.NONE
    assert level_at(1, 2.8, own_mps=2.8) == WarningLevel.WARNING


def test_following_too_closely_is_an_advisory_from_40_km_h_down_to_30():
    policy = make_policy()
    states = []
    for index, own_kmh in enumerate((39, 41, 31, 29)):
        # A headway of half a second, seconds apart so that the minimum duration is over.
        states.append(
            policy.update(
                index * 3 * 10**9, threats(lead(own_kmh / 3.6 * 0.5, 0.0), own_kmh / 3.6), own_kmh / 3.6
            )
        )
    assert [state.level.name for state in states] == ["NONE", "ADVISORY", "ADVISORY", "NONE"]
    assert states[1].rule == "headway"
    assert states[1].headway_s == pytest.approx(0.5)


def test_without_the_own_speed_there_is_no_advisory_and_that_is_said():
    assert level_at(3.0, 0.0) == WarningLevel.NONE
    assert "give --ego-speed" in without_own_speed(DEFAULT_POLICY)
    message = "--warning-policy rss: needs the own speed; give it with --ego-speed"
    with pytest.raises(UserError, match=re.escape(message)):
        without_own_speed("rss")


def test_an_unknown_policy_is_refused_with_the_list_of_those_there_are():
    with pytest.raises(UserError, match=r"--warning-policy tcc: no such policy; expected one of .*rss"):
        make_policy("tcc")


def test_a_raised_level_is_held_with_wider_thresholds():
    policy = make_policy("euro-ncap-driver")
    levels = [
        policy.update(index * 2 * 10**9, threats(lead(ttc_s * 10, 10)), None).level
        for index, ttc_s in enumerate((4.5, 3.3, 2.4, 3.0, 3.2, 3.0))
    ]
    # At 10 m/s the drivers need 2.47 and 3.39 s; held to 1.25 times those, 3.09 and 4.24.
    names = [level.name for level in levels]
    assert names == ["NONE", "CAUTION", "WARNING", "WARNING", "CAUTION", "CAUTION"]


def test_a_warning_stays_while_contact_comes_nearer_and_goes_when_it_does_not():
    # A braking lead is warned of; then it brakes no more, and its closing speed alone is none to warn of yet.
    policy, fresh = make_policy(), make_policy()
    braking = [
        policy.update(step * 10**8, threats(lead(20, 5, growth_mps2=3.5), 20.0), 20.0) for step in range(13)
    ]
    steady = [fresh.update(step * 10**8, threats(lead(16, 5), 20.0), 20.0) for step in range(13)]
    assert braking[-1].level == WarningLevel.WARNING
    assert steady[-1].level < WarningLevel.WARNING
    for step, distance_m in enumerate((17.5, 16.0, 14.0), start=2):
        held = policy.update(step * 2 * 10**9, threats(lead(distance_m, 5), 20.0), 20.0)
        assert held.level == WarningLevel.WARNING
    # The driver brakes: at 3.5 m/s the time to contact is 4 s again.
    assert policy.update(10 * 10**9, threats(lead(14, 3.5), 20.0), 20.0).level < WarningLevel.WARNING


def test_a_level_is_shown_for_its_minimum_duration_after_its_vehicle_is_gone():
    policy = make_policy()
    (beside,) = threats(lead(10, 10, track_id=7), None)
    beside = replace(beside, overlap_m=-0.1, overlap_probability=0.6)
    for time_ns in (-6 * 10**8, 0, 4 * 10**8):
        policy.update(time_ns, (beside,), None)
    held = policy.update(900_000_000, (), None)
    assert (held.level, held.track_id, held.rule) == (WarningLevel.WARNING, 7, "braking_due")
    assert held.extrapolated
    assert held.distance_m == pytest.approx(5.0)  # half a second later
    assert policy.update(1_000_000_000, (), None) == WarningState(WarningLevel.NONE)


def test_time_that_goes_back_is_refused():
    policy = make_policy()
    policy.update(5, (), None)
    with pytest.raises(ValueError, match="went back from 5 to 4"):
        policy.update(4, (), None)


leads = st.none() | st.builds(
    lead,
    st.floats(0, 120),
    st.floats(-30, 60),
    st.floats(0, 20),
    track_id=st.integers(1, 3),
    lateral_m=st.floats(-2, 2),
    growth_mps2=st.floats(-20, 20),
    growth_sigma_mps2=st.floats(0, 5),
    spread=st.floats(0, 0.5),
)


@pytest.mark.parametrize("name", POLICIES)
def test_no_level_is_lowered_before_its_minimum_duration_and_every_state_is_whole(name):
    @examples(50)
    @given(st.lists(st.tuples(st.integers(0, 600_000_000), leads, st.none() | st.floats(0, 60)), max_size=40))
    def check(steps):
        policy, minimum_ns = make_policy(name), 1_000_000_000
        time_ns, since_ns, before = 0, 0, WarningLevel.NONE
        for step_ns, track, own_mps in steps:
            time_ns += step_ns
            state = policy.update(time_ns, threats(track, own_mps), own_mps)
            if state.level < before:
                assert time_ns - since_ns >= minimum_ns
            if state.level != before:
                since_ns, before = time_ns, state.level
            assert (state.track_id is None) == (state.level == WarningLevel.NONE)
            assert bool(state.rule) == (state.level > WarningLevel.NONE)
            assert state.ttc_s is None or state.ttc_s >= 0

    check()
