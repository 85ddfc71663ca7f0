"""The range filter against analytical motion and exact projections, and its Jacobian against differences."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import Calibration, GroundPoint, matrix3
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.frame import ImageSize
from fcw.tracking.box_measurement import CAMERA, DISTANCE, POLE, SCALE, VEHICLE, BoxGeometry, Sighting
from fcw.tracking.own_speed import OwnSpeed
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

CAMERA_MODEL = GroundPlaneCamera(0.02, 740.0, 359.5, 1.4, 639.5)
SIZE = ImageSize(1280, 720)
EXACT = Calibration.from_camera(CAMERA_MODEL, SIZE)
NOISE = BoxNoise(edge_floor_px=1.0, edge_fraction=0.0, width_bias_sigma=0.0, at_tyres=False)
WIDTH_ONLY = replace(NOISE, free_height=False, shows_side=False)

CAR = RangeModel().rears[0]


def seen(distance_m, lateral_m=0.0, width_m=CAR.width_m, height_m=CAR.height_m, lower_px=0.0):
    """The box of a rear, by default as large as most."""
    box = CAMERA_MODEL.ground_box(distance_m, lateral_m, width_m, height_m)
    return Box(box.x, box.y + lower_px, box.w, box.h)


def followed(boxes, dt_s=0.1, noise=NOISE, calibration=EXACT, ego_speed_mps=None):
    """A filter that has seen one vehicle's boxes, the first of them when it began."""
    range_filter = RangeFilter(calibration, noise, RangeModel())
    assert range_filter.add(boxes[0], ego_speed_mps)
    for box in boxes[1:]:
        range_filter.predict(dt_s)
        range_filter.update([(0, box)], dt_s)
    return range_filter


@pytest.mark.parametrize("dt_s", [1 / 30, 0.1])
@pytest.mark.parametrize("noise", [NOISE, WIDTH_ONLY])
def test_exact_boxes_of_constant_closing_speed_are_followed(dt_s, noise):
    distances_m = np.arange(60.0, 15.0, -12.0 * dt_s)
    state = followed([seen(d) for d in distances_m], dt_s, noise).state(0)
    assert state.distance_m == pytest.approx(distances_m[-1], rel=0.01)
    assert state.closing_speed_mps == pytest.approx(12.0, rel=0.03)


AT_TYRES = replace(NOISE, at_tyres=True)
OVERHANG_M = CAR.overhang_m


def seen_to_tyres(distance_m, overhang_m=OVERHANG_M):
    """The box of a rear whose tyres meet the road farther away: what a camera sees of a car."""
    rear, foot_px = seen(distance_m), CAMERA_MODEL.row_at(distance_m + overhang_m)
    return Box(rear.x, rear.y, rear.w, foot_px - rear.y)


def test_a_box_that_ends_at_the_tyres_gives_the_distance_of_the_rear():
    distances_m = np.arange(30.0, 6.0, -0.5)
    state = followed([seen_to_tyres(d) for d in distances_m], noise=AT_TYRES).state(0)
    assert state.distance_m == pytest.approx(distances_m[-1], rel=0.01)
    assert state.closing_speed_mps == pytest.approx(5.0, rel=0.03)
    misread = followed([seen_to_tyres(d) for d in distances_m]).state(0)
    assert misread.distance_m > distances_m[-1] + OVERHANG_M / 2


def test_at_first_sight_the_row_alone_gives_the_distance_of_the_rear():
    # Of a car whose sides and roof are cut by the picture's border.
    box = seen_to_tyres(8.0)
    cut = Box(-0.5, -0.5, SIZE.width, box.bottom + 0.5)
    range_filter = RangeFilter(EXACT, AT_TYRES, RangeModel())
    assert range_filter.add(cut, None)
    assert range_filter.state(0).distance_m == pytest.approx(8.0, rel=0.02)


@pytest.mark.parametrize("overhang_m", [OVERHANG_M - 0.25, OVERHANG_M + 0.25])
def test_the_interval_of_a_near_vehicle_holds_the_truth_of_unusual_overhangs(overhang_m):
    distances_m = np.arange(20.0, 5.0, -0.25)
    boxes = [seen_to_tyres(d, overhang_m) for d in distances_m]
    low_m, high_m = followed(boxes, noise=AT_TYRES).state(0).distance_with_interval(0.0)[1:]
    assert low_m <= distances_m[-1] <= high_m


def test_a_braking_lead_is_followed_with_a_lag_of_half_a_second():
    # 2 s at a constant gap, then 4 m/s^2 for 1.5 s: closing at 6 m/s, and at 4 m/s half a second before.
    times_s = np.arange(0.0, 3.51, 0.1)
    distances_m = 25.0 - 2.0 * np.maximum(times_s - 2.0, 0.0) ** 2
    state = followed([seen(d) for d in distances_m]).state(0)
    assert 4.0 <= state.closing_speed_mps <= 6.0
    assert state.closing_acceleration_mps2 > 1.5


def test_a_body_that_dives_while_we_brake_does_not_make_the_interval_wrong():
    # Towards a standing vehicle, from 2 s on braking with 6 m/s^2, by which the body dives 0.7 degrees.
    dt_s, distance_m, speed_mps, pitch_rad = 0.1, 60.0, 15.0, 0.0
    range_filter = RangeFilter(EXACT, NOISE, RangeModel())
    range_filter.add(seen(distance_m), speed_mps)
    for k in range(40):
        gain_mps = -6.0 * dt_s if k >= 20 else 0.0
        distance_m -= (speed_mps + gain_mps / 2) * dt_s
        speed_mps += gain_mps
        pitch_rad += (1 - math.exp(-dt_s / 0.2)) * (math.radians(0.12) * gain_mps / dt_s - pitch_rad)
        range_filter.predict(dt_s, gain_mps)
        range_filter.update([(0, seen(distance_m, lower_px=740 * pitch_rad))], dt_s)
        state = range_filter.state(0)
        if k > 10:
            assert abs(math.log(state.distance_m / distance_m)) < 2 * state.log_distance_sigma
            assert abs(state.closing_speed_mps - speed_mps) < 2 * state.closing_speed_sigma_mps


def test_prediction_alone_is_motion_and_tells_the_growth_of_the_picture():
    range_filter = followed([seen(d) for d in np.arange(50.0, 30.0, -1.0)])
    before = range_filter.state(0)
    (growth,) = range_filter.predict(0.5)
    after = range_filter.state(0)
    moved_m = before.closing_speed_mps * 0.5 + before.closing_acceleration_mps2 * 0.5**2 / 2
    assert after.distance_m == pytest.approx(before.distance_m - moved_m)
    assert growth == pytest.approx(before.distance_m / after.distance_m)
    assert after.log_distance_sigma > before.log_distance_sigma


def test_one_wild_box_moves_the_distance_little():
    range_filter = followed([seen(30.0)] * 30)
    range_filter.predict(0.1)
    range_filter.update([(0, seen(12.0))], 0.1)
    assert range_filter.state(0).distance_m == pytest.approx(30.0, rel=0.1)


def test_a_width_learnt_near_by_is_the_ruler_far_out():
    # A car 1.4 m wide and 1.3 m high, which the prior takes to be farther away than it is.
    near = [seen(d, width_m=1.4, height_m=1.3) for d in np.arange(8.0, 40.0, 0.4)]
    came_near = followed(near)
    never_near = followed(near[-10:])
    assert came_near.state(0).width_m == pytest.approx(1.4, rel=0.06)
    assert came_near.state(0).log_distance_sigma < never_near.state(0).log_distance_sigma
    error = abs(came_near.state(0).distance_m / 39.6 - 1)
    assert error < abs(never_near.state(0).distance_m / 39.6 - 1)
    assert error < 0.05


def test_a_lorry_is_told_by_its_height_at_first_sight_and_by_its_rows_in_time():
    lorry = {"width_m": 2.6, "height_m": 3.4}
    assert followed([seen(40.0, **lorry)]).state(0).width_m == pytest.approx(2.6, rel=0.1)
    by_rows = followed([seen(d, **lorry) for d in np.arange(30.0, 12.0, -0.3)], noise=WIDTH_ONLY)
    assert by_rows.state(0).width_m == pytest.approx(2.6, rel=0.06)
    assert by_rows.state(0).distance_m == pytest.approx(12.3, rel=0.06)


def test_pitch_that_shifts_all_rows_alike_is_told_from_distance():
    def boxes(range_filter_boxes, lower_px):
        return [(k, seen(d, lateral_m=y, lower_px=lower_px)) for k, (d, y) in enumerate(range_filter_boxes)]

    places = [(12.0, 0.0), (20.0, 3.0), (35.0, -3.0)]
    range_filter = RangeFilter(EXACT, NOISE, RangeModel(calibration_pitch_sigma_rad=0.0))
    for _, box in boxes(places, 0.0):
        assert range_filter.add(box, None)
    for frame in range(40):
        range_filter.predict(0.1)
        range_filter.update(boxes(places, 6.0 if frame >= 30 else 0.0), 0.1)
    # Six rows are 0.46 degrees, and by rows alone 18 % at 35 m.
    assert range_filter.pitch_rad == pytest.approx(-6.0 / 740, rel=0.5)
    for slot, (distance_m, _) in enumerate(places):
        assert range_filter.state(slot).distance_m == pytest.approx(distance_m, rel=0.05)


@pytest.mark.parametrize("off_deg", [-1.0, 1.0])
def test_a_calibration_that_is_wrong_by_a_degree_is_overruled_by_vehicles(off_deg):
    wrong = Calibration.from_camera(
        GroundPlaneCamera(0.02 + math.radians(off_deg), 740.0, 359.5, 1.4, 639.5), SIZE
    )
    places = [(12.0, 0.0), (25.0, 3.0), (35.0, -3.0)]
    range_filter = RangeFilter(wrong, NOISE, RangeModel())
    boxes = [(slot, seen(d, lateral_m=y)) for slot, (d, y) in enumerate(places)]
    for _, box in boxes:
        assert range_filter.add(box, None)
    for _ in range(100):
        range_filter.predict(0.1)
        range_filter.update(boxes, 0.1)
    # By rows alone 35 m would read 25 or 59 m.
    for slot, (distance_m, _) in enumerate(places):
        assert range_filter.state(slot).distance_m == pytest.approx(distance_m, rel=0.12)


def test_a_mount_that_is_told_is_taken_over_and_not_at_once():
    told = RangeFilter(EXACT, NOISE, RangeModel())
    pitch_rad = CAMERA_MODEL.pitch_rad + math.radians(0.5)
    told.take_mount(pitch_rad, math.radians(0.1), 0.1)
    assert 0 < told.pitch_rad < math.radians(0.4)
    for _ in range(600):
        told.predict(0.1)
        told.take_mount(pitch_rad, math.radians(0.1), 0.1)
    assert told.pitch_rad == pytest.approx(math.radians(0.5), abs=math.radians(0.05))


def test_the_error_of_the_clicks_is_never_averaged_away():
    clicks = [GroundPoint(d, CAMERA_MODEL.row_at(d)) for d in (8.0, 15.0, 30.0)]
    clicked = calibrate(clicks, SIZE, CAMERA_MODEL.height_m, row_sigma_px=3.0)
    boxes = [seen(25.0)] * 300
    with_clicks = followed(boxes, calibration=clicked).state(0).log_distance_sigma
    without = followed(boxes).state(0).log_distance_sigma
    assert with_clicks > without
    assert with_clicks > 0.03


def test_boxes_that_are_all_too_wide_are_learnt_from_a_near_vehicle_and_help_with_a_far_one():
    too_wide = 1.12

    def box(distance_m, lateral_m=0.0):
        exact = seen(distance_m, lateral_m)
        return Box(exact.center_x - exact.w * too_wide / 2, exact.y, exact.w * too_wide, exact.h)

    def error_of_the_far_one(with_near, bias_sigma):
        noise = replace(NOISE, shows_side=False, width_bias_sigma=bias_sigma)
        range_filter = RangeFilter(EXACT, noise, RangeModel(fleet_width_sigma=0.0))
        boxes = [box(45.0), *((box(d, y) for d, y in ((8.0, 1.5), (10.0, -1.5))) if with_near else ())]
        for first in boxes:
            assert range_filter.add(first, None)
        for _ in range(5):
            range_filter.predict(0.1)
            range_filter.update(list(enumerate(boxes)), 0.1)
        return abs(range_filter.state(0).distance_m / 45.0 - 1)

    assert error_of_the_far_one(True, 0.06) < 0.9 * error_of_the_far_one(False, 0.06)
    assert error_of_the_far_one(True, 0.06) < 0.7 * error_of_the_far_one(True, 0.0)


def test_many_vehicles_do_not_average_away_what_is_common_to_their_widths():
    def sigma_of_the_far_one(common_sigma):
        range_filter = RangeFilter(EXACT, NOISE, RangeModel(fleet_width_sigma=common_sigma))
        boxes = [seen(50.0 + 5 * k, 3.0 * (k % 3 - 1)) for k in range(6)]
        for first in boxes:
            assert range_filter.add(first, None)
        for _ in range(3):
            range_filter.predict(0.1)
            range_filter.update(list(enumerate(boxes)), 0.1)
        return range_filter.state(0).log_distance_sigma

    assert sigma_of_the_far_one(0.06) > 1.03 * sigma_of_the_far_one(0.0)


def test_vehicles_that_are_forgotten_leave_the_others_as_they_were():
    range_filter = RangeFilter(EXACT, NOISE, RangeModel())
    for distance_m, lateral_m in ((10.0, 0.0), (20.0, 3.5), (30.0, -3.5)):
        range_filter.add(seen(distance_m, lateral_m), None)
    before = [range_filter.state(slot) for slot in range(3)]
    range_filter.keep([0, 2])
    assert [range_filter.state(0), range_filter.state(1)] == [before[0], before[2]]
    assert range_filter.count == 2


def test_a_box_cut_on_all_sides_starts_no_vehicle():
    range_filter = RangeFilter(EXACT, NOISE, RangeModel())
    assert not range_filter.add(Box(-0.5, -0.5, 400.0, 720.0), None)
    assert range_filter.count == 0


def test_a_box_cut_below_starts_a_vehicle_by_its_width():
    box = seen(3.0)
    cut = Box(box.x, box.y, box.w, 719.5 - box.y)
    assert followed([cut]).state(0).distance_m == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("distance_m", [6.0, 25.0, 70.0])
def test_the_jacobian_is_the_derivative_of_the_residuals_but_teaches_no_scale(distance_m):
    geometry = BoxGeometry(CAMERA_MODEL, SIZE, NOISE, RangeModel())
    camera = CAMERA_MODEL
    x = np.array([camera.horizon_row_px, math.log(camera.row_scale_m_px), camera.pole_m, 1.0, -2.0, 0.04])
    x = np.append(x, (math.log(distance_m), 0.1, 0.0, math.log(1.8), math.log(1.4), 0.02, 1.5, 3.0))
    covariance = np.diag(np.full(len(x), 1e-4))
    sightings = [Sighting(0, 0, seen(distance_m))]
    rows = geometry.measure(sightings, x, covariance, 0.1).rows
    step = 1e-6
    for k in range(CAMERA + VEHICLE):
        up, down = x.copy(), x.copy()
        up[k] += step
        down[k] -= step
        less, more = (geometry.measure(sightings, at, covariance, 0.1).residuals for at in (down, up))
        change = less - more
        if k not in (SCALE, POLE):
            assert rows[:, k] == pytest.approx(change / (2 * step), rel=1e-4, abs=1e-6)
    assert rows[:, SCALE] == pytest.approx(-rows[:, CAMERA + DISTANCE])
    assert not rows[:, POLE].any()


def test_own_braking_is_known_and_no_doing_of_the_lead():
    # We brake at 3 m/s^2 behind a lead that goes on at 12 m/s.
    dt_s, own_mps = 0.1, np.maximum(20.0 - 3.0 * np.arange(0.0, 3.0, 0.1), 12.0)
    distances_m = 40.0 - np.concatenate(([0.0], np.cumsum((own_mps - 12.0)[:-1] * dt_s)))
    told, untold = (RangeFilter(EXACT, NOISE, RangeModel()) for _ in range(2))
    for range_filter in (told, untold):
        assert range_filter.add(seen(distances_m[0]), own_mps[0])
    growths_mps2 = []
    for before_mps, now_mps, distance_m in zip(own_mps, own_mps[1:], distances_m[1:], strict=False):
        told.predict(dt_s, now_mps - before_mps)
        untold.predict(dt_s)
        for range_filter in (told, untold):
            range_filter.update([(0, seen(distance_m))], dt_s)
        growths_mps2.append(
            [range_filter.state(0).closing_acceleration_mps2 for range_filter in (told, untold)]
        )
    told_mps2, untold_mps2 = np.abs(growths_mps2).max(axis=0)
    assert told_mps2 < 0.5 < 1.0 < untold_mps2
    assert told.state(0).closing_speed_mps == pytest.approx(0.0, abs=0.4)


def roughly_known(focal_sigma):
    """A calibration whose focal length, and so every distance, is known so well, and its horizon to 2 px."""
    support_m = np.array((5.0, 10.0, 20.0))
    below_px = EXACT.camera.row_scale_m_px / (support_m + EXACT.camera.pole_m)
    covariance = focal_sigma**2 * np.outer(below_px, below_px) + 2.0**2
    return replace(EXACT, support_distances_m=(5.0, 10.0, 20.0), covariance=matrix3(covariance))


@pytest.mark.parametrize("seed", range(4))
def test_an_own_speed_that_the_camera_measured_teaches_no_scale(seed: int):
    """Dropped pictures make the measured speed jump; a car at 10 m stays where it is."""
    range_filter = RangeFilter(roughly_known(0.3), NOISE, RangeModel())
    range_filter.add(seen(10.0), 5.0)
    own = OwnSpeed()
    rng = np.random.default_rng(seed)
    for _ in range(250):
        gain_mps = own.update(0.04, 12.0 * rng.choice([0, 1, 1, 2]), 3.0)
        range_filter.predict(0.04, gain_mps, own_gain_sigma_mps=own.gain_sigma_mps)
        range_filter.update([(0, seen(10.0 * math.exp(rng.normal(0, 0.05))))], 0.04)
    assert range_filter.focal_px == pytest.approx(740.0, rel=0.1)
    assert range_filter.state(0).distance_m == pytest.approx(10.0, rel=0.3)
    assert range_filter.state(0).log_distance_sigma > 0.25


def test_the_distances_of_many_vehicles_teach_no_scale():
    range_filter = RangeFilter(roughly_known(0.3), NOISE, RangeModel())
    for distance_m in np.linspace(8.0, 50.0, 30):
        range_filter.add(seen(distance_m), None)
        for _ in range(3):
            range_filter.predict(0.1)
            range_filter.update([(0, seen(distance_m))], 0.1)
        assert range_filter.state(0).log_distance_sigma > 0.28
        range_filter.keep([])
    assert range_filter.focal_px == pytest.approx(740.0, rel=0.03)


@pytest.mark.parametrize("too_wide", [0.8, 1.25])
@pytest.mark.parametrize(("noise", "lead"), [(NOISE, seen(25.0)), (AT_TYRES, seen_to_tyres(25.0))])
def test_a_vehicle_whose_box_is_wrong_while_it_passes_teaches_no_scale(noise, lead, too_wide):
    """It is cut by the picture's edge or by another one, or shows more of its side than we think."""
    range_filter = RangeFilter(roughly_known(0.3), noise, RangeModel())
    passing = [seen(d, lateral_m=-2.5) for d in [*np.arange(30.0, 3.0, -0.2), *[3.0] * 50]]
    boxes = [Box(box.x, box.y, box.w * too_wide, box.h) for box in passing]
    assert all(range_filter.add(box, None) for box in (lead, boxes[0]))
    for box in boxes:
        range_filter.predict(0.04)
        range_filter.update([(0, lead), (1, box)], 0.04)
    assert range_filter.focal_px == pytest.approx(740.0, rel=0.05)


@pytest.mark.parametrize("doubtful", [(), (1,)])
def test_what_may_be_no_vehicle_teaches_nothing_of_the_camera(doubtful):
    """A near box that sinks by three degrees, say: a shadow, or the whole road at night."""
    range_filter = RangeFilter(EXACT, NOISE, RangeModel())
    assert all(range_filter.add(seen(distance_m), None) for distance_m in (25.0, 6.0))
    for lower_px in np.linspace(0.0, 40.0, 50):
        range_filter.predict(0.04)
        range_filter.update([(0, seen(25.0)), (1, seen(6.0, lower_px=lower_px))], 0.04, doubtful=doubtful)
    assert (abs(range_filter.pitch_rad) < math.radians(0.1)) == bool(doubtful)


def test_an_unknown_focal_length_leaves_places_across_the_road_known():
    """They are the camera's height times columns over rows: the focal length is in neither."""
    rough, exact = (
        followed([seen(30.0 - 0.5 * k) for k in range(20)], calibration=calibration).state(0)
        for calibration in (roughly_known(0.3), roughly_known(0.001))
    )
    assert rough.log_distance_sigma > 0.28
    assert rough.closing_speed_sigma_mps > 0.28 * rough.closing_speed_mps
    assert rough.log_across_sigma == pytest.approx(exact.log_across_sigma, rel=0.05)
    assert rough.across_rate_sigma_per_s == pytest.approx(exact.across_rate_sigma_per_s, rel=0.05)
    assert exact.log_across_sigma == pytest.approx(exact.log_distance_sigma, rel=0.01)


@given(log_scale=st.floats(-1.0, 1.0), distance_m=st.floats(5.0, 30.0), lateral_m=st.floats(2.5, 6.0))
def test_with_another_focal_length_vehicles_stand_as_far_beside_us(log_scale, distance_m, lateral_m):
    """The side of a car shrinks with its distance alone: else a wrong scale would feed itself."""
    model, box = RangeModel(), seen(distance_m, lateral_m)
    geometry = BoxGeometry(CAMERA_MODEL, SIZE, NOISE, model)
    beyond_m, length_m = [], model.rears[0].length_m
    for scale in (1.0, math.exp(log_scale)):
        view = geometry.view(box, 0, scale * distance_m, CAR.width_m, scale * CAMERA_MODEL.focal_y_px)
        part = math.sqrt(view.aspect_sigma**2 - model.aspect_sigma**2) / model.side_sigma
        side_m = CAR.width_m * part / (1 - part)
        beyond_m.append(side_m * (scale * distance_m + length_m) / length_m)
    assert beyond_m[1] == pytest.approx(beyond_m[0])
    assert beyond_m[0] == pytest.approx(lateral_m - CAR.width_m / 2, abs=0.01)
