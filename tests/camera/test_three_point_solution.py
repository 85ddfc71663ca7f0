"""The exact solution: the paper's example as worked out by hand, and random cameras given back."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
PAPER_POINTS = (GroundPoint(4, 461), GroundPoint(5, 428), GroundPoint(7, 383))


def test_papers_points_have_the_exact_but_implausible_solution():
    calibration = calibrate(PAPER_POINTS, SIZE, 1.225, exact=True)
    assert calibration.camera.pitch_rad == pytest.approx(1.10363, abs=5e-6)
    assert calibration.camera.focal_y_px == pytest.approx(260.928, abs=5e-4)
    assert calibration.camera.principal_row_px == pytest.approx(733.149, abs=5e-4)
    assert calibration.horizon_row_px == pytest.approx(215.857, abs=5e-4)
    assert calibration.residuals_px == pytest.approx((0, 0, 0), abs=1e-9)


@pytest.mark.parametrize(
    ("offset_m", "pitch_rad", "focal_px", "principal_row_px"),
    [(2.1, 0.262, 1200, 538), (2.28, 0.1207, 1267.8, 369.6), (2.4, 0.023, 1286, 246)],
)
def test_papers_points_form_a_family_over_the_bumper_offset(offset_m, pitch_rad, focal_px, principal_row_px):
    camera = calibrate(PAPER_POINTS, SIZE, 1.225, reference_offset_m=offset_m, exact=True).camera
    assert camera.pitch_rad == pytest.approx(pitch_rad, abs=5e-4)
    assert camera.focal_y_px == pytest.approx(focal_px, abs=0.5)
    assert camera.principal_row_px == pytest.approx(principal_row_px, abs=0.5)


def test_papers_printed_result_puts_its_own_rows_elsewhere():
    printed = GroundPlaneCamera(0.1194, 1094.313, 363.331, 1.225, 639.5)
    assert [printed.distance_at(row) for row in (461.0, 428.0, 383.0)] == pytest.approx(
        [5.79, 6.79, 8.86], abs=0.005
    )


@given(
    st.floats(-0.1, 0.35),
    st.floats(300, 3000),
    st.floats(-0.2, 0.2),
    st.floats(0.8, 3.0),
    st.lists(st.floats(3.0, 60.0), min_size=3, max_size=3),
    st.permutations(range(3)),
    st.floats(0, 3),
)
def test_random_plausible_cameras_come_back(
    pitch_rad, focal_px, off_middle, height_m, distances_m, order, offset_m
):
    near, middle, far = sorted(distances_m)
    assume(middle > 1.25 * near and far > 1.25 * middle)
    truth = GroundPlaneCamera(pitch_rad, focal_px, 359.5 + 720 * off_middle, height_m, 639.5)
    rows = [truth.row_at(d + offset_m) for d in (near, middle, far)]
    assume(all(-700 < row < 1400 for row in rows))
    points = [GroundPoint((near, middle, far)[k], rows[k]) for k in order]
    calibration = calibrate(points, SIZE, height_m, reference_offset_m=offset_m, exact=True)

    # a of 0 has no relative error: tan(a) enters as h tan(a) beside the distances.
    assert calibration.camera.pitch_rad == pytest.approx(pitch_rad, rel=1e-6, abs=1e-7)
    assert calibration.camera.focal_y_px == pytest.approx(focal_px, rel=1e-6)
    assert calibration.camera.principal_row_px == pytest.approx(truth.principal_row_px, rel=1e-6)
    for distance_m in (near, middle, far, 5.0, 10.0, 20.0, 40.0):
        row_px = truth.row_at(distance_m + offset_m)
        assert calibration.distance_at(row_px) == pytest.approx(distance_m, rel=1e-9)


@given(st.floats(0.5, 4.0), st.floats(0.5, 4.0))
def test_camera_height_cancels_out_of_every_distance(one_m, other_m):
    rows = np.linspace(250, 700, 10)
    one, other = (calibrate(PAPER_POINTS, SIZE, height_m, exact=True) for height_m in (one_m, other_m))
    assert one.distance_at(rows) == pytest.approx(other.distance_at(rows), rel=1e-9)


def test_distances_count_from_the_reference_and_the_camera_behind_it_sees_the_same_rows():
    points = [GroundPoint(p.distance_m + 2.0, p.row_px) for p in PAPER_POINTS]
    # The tape's error is a part of what was taped, and here nothing was.
    from_camera = calibrate(points, SIZE, 1.225, tape_error=0.0, exact=True)
    from_bumper = calibrate(PAPER_POINTS, SIZE, 1.225, 2.0, tape_error=0.0, exact=True)
    assert from_bumper.camera == from_camera.camera
    assert from_bumper.distance_at(300.0) == pytest.approx(from_camera.distance_at(300.0) - 2.0)
    assert from_bumper.row_at(10.0) == pytest.approx(from_camera.row_at(12.0))
    assert from_bumper.column_at(1.0, 10.0) == pytest.approx(from_camera.column_at(1.0, 12.0))
    assert from_bumper.ground_box(10.0, 1.0, 1.8, 1.5) == from_camera.ground_box(12.0, 1.0, 1.8, 1.5)
    low_m, high_m = from_camera.distance_interval(300.0)
    assert from_bumper.distance_interval(300.0) == pytest.approx((low_m - 2.0, high_m - 2.0))
    assert from_bumper.distance_at(100.0) == math.inf
