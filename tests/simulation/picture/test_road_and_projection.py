"""The road's course against its mathematics, and its picture against the ground-plane camera."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.simulation.picture.projection import dynamic_camera, project
from fcw.simulation.world.road import Lane, RoadProfile, Swell
from fcw.simulation.world.state import VEHICLE_SIZES, EgoState, VehicleKind, VehicleState, WorldState

CAMERA = GroundPlaneCamera(0.03, 1000.0, 360.0, 1.35, 640.0)


def road(bends: tuple[Swell, ...] = (), grades: tuple[Swell, ...] = ()) -> RoadProfile:
    return RoadProfile((Lane(0.0, 3.6),), (), -2.5, 2.5, bends, grades)


def vehicle(s_m: float, lateral_m: float, heading_rad: float = 0.0) -> VehicleState:
    return VehicleState(
        name="other",
        kind=VehicleKind.SALOON,
        size=VEHICLE_SIZES[VehicleKind.SALOON],
        color=(0, 0, 0),
        seed=0,
        s_m=s_m,
        lateral_m=lateral_m,
        heading_rad=heading_rad,
    )


@given(
    distance_m=st.floats(1.0, 300.0),
    lateral_m=st.floats(-20.0, 20.0),
    start_m=st.floats(-100.0, 2000.0),
    pitch_rad=st.floats(-0.03, 0.03),
    bounce_m=st.floats(-0.1, 0.1),
)
def test_on_a_flat_straight_road_the_picture_is_the_ground_plane_cameras(
    distance_m, lateral_m, start_m, pitch_rad, bounce_m
):
    state = WorldState(0, EgoState(s_m=start_m), (), road())
    u, v = project(state.road_points(start_m + distance_m, lateral_m), CAMERA, pitch_rad, bounce_m)
    now = dynamic_camera(CAMERA, pitch_rad, bounce_m)
    assert v == pytest.approx(now.row_at(distance_m), abs=1e-6)
    assert u == pytest.approx(now.column_at(lateral_m, distance_m), abs=1e-6)


def test_points_behind_the_camera_have_no_pixel():
    u, v = project(np.array([-5.0, 0.0, 0.0]), CAMERA)
    assert np.isnan(u)
    assert np.isnan(v)


def test_curvature_turns_the_heading_and_grade_raises_the_road():
    bend, grade = Swell(100.0, 300.0, 1 / 400), Swell(200.0, 200.0, 0.04)
    profile = road((bend,), (grade,))
    # The mean of sin^2 is one half.
    assert profile.heading_at(1000.0) == pytest.approx(0.5 * 300 / 400)
    assert profile.world_points(1000.0, 0.0)[2] == pytest.approx(0.5 * 200 * 0.04, rel=1e-6)
    s_m = np.linspace(50, 450, 100)
    slope = (profile.heading_at(s_m + 1e-3) - profile.heading_at(s_m - 1e-3)) / 2e-3
    curvature = np.where((s_m > 100) & (s_m < 400), np.sin(np.pi * (s_m - 100) / 300) ** 2 / 400, 0.0)
    np.testing.assert_allclose(slope, curvature, atol=1e-8)


@given(st.floats(-50.0, 900.0), st.floats(0.5, 5.0))
def test_arc_length_is_the_length_of_the_line(start_m, length_m):
    profile = road((Swell(100.0, 300.0, 1 / 300), Swell(350.0, 200.0, -1 / 250)), (Swell(50.0, 600.0, 0.05),))
    points = profile.world_points(np.linspace(start_m, start_m + length_m, 50), 0.0)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(length_m, rel=1e-4)


def test_a_constant_distance_looks_the_same_wherever_the_road_is_straight():
    profile = road((Swell(100.0, 200.0, 1 / 300),), (Swell(100.0, 200.0, 0.05),))
    before = WorldState(0, EgoState(s_m=0.0), (), profile).road_points(40.0, 1.0, 0.5)
    after = WorldState(0, EgoState(s_m=500.0), (), profile).road_points(540.0, 1.0, 0.5)
    np.testing.assert_allclose(after, before, atol=1e-9)
    np.testing.assert_allclose(before, (40.0, 1.0, 0.5), atol=1e-9)


def test_a_left_bend_shifts_what_is_ahead_to_the_left_and_a_crest_hides_it_below():
    bend = WorldState(0, EgoState(s_m=100.0), (), road((Swell(100.0, 400.0, 1 / 300),)))
    assert bend.road_points(180.0, 0.0)[1] > 0.5
    crest = WorldState(0, EgoState(s_m=100.0), (), road((), (Swell(100.0, 400.0, -0.05),)))
    assert crest.road_points(180.0, 0.0)[2] < -0.2


@given(st.floats(-0.3, 0.3), st.floats(-4.0, 4.0))
def test_a_body_keeps_its_measures_and_its_near_face_its_place(heading_rad, lateral_m):
    profile = road((Swell(0.0, 400.0, 1 / 300),), (Swell(0.0, 400.0, 0.04),))
    other = vehicle(90.0, lateral_m, heading_rad)
    state = WorldState(0, EgoState(s_m=60.0), (other,), profile)
    size = other.size
    near, far, top = state.vehicle_points(
        other, np.array([(0.0, 0.0, 0.0), (size.length_m, 0.0, 0.0), (0.0, 0.0, size.height_m)])
    )
    np.testing.assert_allclose(near, state.road_points(90.0, lateral_m), atol=1e-12)
    assert np.linalg.norm(far - near) == pytest.approx(size.length_m)
    assert np.linalg.norm(top - near) == pytest.approx(size.height_m)


def test_heading_turns_a_body_to_the_left():
    other = vehicle(30.0, 0.0, math.radians(10))
    state = WorldState(0, EgoState(s_m=0.0), (other,), road())
    far = state.vehicle_points(other, np.array((4.0, 0.0, 0.0)))
    np.testing.assert_allclose(far, (30 + 4 * math.cos(math.radians(10)), 4 * math.sin(math.radians(10)), 0))
