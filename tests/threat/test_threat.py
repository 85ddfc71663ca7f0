"""The threat of one vehicle: times, overlap, probability, braking and steering, by closed forms and
samples."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from leads.warning_leads import make_lead

from fcw.motion.bend.turn import turn_of
from fcw.motion.path import assumed_path, own_path
from fcw.motion.state import STRAIGHT, OwnMotion, OwnPath
from fcw.threat.threat import assess, reach_s, required_deceleration_mps2
from fcw.tracking.lead import select_lead

PARTS = [(0.25, 1.325), (0.5, 0.8875), (0.75, 0.44375), (-0.1, 1.95)]


def threat(track, path=STRAIGHT, own_mps=None, lead_id=1):
    (found,) = assess((track,), lead_id, path, own_mps)
    return found


@given(st.floats(1, 80), st.floats(0.5, 30), st.floats(0, 8))
def test_the_distance_is_used_up_when_it_says(distance_m, closing_mps, growth_mps2):
    time_s = reach_s(distance_m, closing_mps, growth_mps2)
    assert time_s is not None
    assert closing_mps * time_s + growth_mps2 * time_s**2 / 2 == pytest.approx(distance_m)
    assert reach_s(distance_m, closing_mps, -3.0) == pytest.approx(distance_m / closing_mps)
    assert reach_s(distance_m, -closing_mps, 3.0) is None


def test_a_vehicle_straight_ahead():
    found = threat(make_lead(20, 10, 1.0))
    assert (found.reach_s, found.overlap_m) == (pytest.approx(2.0), pytest.approx(1.775))
    assert found.reach_low_s == pytest.approx(20 / 11)
    assert found.reach_high_s == pytest.approx(20 / 9)
    assert found.collision_probability == pytest.approx(1.0, abs=0.01)
    assert found.required_deceleration_mps2 == pytest.approx(2.5)
    # 1.775 m aside, and 0.3 m of room, in two seconds.
    assert found.required_lateral_mps2 == pytest.approx(2 * 2.075 / 4)


def test_where_the_gap_may_not_close_there_is_no_latest_time_and_where_it_opens_none_at_all():
    assert threat(make_lead(20, 1.0, 2.0)).reach_high_s == math.inf
    opening = threat(make_lead(20, -1.0, 0.2))
    assert (opening.reach_s, opening.required_deceleration_mps2, opening.required_lateral_mps2) == (None,) * 3
    assert opening.collision_probability == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("overlap", "lateral_m"), PARTS)
def test_partial_overlap_is_the_width_shared(overlap, lateral_m):
    # Both are about 1.775 m wide in the mean.
    found = threat(make_lead(15, 10, lateral_m=lateral_m))
    assert found.overlap_m == pytest.approx(1.775 * overlap, abs=0.02)
    assert found.overlap_probability == (1.0 if overlap > 0 else 0.0)


def test_a_car_seen_from_a_corner_is_no_wider_than_cars_are_and_a_lorry_is():
    corner = replace(make_lead(15, 10), width_m=2.6)
    assert threat(corner).overlap_m == pytest.approx(1.8)
    lorry = replace(corner, box=replace(corner.box, h=corner.box.w * 1.3))
    assert threat(lorry).overlap_m == pytest.approx(2.2)


def across(lateral_m, distance_m=15.0, closing_mps=10.0):
    """A car 4.2 m long and 1.5 m high, seen from its side."""
    track = make_lead(distance_m, closing_mps, lateral_m=lateral_m)
    return replace(track, width_m=4.2, box=replace(track.box, w=4.2 * track.box.h / 1.5))


@pytest.mark.parametrize("own_mps", [8.5, 10.0, 11.5])
def test_a_car_that_stands_across_our_lane_is_as_wide_as_it_is_long(own_mps):
    # Its middle is 2 m aside, so that 1 m of its length is before us.
    assert threat(across(-2.0), own_mps=own_mps).overlap_m == pytest.approx(1.0)
    assert threat(across(-4.0), own_mps=own_mps).overlap_m == pytest.approx(-1.0)


@pytest.mark.parametrize("own_mps", [None, 20.0], ids=["speed unknown", "drives along the road"])
def test_a_car_that_may_turn_off_is_no_wider_than_cars_are(own_mps):
    assert threat(across(-2.0), own_mps=own_mps).overlap_m == pytest.approx(-0.2)


def test_a_neighbour_that_shows_all_of_its_side_does_not_stand_across():
    # 3.5 m aside and 5 m ahead its side, 4.2 m long, adds 1.2 m to its rear.
    neighbour = replace(across(-3.5, distance_m=5.0), width_m=3.0)
    assert threat(neighbour, own_mps=10.0).overlap_m == pytest.approx(-1.7)


def test_the_probability_is_that_of_samples():
    track = replace(make_lead(18, 9, lateral_m=1.2), lateral_sigma_m=0.4, lateral_speed_sigma_mps=0.0)
    found = threat(track, OwnPath(offset_sigma_m=0.3))
    rng = np.random.default_rng(0)
    offset_m = 1.2 + rng.normal(0, 0.5, 200_000)
    assert found.overlap_probability == pytest.approx(float((np.abs(offset_m) < 1.775).mean()), abs=0.005)


@pytest.mark.parametrize(
    ("distance_m", "own_mps", "curvature_sigma_per_m", "changes"),
    [
        (20.0, 10.0, 3e-3, True),  # 0.6 m at 20 m
        (10.0, 10.0, 3e-3, False),  # 0.15 m at 10 m
        (40.0, 10.0, 1e-3, False),  # a steady bend
        (20.0, None, 3e-3, True),  # at the usual speed
    ],
)
def test_a_bend_that_changes_counts_where_it_moves_the_path(
    distance_m, own_mps, curvature_sigma_per_m, changes
):
    path = OwnPath(curvature_sigma_per_m=curvature_sigma_per_m)
    turn = turn_of(OwnMotion(speed_mps=own_mps, yaw_rate_radps=0.1))
    (found,) = assess((make_lead(distance_m, 5.0),), 1, path, own_mps, turn=turn)
    assert found.bend_changes is changes


def test_a_lead_straight_ahead_is_in_our_way_also_where_our_turning_is_poorly_known():
    """A lorry on a motorway, at 10 pictures a second: at 28 m/s nobody turns far from the lane at once."""
    track = replace(make_lead(28.0, 12.0), lateral_sigma_m=0.2, lateral_speed_sigma_mps=0.28)
    path = OwnPath(offset_sigma_m=0.12, heading_sigma_rad=0.011, curvature_sigma_per_m=6e-4, lane_width_m=3.5)
    for sigma_deg in (0.3, 1.0, 1.5, 2.9):
        rate = OwnMotion(speed_mps=28.0, yaw_rate_radps=0.0, yaw_rate_sigma_radps=math.radians(sigma_deg))
        (found,) = assess((track,), 1, path, 28.0, turn=turn_of(rate))
        assert found.overlap_probability > 0.9


@pytest.mark.parametrize(
    ("age_s", "growth_mps2", "brakes"),
    [(1.0, 1.2, False), (1.0, 3.0, True), (3.0, 1.2, True), (3.0, 0.9, False)],
)
def test_a_vehicle_just_found_brakes_only_if_that_is_sure(age_s, growth_mps2, brakes):
    track = replace(
        make_lead(30.0, 6.0),
        age_s=age_s,
        closing_acceleration_mps2=growth_mps2,
        closing_acceleration_sigma_mps2=1.2,
    )
    found = threat(track)
    assert found.reach_s is not None
    assert (found.reach_s < 30.0 / 6.0 - 0.1) is brakes


def test_the_most_urgent_is_first_and_what_may_be_none_is_last():
    far, near = make_lead(40, 10, track_id=1), make_lead(15, 10, track_id=2)
    beside, ghost = make_lead(8, 10, track_id=3, lateral_m=6.0), replace(near, track_id=4, doubtful=True)
    found = assess((far, near, beside, ghost), 1, STRAIGHT, 20.0)
    assert [one.track.track_id for one in found] == [2, 1, 3, 4]
    assert [one.is_lead for one in found] == [False, True, False, False]


def test_a_path_that_nobody_measured_is_straight_and_less_certain_than_one_with_a_yaw_rate():
    unknown = assumed_path(20.0)
    turning, straight = (
        own_path(OwnMotion(speed_mps=20.0, yaw_rate_radps=rate_radps), None) for rate_radps in (0.1, 0.0)
    )
    assert unknown.curvature_per_m == 0
    assert turning.curvature_per_m == pytest.approx(0.1 / 20, rel=0.02)
    assert straight.curvature_sigma_per_m < unknown.curvature_sigma_per_m
    assert straight.curvature_sigma_per_m < turning.curvature_sigma_per_m


@given(st.floats(0.1, 200), st.floats(0.1, 60))
def test_required_deceleration_stops_the_closing_exactly_at_contact(distance_m, closing_mps):
    deceleration = required_deceleration_mps2(distance_m, closing_mps)
    assert deceleration is not None
    stopping_s = closing_mps / deceleration
    assert closing_mps * stopping_s - deceleration * stopping_s**2 / 2 == pytest.approx(distance_m)


def test_required_deceleration_of_a_gap_that_opens_is_none_and_at_contact_infinite():
    assert required_deceleration_mps2(10, 0) is None
    assert required_deceleration_mps2(0, 1) == math.inf
    assert required_deceleration_mps2(1, 1e300) == math.inf  # as a log may state it


@pytest.mark.parametrize(("own_sigma_mps", "oncoming"), [(None, True), (0.0, True), (3.0, False)])
def test_a_standing_car_comes_towards_us_only_if_our_speed_is_surely_lower(own_sigma_mps, oncoming):
    """It closes at 20 m/s, and we are said to drive at 16."""
    track = make_lead(40, 20.0, 0.3)
    (found,) = assess((track,), 1, STRAIGHT, 16.0, own_sigma_mps=own_sigma_mps)
    assert found.is_oncoming is oncoming
    assert (select_lead((track,), 16.0, own_sigma_mps) is None) is oncoming


@pytest.mark.parametrize(
    ("own_mps", "closing_mps", "sigma_mps", "drives"),
    [
        (18.0, 8.0, 1.0, True),
        (18.0, 14.5, 1.0, False),
        (18.0, 14.5, 0.1, True),
        (18.0, 18.0, 0.1, False),
        (18.0, 30.0, 0.1, False),
        (None, 8.0, 0.1, False),
    ],
)
def test_a_vehicle_drives_as_we_do_if_it_is_surely_faster_than_one_that_stands(
    own_mps, closing_mps, sigma_mps, drives
):
    (found,) = assess((make_lead(40, closing_mps, sigma_mps),), 1, STRAIGHT, own_mps)
    assert found.drives is drives
    if own_mps is not None:
        (found,) = assess((make_lead(40, closing_mps, sigma_mps),), 1, STRAIGHT, own_mps, own_sigma_mps=8.0)
        assert not found.drives


@pytest.mark.parametrize("bend_per_m", [1 / 150, -1 / 150, 0.0])
def test_an_oncoming_car_that_keeps_to_our_lane_round_a_bend_will_hit_us(bend_per_m):
    # Both at 14 m/s, 40 m apart: along the road it sweeps as what stands, and as much again.
    motion = OwnMotion(speed_mps=14.0, yaw_rate_radps=14.0 * bend_per_m)
    path, turn = replace(own_path(motion, None), curvature_per_m=bend_per_m), turn_of(motion)
    lateral_m, lateral_mps = path.lateral_at(40.0), -28.0 * path.slope_at(40.0)
    track = make_lead(40.0, 28.0, 0.5, lateral_m=lateral_m, lateral_mps=lateral_mps)
    (found,) = assess((track,), None, path, 14.0, turn=turn)
    assert found.is_oncoming
    assert found.offset_m == pytest.approx(0.0, abs=0.1)
    assert not found.crosses


def crossing(lateral_m, lateral_mps, closing_mps=6.0):
    return make_lead(8.0, closing_mps, 0.2, lateral_m=lateral_m, lateral_mps=lateral_mps)


@given(st.floats(-1.5, 1.5), st.floats(-8, 8))
def test_who_crosses_is_gone_for_as_long_as_it_says_when_we_are_there(lateral_m, lateral_mps):
    found = threat(crossing(lateral_m, lateral_mps), own_mps=10.0)
    assert found.reach_s is not None
    places_m = np.linspace(lateral_m, found.offset_m, 10_001)
    in_our_way = np.abs(places_m) <= found.overlap_m + abs(found.offset_m)
    if not in_our_way[0]:
        assert found.clear_s is None
        return
    gone_part = 1 - np.flatnonzero(in_our_way)[-1] / 10_000
    assert found.clear_s == pytest.approx(found.reach_s * gone_part, abs=1e-3)


@pytest.mark.parametrize(
    ("own_mps", "lateral_mps", "told"),
    [(10.0, 3.0, True), (4.0, 3.0, False), (None, 3.0, False), (4.0, -5.0, True), (None, -5.0, True)],
)
def test_who_leaves_our_way_and_may_come_towards_us_is_not_waited_for(own_mps, lateral_mps, told):
    # From 0.8 m to the left outwards, or over the middle to the other side.
    found = threat(crossing(0.8, lateral_mps), own_mps=own_mps)
    assert found.overlap_m < 0
    assert (found.clear_s is not None) == told
