"""The camera over a flat road against the pinhole projection of points in space."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera

CAMERAS = st.builds(
    GroundPlaneCamera,
    pitch_rad=st.floats(-0.15, 0.35),
    focal_y_px=st.floats(300, 3000),
    principal_row_px=st.floats(100, 1000),
    height_m=st.floats(0.8, 3.0),
    principal_column_px=st.floats(200, 1200),
)
DISTANCES_M = st.floats(2.0, 200.0)


def project(camera: GroundPlaneCamera, forward_m: float, left_m: float, up_m: float) -> tuple[float, float]:
    """Column and row of a point, by rotating it into the camera's frame (x right, y down, z ahead)."""
    cosine, sine = math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
    down_m = camera.height_m - up_m
    y = cosine * down_m - sine * forward_m
    z = sine * down_m + cosine * forward_m
    column = camera.principal_column_px + camera.focal_y_px * -left_m / z
    return column, camera.principal_row_px + camera.focal_y_px * y / z


@given(CAMERAS, DISTANCES_M)
def test_row_is_that_of_the_projected_road_and_of_the_papers_equation(camera, distance_m):
    paper = camera.principal_row_px + camera.focal_y_px * math.tan(
        math.atan(camera.height_m / distance_m) - camera.pitch_rad
    )
    assert camera.row_at(distance_m) == pytest.approx(
        project(camera, distance_m, 0, 0)[1], rel=1e-10, abs=1e-8
    )
    assert camera.row_at(distance_m) == pytest.approx(paper, rel=1e-10, abs=1e-8)


@given(CAMERAS, DISTANCES_M)
def test_distance_at_inverts_row_at_above_and_below_the_principal_row(camera, distance_m):
    assert camera.distance_at(camera.row_at(distance_m)) == pytest.approx(distance_m, rel=1e-9)


@given(CAMERAS, DISTANCES_M, st.floats(-10, 10))
def test_lateral_and_column_invert_each_other_and_left_is_positive(camera, distance_m, lateral_m):
    column_px, row_px = project(camera, distance_m, lateral_m, 0)
    assert camera.column_at(lateral_m, distance_m) == pytest.approx(column_px, rel=1e-9, abs=1e-7)
    assert camera.lateral_at(column_px, row_px) == pytest.approx(lateral_m, rel=1e-7, abs=1e-7)
    assert camera.lateral_at(camera.principal_column_px - 1, row_px) > 0


@given(CAMERAS, st.floats(6, 100), st.floats(-5, 5), st.floats(0.5, 3), st.floats(0.5, 4))
def test_ground_box_is_the_tightest_box_around_the_projected_corners(
    camera, distance_m, lateral_m, width_m, height_m
):
    corners = [
        project(camera, distance_m, lateral_m + side * width_m / 2, up_m)
        for side in (-1, 1)
        for up_m in (0, height_m)
    ]
    columns, rows = zip(*corners, strict=True)
    box = camera.ground_box(distance_m, lateral_m, width_m, height_m)
    assert (box.x, box.y, box.right, box.bottom) == pytest.approx(
        (min(columns), min(rows), max(columns), max(rows)), rel=1e-9, abs=1e-7
    )
    assert box.bottom == pytest.approx(camera.row_at(distance_m), rel=1e-12)


def test_horizon_is_the_row_of_infinity():
    camera = GroundPlaneCamera(0.1, 1000, 360, 1.2, 640)
    assert camera.horizon_row_px == pytest.approx(360 - 1000 * math.tan(0.1))
    assert camera.row_at(math.inf) == pytest.approx(camera.horizon_row_px)
    assert camera.distance_at(camera.horizon_row_px) == math.inf
    assert camera.distance_at(camera.horizon_row_px - 50) == math.inf
    assert math.isnan(camera.lateral_at(10.0, camera.horizon_row_px))


def test_arrays_give_float64_arrays_and_scalars_give_floats():
    camera = GroundPlaneCamera(0.05, 900, 350, 1.3, 630)
    rows = np.array([100, 400, 500])
    distances = camera.distance_at(rows)
    assert isinstance(camera.distance_at(400), float)
    assert distances.dtype == np.float64
    assert distances.tolist() == [camera.distance_at(float(row)) for row in rows]
    metres = np.array([[5, 10], [20, 40]])
    assert camera.row_at(metres).tolist() == [[camera.row_at(float(d)) for d in row] for row in metres]
    assert isinstance(camera.row_at(np.float64(10)), float)
    assert isinstance(camera.lateral_at(600.0, 400.0), float)
    assert camera.lateral_at(np.array([600.0, 700.0]), np.array([400.0, 100.0])).shape == (2,)
    assert camera.column_at(np.array([1.0, -1.0]), np.array([10.0, 10.0])).shape == (2,)


def test_points_behind_the_camera_have_no_row_and_no_box():
    camera = GroundPlaneCamera(0.1, 1000, 360, 1.2, 640)
    assert camera.row_at(-1.0) == math.inf
    assert camera.row_at(np.array([-1.0]))[0] == math.inf
    assert math.isnan(camera.column_at(1.0, -1.0))
    with pytest.raises(ValueError, match="not in front of the camera"):
        camera.ground_box(-1.0, 0, 1.8, 1.5)


def test_rows_are_signed_where_the_papers_absolute_value_is_wrong():
    """The printed eq. 3 takes |v - v0|, wrong for all distances past h / tan(a), here 12 m."""
    camera = GroundPlaneCamera(0.1, 1000, 360, 1.2, 640)
    row_px = camera.row_at(30.0)
    assert row_px < camera.principal_row_px
    assert camera.distance_at(row_px) == pytest.approx(30.0)
