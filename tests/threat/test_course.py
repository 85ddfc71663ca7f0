"""Where a vehicle will be at contact: closed-form motion on straight and bent paths."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.motion.bend.turn import Turn
from fcw.motion.state import STRAIGHT, OwnPath
from fcw.threat.course import place_at_contact
from fcw.threat.threat import reach_s
from fcw.tracking.types import SeenBy, Track

TRACK = Track(
    track_id=1,
    box=Box(600, 300, 80, 70),
    score=1.0,
    distance_m=20.0,
    distance_low_m=20.0,
    distance_high_m=20.0,
    lateral_m=0.0,
    closing_speed_mps=10.0,
    closing_speed_sigma_mps=0.0,
    ttc_s=2.0,
    age_s=3.0,
    seen_by=SeenBy.DETECTOR,
    in_path=True,
)
UNKNOWN = OwnPath(offset_sigma_m=0.1, heading_sigma_rad=0.02, curvature_sigma_per_m=0.005)


def placed(lateral_m, rate_mps, path=STRAIGHT, distance_m=20.0, speed_mps=10.0, offset_m=0.0):
    track = replace(
        TRACK,
        distance_m=distance_m,
        closing_speed_mps=speed_mps,
        lateral_m=lateral_m,
        lateral_speed_mps=rate_mps,
    )
    return place_at_contact(track, path, offset_m, distance_m / speed_mps)


@given(st.floats(-5, 5), st.floats(-3, 3), st.floats(5, 30), st.floats(8, 20))
def test_on_a_known_straight_path_a_vehicle_goes_on_as_it_does(lateral_m, rate_mps, distance_m, speed_mps):
    there = placed(lateral_m, rate_mps, distance_m=distance_m, speed_mps=speed_mps)
    assert there.offset_m == pytest.approx(lateral_m + rate_mps * distance_m / speed_mps)


@given(st.floats(-4, 4), st.floats(-0.01, 0.01), st.floats(5, 30), st.floats(8, 20))
def test_what_stands_beside_a_known_bend_is_passed_at_its_distance_from_it(
    beside_m, curvature_per_m, distance_m, speed_mps
):
    # Seen from a car that turns with curvature times speed it sweeps at that times the distance.
    path = OwnPath(curvature_per_m=curvature_per_m)
    lateral_m = beside_m + curvature_per_m * distance_m**2 / 2
    rate_mps = -curvature_per_m * speed_mps * distance_m
    there = placed(lateral_m, rate_mps, path, distance_m, speed_mps)
    assert there.offset_m == pytest.approx(beside_m)


@given(st.floats(-0.01, 0.01), st.floats(15, 40), st.floats(1, 8), st.floats(1, 6))
def test_a_lead_that_brakes_in_a_bend_is_in_our_way_though_it_will_sweep_faster(
    curvature_per_m, distance_m, closing_mps, growth_mps2
):
    path = OwnPath(curvature_per_m=curvature_per_m)
    track = replace(
        TRACK,
        distance_m=distance_m,
        closing_speed_mps=closing_mps,
        lateral_m=path.lateral_at(distance_m),
        lateral_speed_mps=-path.slope_at(distance_m) * closing_mps,
    )
    contact_s = reach_s(distance_m, closing_mps, growth_mps2)
    assert contact_s is not None
    assert place_at_contact(track, path, 0.0, contact_s).offset_m == pytest.approx(0.0, abs=1e-6)


@given(st.floats(-0.05, 0.05), st.floats(-3, 3))
def test_a_camera_that_looks_aside_changes_nothing_where_the_rate_is_known(heading_rad, beside_m):
    # A thing `beside` a path that heads to the left: seen at 20 m, and sweeping as its share shrinks.
    seen = placed(beside_m + heading_rad * 20, -heading_rad * 10, replace(STRAIGHT, heading_rad=heading_rad))
    assert seen.offset_m == pytest.approx(beside_m, abs=1e-9)
    # Not knowing of the heading is as good, up to the prior of the vehicle's own motion.
    unaware = placed(beside_m + heading_rad * 20, -heading_rad * 10, OwnPath(heading_sigma_rad=0.5))
    assert unaware.offset_m == pytest.approx(beside_m, abs=0.05)


def test_in_a_bend_that_nobody_knows_half_of_the_sweep_is_the_way_itself():
    # R = 100 m, 10 m/s, a parked car 20 m ahead where our path will be 2 m further left.
    far = OwnPath(curvature_sigma_per_m=1.0)
    there = placed(0.0, -0.01 * 10 * 20, far)
    assert there.offset_m == pytest.approx(-0.01 * 20**2 / 2, rel=0.02)


@given(st.floats(0.05, 0.6), st.floats(0.1, 5))
def test_the_way_is_known_no_worse_with_a_better_rate_and_a_better_path(rate_sigma_mps, factor):
    track = replace(TRACK, lateral_speed_sigma_mps=rate_sigma_mps, lateral_speed_mps=0.3)
    worse = replace(UNKNOWN, curvature_sigma_per_m=0.005 * (1 + factor))
    sigma_m = place_at_contact(track, UNKNOWN, 0.0, 2.0).sigma_m
    assert sigma_m <= place_at_contact(track, worse, 0.0, 2.0).sigma_m + 1e-9
    noisier = replace(track, lateral_speed_sigma_mps=rate_sigma_mps * (1 + factor))
    assert sigma_m <= place_at_contact(noisier, UNKNOWN, 0.0, 2.0).sigma_m + 1e-9


def test_who_comes_in_faster_than_a_bend_would_explain_comes_in():
    assert placed(-2.0, 1.5, OwnPath(curvature_sigma_per_m=0.001)).comes_in
    assert not placed(-2.0, 1.5, OwnPath(curvature_sigma_per_m=0.01)).comes_in
    assert not placed(-2.0, -1.5, OwnPath(curvature_sigma_per_m=0.001)).comes_in


@pytest.mark.parametrize("side", [-1, 1])
def test_who_changes_into_our_lane_stays_in_it(side):
    # 2.4 m beside the middle of our path, 20 m ahead, at 15 m/s along the road and 2 m/s across it.
    track = replace(TRACK, lateral_m=-2.4 * side, lateral_speed_mps=2.0 * side)
    there = place_at_contact(track, STRAIGHT, 0.0, 2.0, own_mps=25.0)
    assert there.comes_in
    assert there.offset_m == 0.0
    # Who does not reach the middle by then is where they are by then.
    assert place_at_contact(track, STRAIGHT, 0.0, 1.0, own_mps=25.0).offset_m == pytest.approx(-0.4 * side)


def test_who_turns_across_our_way_or_leaves_it_goes_on():
    coming = replace(TRACK, lateral_m=-2.4, lateral_speed_mps=2.0)
    # It turns: it moves along the road by 2 m/s, or towards us, as fast as it does across.
    for own_mps in (12.0, 8.0):
        assert place_at_contact(coming, STRAIGHT, 0.0, 2.0, own_mps=own_mps).offset_m == pytest.approx(1.6)
    leaving = replace(coming, lateral_m=0.4)
    assert place_at_contact(leaving, STRAIGHT, 0.0, 2.0, own_mps=25.0).offset_m == pytest.approx(4.4)


def test_the_sigma_is_that_of_samples_of_what_is_not_known():
    rng, n = np.random.default_rng(0), 200_000
    own, heading, bend = rng.normal(0, 1.0, n), rng.normal(0, 0.02, n), rng.normal(0, 0.005, n)
    now_m, x_m, v, t = 0.5, 20.0, 10.0, 2.0
    rate = own - (heading + bend * x_m) * v + rng.normal(0, 0.2, n)
    end_m = now_m - heading * x_m - bend * x_m**2 / 2 + own * t
    kept = np.abs(rate - 0.3) < 0.02
    there = place_at_contact(
        replace(TRACK, lateral_m=now_m, lateral_speed_mps=0.3, lateral_speed_sigma_mps=0.2),
        OwnPath(heading_sigma_rad=0.02, curvature_sigma_per_m=0.005),
        0.0,
        t,
    )
    assert there.offset_m == pytest.approx(float(end_m[kept].mean()), abs=0.05)
    assert there.sigma_m == pytest.approx(float(end_m[kept].std()), rel=0.03)
    assert math.isfinite(there.sigma_m)


@given(
    st.floats(3.0, 12.0),
    st.floats(0.5, 8.0),
    st.floats(0.5, 6.0),
    st.floats(1.0, 4.0),
    st.sampled_from([1, -1]),
)
def test_who_slows_before_our_path_stops_where_a_steady_braking_ends(
    aside_m, rate_mps, slowing_mps2, time_s, side
):
    until_s = min(time_s, rate_mps / slowing_mps2)
    travelled_m = rate_mps * until_s - slowing_mps2 * until_s**2 / 2
    track = replace(TRACK, lateral_m=-aside_m * side, lateral_speed_mps=rate_mps * side)
    steady = place_at_contact(track, STRAIGHT, 0.0, time_s)
    slows = place_at_contact(replace(track, lateral_slowing_mps2=slowing_mps2), STRAIGHT, 0.0, time_s)
    if travelled_m < aside_m - 1e-9:
        assert slows.offset_m == pytest.approx(side * (travelled_m - aside_m))
    elif travelled_m > aside_m + 1e-9:
        assert slows == steady


@given(st.floats(0.1, 6.0), st.floats(0.1, 6.0), st.floats(0.1, 6.0))
def test_who_moves_away_from_our_path_is_not_counted_on_to_stay(aside_m, rate_mps, slowing_mps2):
    leaves = replace(TRACK, lateral_m=aside_m, lateral_speed_mps=rate_mps)
    slows = replace(leaves, lateral_slowing_mps2=slowing_mps2)
    assert place_at_contact(slows, STRAIGHT, 0.0, 2.0) == place_at_contact(leaves, STRAIGHT, 0.0, 2.0)


FAR_ASIDE = replace(
    TRACK, lateral_m=-9.0, lateral_speed_mps=2.0, lateral_speed_sigma_mps=1.0, lateral_sigma_m=1.0
)


@given(st.floats(-12, -5), st.floats(10, 18), st.floats(-0.2, 0.2))
def test_far_aside_what_keeps_its_bearing_is_on_a_collision_course(lateral_m, low_m, yaw_rate_radps):
    # 20 m ahead at 10 m/s, two seconds: it keeps its bearing where it moves by half its place each second,
    # and what we turn by sweeps it across the picture.
    turn = Turn(own_mps=10.0, yaw_rate_radps=yaw_rate_radps)
    track = replace(
        FAR_ASIDE,
        lateral_m=lateral_m,
        distance_low_m=low_m,
        lateral_speed_by_bearing_mps=-lateral_m / 2 - 20.0 * yaw_rate_radps,
        lateral_speed_by_bearing_sigma_mps=0.1,
    )
    there = place_at_contact(track, STRAIGHT, 0.0, 2.0, turn)
    # Neither the filter's speed nor a distance that is little known matters.
    assert abs(there.offset_m) < 0.05
    assert there.sigma_m < 0.25


@pytest.mark.parametrize(
    ("lateral_m", "contact_s"), [(-4.0, 2.0), (-9.0, 0.9)], ids=["next lane", "a moment before contact"]
)
def test_near_aside_or_a_moment_before_contact_its_place_tells_better(lateral_m, contact_s):
    track = replace(FAR_ASIDE, lateral_m=lateral_m)
    told = replace(track, lateral_speed_by_bearing_mps=4.5, lateral_speed_by_bearing_sigma_mps=0.1)
    by_place = place_at_contact(track, STRAIGHT, 0.0, contact_s)
    assert place_at_contact(told, STRAIGHT, 0.0, contact_s) == by_place


def test_where_the_bearing_tells_less_the_place_counts():
    told = replace(FAR_ASIDE, lateral_speed_by_bearing_mps=4.5, lateral_speed_by_bearing_sigma_mps=3.0)
    assert place_at_contact(told, STRAIGHT, 0.0, 2.0) == place_at_contact(FAR_ASIDE, STRAIGHT, 0.0, 2.0)
