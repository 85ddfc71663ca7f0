"""Measurements of range from boxes, by a level camera 1 m high with f = 1000 px: d = 1000 / (v - v0)."""

import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.types import Box
from fcw.sources.frame import ImageSize
from fcw.tracking.ranging import BoxNoise, measure_row, measures_width

CAMERA = GroundPlaneCamera(0.0, 1000.0, 360.0, 1.0, 640.0)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720))


def test_bottom_row_gives_the_inverse_distance_with_noise_linear_in_pixels():
    noise = BoxNoise(edge_floor_px=2.0, edge_fraction=0.0)
    row = measure_row(CALIBRATION, Box(600, 360, 80, 50), noise)
    assert row is not None
    assert row.inverse_distance_per_m == pytest.approx(1 / 20)
    assert row.sigma_per_m == pytest.approx(2 / 1000)


def test_noise_may_carry_a_bottom_row_through_the_horizon():
    row = measure_row(CALIBRATION, Box(600, 340, 20, 18), BoxNoise())
    assert row is not None
    assert row.inverse_distance_per_m == pytest.approx(-2 / 1000)


def test_distance_is_from_the_camera_whatever_the_reference():
    with_bumper = Calibration.from_camera(CAMERA, ImageSize(1280, 720), reference_offset_m=2.0)
    assert measure_row(with_bumper, Box(600, 360, 80, 50), BoxNoise()) == measure_row(
        CALIBRATION, Box(600, 360, 80, 50), BoxNoise()
    )


@pytest.mark.parametrize(("bottom", "measures"), [(719.5, False), (718.0, False), (716.0, True)])
def test_a_box_cut_by_the_lower_border_is_no_row_measurement(bottom, measures):
    row = measure_row(CALIBRATION, Box(500, bottom - 200, 250, 200), BoxNoise())
    assert (row is not None) == measures


@pytest.mark.parametrize(("x", "measures"), [(-0.5, False), (1.0, False), (3.0, True), (1180.0, False)])
def test_a_box_cut_by_a_side_is_no_width_measurement(x, measures):
    assert measures_width(CALIBRATION, Box(x, 300, 100, 80)) == measures
