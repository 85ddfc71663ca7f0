"""What is seen from above stands where the tracks say, in vehicle axes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from review_drives import CAUTION_S, RATE_HZ, WARNING_S, header, result

from fcw.logs.overlay import LEVEL_COLORS, OTHER_TRACK_COLOR
from fcw.logs.records import FrameResult
from fcw.tracking.lead import Corridor
from fcw.warning.types import WarningLevel
from fcw_viz.review_app.picture import birds_eye
from fcw_viz.review_app.picture.birds_eye import Ground

HALF_WIDTH_M = Corridor().leave_m


def seen(one: FrameResult, **options: float) -> Ground:
    return birds_eye.ground(one, header().calibration, imperial=False, **options)


def at(time_s: float) -> FrameResult:
    return result(round(time_s * RATE_HZ))


def test_a_box_stands_with_its_rear_at_the_distance_and_its_middle_at_the_lateral_position():
    moment = at(WARNING_S)
    for vehicle in seen(moment).vehicles:
        (track,) = (track for track in moment.tracks if track.track_id == vehicle.track_id)
        length_m, _, height_m = vehicle.size_m
        x, y, z = vehicle.centre_m
        assert (x - length_m / 2, y, z - height_m / 2) == pytest.approx(
            (track.distance_m, track.lateral_m, 0)
        )


def test_a_box_is_as_wide_as_its_pixels_are_at_its_distance():
    # 80 px at 22.5 m from the bumper, 24.0 m from the camera, with a focal length of 500 px: 3.84 m.
    lead = next(vehicle for vehicle in seen(at(WARNING_S)).vehicles if vehicle.track_id == 7)
    assert lead.size_m[1] == pytest.approx(80 * 24.0 / 500, abs=0.06)


def test_the_lead_and_the_path_have_the_colour_of_the_warning_and_the_others_their_own():
    for time_s, level in ((CAUTION_S, WarningLevel.CAUTION), (WARNING_S, WarningLevel.WARNING)):
        ground = seen(at(time_s))
        assert ground.path_color == LEVEL_COLORS[level]
        colors = {vehicle.track_id: vehicle.color for vehicle in ground.vehicles}
        assert colors == {7: LEVEL_COLORS[level], 2: OTHER_TRACK_COLOR}


def test_the_arrow_points_to_where_the_vehicle_is_in_a_second_seen_from_us():
    moment = at(WARNING_S)
    lead, other = seen(moment).vehicles
    assert lead.arrow_m is not None
    (start, *_), (end, *_) = lead.arrow_m
    assert (start, end) == pytest.approx((22.5, 22.5 - 15.0))
    # It goes away at 1 m/s: from its front, ahead.
    assert other.arrow_m is not None
    (start, *_), (end, *_) = other.arrow_m
    assert end - start == pytest.approx(1.0)
    assert start > 50.0


def test_a_closing_speed_within_its_own_error_has_no_arrow():
    moment = at(WARNING_S)
    unsure = replace(
        moment, tracks=tuple(replace(track, closing_speed_sigma_mps=20.0) for track in moment.tracks)
    )
    assert [vehicle.arrow_m for vehicle in seen(unsure).vehicles] == [None, None]
    points, colors = birds_eye.arrows(seen(unsure).vehicles)
    assert points.shape == (0, 2, 3)
    assert colors.shape == (0, 3)


def test_an_unbounded_interval_ends_somewhere_and_holds_the_distance():
    other = next(vehicle for vehicle in seen(at(WARNING_S)).vehicles if vehicle.track_id == 2)
    (low, *_), (high, *_) = other.interval_m
    assert low == pytest.approx(45.0)
    assert 50.0 < high < math.inf


def test_the_nearest_vehicle_comes_first():
    ids = [vehicle.track_id for vehicle in seen(at(WARNING_S)).vehicles]
    assert ids == [7, 2]


def test_without_a_yaw_rate_the_path_is_straight():
    ground = seen(at(WARNING_S))
    assert ground.path_left_m[:, 1] == pytest.approx(HALF_WIDTH_M)
    assert ground.path_right_m[:, 1] == pytest.approx(-HALF_WIDTH_M)
    assert ground.path_left_m[-1, 0] == pytest.approx(birds_eye.PATH_LENGTH_M)


@given(st.floats(-0.02, 0.02).filter(lambda curvature: abs(curvature) > 1e-4))
def test_a_bent_path_runs_between_two_circles_about_the_same_middle(curvature_per_m: float):
    radius_m = 1 / curvature_per_m
    left, right = birds_eye.path_edges(curvature_per_m)
    centre = np.array([0.0, radius_m, 0.0])
    for edge, side in ((left, 1), (right, -1)):
        distances_m = np.linalg.norm(edge - centre, axis=1)
        assert distances_m == pytest.approx(abs(radius_m - side * HALF_WIDTH_M), rel=1e-6)


def test_a_turn_to_the_left_bends_the_path_to_the_left():
    # 20 m/s at 0.2 rad/s: a radius of 100 m, after a quarter of it ahead 3.2 m to the left.
    ground = seen(at(WARNING_S), yaw_rate_radps=0.2)
    middle = (ground.path_left_m + ground.path_right_m) / 2
    assert np.interp(25.0, middle[:, 0], middle[:, 1]) == pytest.approx(
        100 - math.sqrt(100**2 - 25**2), abs=0.05
    )


def test_labels_of_rings_stand_in_one_column_seen_from_the_eye_within_the_rings():
    places = [
        birds_eye.ring_label(distance_m, imperial=False)[1] for distance_m in birds_eye.RING_DISTANCES_M
    ]
    slopes = [-y / (x + birds_eye.EYE_BEHIND_M) for x, y, _ in places]
    assert slopes == pytest.approx([birds_eye.LABEL_SLOPE] * len(slopes))
    assert all(math.atan2(-y, x) <= birds_eye.RING_HALF_ANGLE_RAD for x, y, _ in places)


def test_rings_are_as_far_away_everywhere_as_their_words_say():
    for distance_m in birds_eye.RING_DISTANCES_M:
        assert np.linalg.norm(birds_eye.ring(distance_m), axis=1) == pytest.approx(distance_m)
        text, place = birds_eye.ring_label(distance_m, imperial=False)
        assert float(text.removesuffix(" m")) == distance_m
        assert math.hypot(*place) == pytest.approx(distance_m)
    assert birds_eye.ring_label(30.0, imperial=True)[0] == "98 ft"


def test_the_faces_of_a_strip_cover_it_once():
    left, right = birds_eye.path_edges(0.0)
    points = np.concatenate([left, right])
    a, b, c = points[birds_eye.strip_faces(birds_eye.PATH_POINTS)].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(birds_eye.PATH_LENGTH_M * 2 * HALF_WIDTH_M)
