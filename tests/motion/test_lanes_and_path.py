"""Lane lines and the own path against pictures of painted roads, and by arithmetic."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_pictures import HEIGHT, WIDTH, Pose, Road, camera
from searching import examples

from fcw.camera.calibration import Calibration
from fcw.frame import ImageSize
from fcw.motion.bend.turn import USUAL_MPS
from fcw.motion.ego import EgoEstimator
from fcw.motion.lanes import Lane, find_lane
from fcw.motion.path import own_path
from fcw.motion.state import Mount, OwnMotion, OwnPath, SpeedSource
from fcw.motion.view import RoadView

VIEW = RoadView.of(camera(), 1)


def painted(lane_m=3.5, offset_m=0.0, bend_per_m=0.0, yaw_deg=0.0, growth_per_m2=0.0):
    road = Road(lines_m=(offset_m + lane_m / 2, offset_m - lane_m / 2))
    picture = road.picture(
        Pose(), yaw_deg=yaw_deg, lane_of=lambda x: bend_per_m * x**2 / 2 + growth_per_m2 * x**3 / 6
    )
    return np.ascontiguousarray(picture[:, :, 1])


@pytest.mark.parametrize(("offset_m", "lane_m"), [(0.0, 3.5), (0.6, 3.5), (-0.5, 3.0)])
def test_the_lane_is_where_it_is_painted(offset_m, lane_m):
    lane = find_lane(painted(lane_m, offset_m), VIEW, 0.0, 0.0)
    assert lane is not None
    assert lane.mean[0] == pytest.approx(offset_m, abs=0.12)
    assert lane.mean[1] == pytest.approx(0.0, abs=math.radians(0.5))
    assert lane.mean[4] == pytest.approx(lane_m, abs=0.15)


@pytest.mark.parametrize("radius_m", [150.0, -300.0, 800.0])
def test_a_bend_is_met_within_half_a_metre_at_thirty_metres(radius_m):
    lane = find_lane(painted(bend_per_m=1 / radius_m), VIEW, 0.0, 0.8 / radius_m)
    assert lane is not None
    path = own_path(OwnMotion(), lane)
    assert path.lateral_at(30.0) == pytest.approx(30.0**2 / 2 / radius_m, abs=0.5)


@pytest.mark.parametrize("growth_per_m2", [2e-4, -3e-4])
def test_a_bend_that_begins_ahead_is_seen_before_we_steer(growth_per_m2):
    # Straight here, and a radius of 80 to 125 m where the lines are still seen, 40 m on.
    lane = find_lane(painted(growth_per_m2=growth_per_m2), VIEW, 0.0, 0.0, 11.0)
    assert lane is not None
    assert lane.mean[2] == pytest.approx(0.0, abs=1e-3)
    straight_on = OwnMotion(speed_mps=11.0, yaw_rate_radps=0.0, mount=Mount(pitch_rad=0.0))
    path = own_path(straight_on, lane)
    assert path.lateral_at(35.0) == pytest.approx(growth_per_m2 * 35.0**3 / 6, abs=0.4)
    assert path.slope_at(35.0) == pytest.approx(growth_per_m2 * 35.0**2 / 2, abs=0.04)


@given(st.floats(-0.8, 0.8), st.floats(2.8, 4.2), st.floats(-2e-3, 2e-3))
@examples(15)
def test_the_lane_of_the_mirrored_road_is_mirrored(offset_m, lane_m, bend_per_m):
    road = Road(lines_m=(offset_m + lane_m / 2, offset_m - lane_m / 2))
    grey = np.ascontiguousarray(road.picture(Pose(), lane_of=lambda x: bend_per_m * x**2 / 2)[:, :, 1])
    mirrored_px = grey.shape[1] - 1 - VIEW.column_px
    there = RoadView(VIEW.focal_px, mirrored_px, VIEW.row_px, VIEW.pitch_rad, VIEW.height_m)
    lane = find_lane(grey, VIEW, 0.0, bend_per_m)
    other = find_lane(np.ascontiguousarray(grey[:, ::-1]), there, 0.0, -bend_per_m)
    assert (lane is None) == (other is None)
    if lane is not None and other is not None:
        # Places of ridges are as fine as the grid of the road, 5 cm.
        assert other.mean[0] == pytest.approx(-lane.mean[0], abs=0.03)
        assert other.mean[1] == pytest.approx(-lane.mean[1], abs=2e-3)
        assert other.mean[4] == pytest.approx(lane.mean[4], abs=0.03)


@given(st.floats(0.0, 120.0), st.floats(-0.02, 0.02), st.floats(-5e-4, 5e-4))
def test_the_slope_of_a_path_is_the_rate_of_its_lateral_position(distance_m, curvature_per_m, growth_per_m2):
    path = OwnPath(heading_rad=0.01, curvature_per_m=curvature_per_m, growth_per_m2=growth_per_m2)
    rate = (path.lateral_at(distance_m + 1e-3) - path.lateral_at(distance_m - 1e-3)) / 2e-3
    assert path.slope_at(distance_m) == pytest.approx(rate, abs=1e-5)


def test_a_bend_does_not_grow_on_where_no_line_was_seen():
    path = OwnPath(growth_per_m2=1e-4)
    assert path.slope_at(60.0) - path.slope_at(50.0) == pytest.approx(10 * 40 * 1e-4)


def test_a_camera_that_looks_to_the_left_sees_a_path_to_the_right():
    lane = find_lane(painted(yaw_deg=3.0), VIEW, -math.radians(2.0), 0.0)
    assert lane is not None
    assert math.degrees(lane.mean[1]) == pytest.approx(-3.0, abs=0.4)


def test_a_plain_road_has_no_lane():
    assert find_lane(np.full((HEIGHT, WIDTH), 90, np.uint8), VIEW, 0.0, 0.0) is None


def test_without_lines_the_path_is_that_of_mount_and_yaw_rate():
    motion = OwnMotion(
        speed_mps=20.0,
        speed_sigma_mps=0.3,
        speed_source=SpeedSource.PICTURE,
        yaw_rate_radps=0.05,
        yaw_rate_sigma_radps=1e-6,
        mount=Mount(pitch_rad=0.0, yaw_rad=0.05),
    )
    path = own_path(motion, None)
    assert path.heading_rad == pytest.approx(-0.05)
    assert path.curvature_per_m == pytest.approx(0.0025)
    assert path.lateral_at(20.0) == pytest.approx(-0.05 * 20 + 0.0025 * 200)
    assert path.lane_width_m is None


@pytest.mark.parametrize(
    ("across_mps2", "sigma_mps2"), [(0.0, 0.15), (0.5, 0.25), (1.0, 0.427), (4.0, 0.522)]
)
def test_the_sharper_a_bend_the_less_is_known_of_how_it_goes_on(across_mps2, sigma_mps2):
    # A part of the acceleration across, up to 0.5 m/s^2, beside the 0.15 m/s^2 of every road.
    motion = OwnMotion(
        speed_mps=10.0,
        speed_source=SpeedSource.PICTURE,
        yaw_rate_radps=across_mps2 / 10,
        yaw_rate_sigma_radps=1e-4,
    )
    assert own_path(motion, None).curvature_sigma_per_m * 10**2 == pytest.approx(sigma_mps2, rel=0.01)


@pytest.mark.parametrize(("sigma_radps", "part"), [(0.005, 1 / 1.01), (0.05, 1 / 2), (0.5, 1 / 101)])
def test_a_turn_that_is_little_known_is_believed_as_far_as_roads_bend(sigma_radps, part):
    # At 20 m/s roads bend with 1 / 400 m, that is 0.05 rad/s.
    motion = OwnMotion(speed_mps=20.0, yaw_rate_radps=0.05, yaw_rate_sigma_radps=sigma_radps)
    path = own_path(motion, None)
    assert path.curvature_per_m == pytest.approx(part * 0.0025)
    assert path.curvature_sigma_per_m < math.hypot(0.0025, 0.65 / 20**2)


def test_a_turn_at_an_unknown_speed_is_a_bend_that_is_little_known():
    straight, bent = (own_path(OwnMotion(yaw_rate_radps=rate), None) for rate in (0.0, 0.12))
    assert (straight.curvature_per_m, bent.curvature_per_m) == (0.0, pytest.approx(0.12 / USUAL_MPS))
    assert straight.curvature_sigma_per_m == own_path(OwnMotion(), None).curvature_sigma_per_m
    # R = 50 m at the same yaw rate and 6 m/s, 200 m at 24 m/s.
    assert abs(0.12 / 24 - bent.curvature_per_m) < bent.curvature_sigma_per_m


def test_when_we_stand_there_is_no_bend():
    motion = OwnMotion(speed_mps=0.5, speed_source=SpeedSource.PICTURE, yaw_rate_radps=0.05)
    assert own_path(motion, None).curvature_per_m == 0.0


def test_lines_and_motion_are_weighed_by_their_sigmas():
    lane = Lane(np.array([0.4, 0.0, 0.0, 0.0, 3.5]), np.diag([0.01, 1e-4, 1e-6, 1e-8, 0.01]))
    path = own_path(OwnMotion(mount=Mount(pitch_rad=0.0)), lane)
    assert 0.3 < path.offset_m < 0.4
    assert path.offset_sigma_m < 0.1
    assert path.lane_width_m == 3.5


def test_what_is_given_goes_before_the_picture_which_stays_beside_it():
    ego = EgoEstimator(Calibration.from_camera(camera(), ImageSize(WIDTH, HEIGHT)))
    road, state = Road(), None
    for frame in range(8):
        state = ego.update(frame * 100_000_000, road.picture(Pose(frame * 1.0)), (), 9.4, 0.02)
    assert state is not None
    motion = state.motion
    assert (motion.speed_mps, motion.speed_sigma_mps) == (9.4, 0.0)
    assert motion.speed_source is SpeedSource.GIVEN
    assert motion.picture_speed_mps == pytest.approx(10.0, rel=0.05)
    assert motion.yaw_rate_radps == 0.02


def test_without_pictures_there_is_only_what_is_given():
    state = EgoEstimator().update(0, np.zeros((4, 4, 3), np.uint8), (), 12.0, None)
    assert state.motion.speed_mps == 12.0
    assert state.motion.mount is None
    assert state.path.heading_rad == 0.0
