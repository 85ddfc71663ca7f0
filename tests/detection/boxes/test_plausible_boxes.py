"""Which boxes can be vehicles on the road: the geometry of the distance prior, applied to boxes."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.boxes.overlap import cut_to_picture
from fcw.detection.boxes.plausible import PlausibleVehicles, plausible
from fcw.detection.model import VehicleStatistics
from fcw.detection.windows.plan import DistancePrior
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 380.0, 1.5, 640.0)
VEHICLES = PlausibleVehicles()


def is_plausible(x: float, y: float, w: float, h: float) -> bool:
    return bool(plausible(np.array([[x, y, w, h]]), CAMERA, SIZE, VEHICLES)[0])


@given(st.floats(10, 1200), st.floats(0, 710), st.floats(-0.05, 0.2), st.floats(0.8, 2.5))
def test_boxes_inside_the_picture_are_judged_as_the_windows_of_the_detector(
    width, bottom, pitch_rad, height_m
):
    camera = GroundPlaneCamera(pitch_rad, 1000.0, 380.0, height_m, 640.0)
    widths = VehicleStatistics(VEHICLES.narrowest_m, 1.7, VEHICLES.widest_m, (10.0,), (1.0,))
    prior = DistancePrior(
        camera, widths, VEHICLES.nearest_m, VEHICLES.farthest_m, VEHICLES.pitch_tolerance_rad
    )
    rows = prior.bottom_rows(width)
    assume(rows is None or min(abs(bottom - rows.first_px), abs(bottom - rows.last_px)) > 1e-6)
    box = np.array([[640 - width / 2, bottom - 50, width, 50.0]])
    assert plausible(box, camera, SIZE, VEHICLES)[0] == (
        rows is not None and rows.first_px <= bottom <= rows.last_px
    )


@given(st.floats(3, 75), st.floats(0.7, 4.5), st.floats(-0.9, 0.9))
def test_every_vehicle_on_the_road_passes_with_the_camera_pitched_within_the_tolerance(
    distance_m, width_m, pitch_share
):
    pitched = GroundPlaneCamera(
        CAMERA.pitch_rad + pitch_share * VEHICLES.pitch_tolerance_rad, 1000.0, 380.0, 1.5, 640.0
    )
    bottom, width = pitched.row_at(distance_m), 1000.0 * width_m / distance_m
    assume(bottom < SIZE.height - 3)
    assume(width < 1270)
    assert is_plausible(640 - width / 2, bottom - 0.8 * width, width, 0.8 * width)


def test_a_vehicle_cut_off_below_stands_nearer_than_it_looks() -> None:
    # 2 m ahead and 1.8 m wide: 900 px wide, its bottom edge below the picture.
    assert CAMERA.row_at(2.0) > SIZE.height
    assert is_plausible(190, 100, 900, 619.5)
    # The same box a little above the border would be a vehicle 4.3 m wide with its bottom in sight.
    assert not is_plausible(190, 100, 1050, 500)


def test_a_vehicle_cut_off_aside_is_wider_than_it_looks() -> None:
    # 60 px of a vehicle 5 m ahead; in the middle of the picture that would be 0.3 m wide.
    bottom = CAMERA.row_at(5.0)
    assert is_plausible(-0.5, bottom - 250, 60, 250)
    assert not is_plausible(300, bottom - 250, 60, 250)


@pytest.mark.parametrize("box", [(-0.5, 660, 1280, 60), (-0.5, 420, 1280, 300), (400, 660, 600, 60)])
def test_the_own_bonnet_is_no_vehicle(box: tuple[float, float, float, float]) -> None:
    assert not is_plausible(*box)


@given(st.floats(2.05, 4), st.floats(1.05, 3), st.floats(-0.9, 0.9))
def test_a_near_vehicle_cut_off_below_passes_whatever_its_height(distance_m, height_m, pitch_share):
    pitched = GroundPlaneCamera(
        CAMERA.pitch_rad + pitch_share * VEHICLES.pitch_tolerance_rad, 1000.0, 380.0, 1.5, 640.0
    )
    rear = pitched.ground_box(distance_m, 0.0, 1.8, height_m)
    assume(rear.bottom > SIZE.height)
    assert is_plausible(rear.x, rear.y, rear.w, SIZE.height - 0.5 - rear.y)


@pytest.mark.parametrize(
    ("camera", "size", "vehicle"),
    [
        # A telephone held upright, 4.5 m behind a lorry that fills all of its picture's width.
        (GroundPlaneCamera(-0.05, 1712.0, 639.5, 1.5, 359.5), ImageSize(720, 1280), (4.5, 0.0, 2.5, 3.6)),
        (GroundPlaneCamera(-0.05, 956.0, 239.5, 1.63, 319.5), ImageSize(640, 480), (3.2, 0.0, 2.5, 3.6)),
        # Seen from below 1 m all that is cut off is low by its rows, and yet stands above the horizon.
        (GroundPlaneCamera(-0.1, 1075.0, 187.0, 0.55, 620.5), ImageSize(1242, 375), (5.0, -0.1, 1.8, 1.45)),
        (GroundPlaneCamera(-0.1, 985.0, 179.5, 0.7, 319.5), ImageSize(640, 360), (5.1, -0.5, 1.6, 1.4)),
    ],
)
def test_what_stands_above_the_horizon_is_no_bonnet(camera, size, vehicle):
    rear = camera.ground_box(*vehicle)
    cut = cut_to_picture(np.array([[rear.x, rear.y, rear.w, rear.h]]), size)
    assert cut[0, 1] + cut[0, 3] == size.height - 0.5
    assert plausible(cut, camera, size)[0]


def test_nothing_stands_in_the_sky() -> None:
    up_rad = CAMERA.pitch_rad + VEHICLES.pitch_tolerance_rad
    highest_horizon_px = CAMERA.principal_row_px - CAMERA.focal_y_px * math.tan(up_rad)
    assert not is_plausible(600, highest_horizon_px - 31, 30, 30)
