"""Proposed lane lines lie on the paint, and meet at the true horizon though another one was believed."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.vanishing import vanishing_row
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.self_calibration.lane_lines import YAWED_PICTURES, lanes_aside, meeting_point, propose_lane_lines
from fcw.sources import open_source
from fcw_viz.calibrate_app.proposals.drive_look import assumed_camera
from fcw_viz.page.pictures import Pictures

SIZE = ImageSize(1280, 720)
TRUE = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
DEMO_HORIZON_ROW_PX = 329.8


def road(bend_per_m: float = 0.0) -> np.ndarray:
    noise = np.random.default_rng(5).normal(0, 3, (SIZE.height, SIZE.width, 1))
    image = np.clip(90 + noise, 0, 255).astype(np.uint8).repeat(3, axis=2)
    distances_m = np.linspace(3.0, 60.0, 300)
    for side in (1, -1):
        middle_m = side * 1.75 + 0.2 + bend_per_m * distances_m**2 / 2
        edges = [
            np.column_stack((TRUE.column_at(middle_m + half, distances_m), TRUE.row_at(distances_m)))
            for half in (0.07, -0.07)
        ]
        paint = np.round(16 * np.vstack((edges[0], edges[1][::-1]))).astype(np.int32)
        cv2.fillPoly(image, [paint], (230, 230, 230), cv2.LINE_AA, shift=4)
    return image


@pytest.mark.parametrize("off_rad", [0.0, 0.01, -0.01])
@pytest.mark.parametrize("height_m", [1.2, 1.45])
def test_they_meet_at_the_true_horizon_whatever_was_believed(off_rad: float, height_m: float):
    believed = GroundPlaneCamera(0.03 + off_rad, 950.0, 359.5, height_m, 639.5)
    left, right = propose_lane_lines(road(), believed)
    meeting = vanishing_row(left, right, 1.0)
    assert abs(meeting.value - TRUE.horizon_row_px) < 2.0
    assert meeting_point(left, right)[1] == pytest.approx(meeting.value)
    for line, side in ((left, 1), (right, -1)):
        for column_px, row_px in line:
            lateral_m = TRUE.lateral_at(column_px, row_px)
            assert lateral_m == pytest.approx(side * 1.75 + 0.2, abs=0.08)


@pytest.mark.slow
@pytest.mark.parametrize("yaw_deg", [-12.0, 9.0])
def test_the_road_of_a_camera_that_looks_far_aside_is_found_too(yaw_deg: float):
    """The picture moved sideways, as it moves where the camera is turned by so much."""
    aside_px = round(TRUE.focal_y_px * np.tan(np.radians(yaw_deg)))
    shown = np.roll(road(), aside_px, axis=1)
    shown[:, : max(aside_px, 0)] = shown[:, SIZE.width + min(aside_px, 0) :] = 90
    usual = GroundPlaneCamera(0.05, 950.0, 359.5, 1.3, 639.5)
    found = lanes_aside([shown] * YAWED_PICTURES, usual)
    assert found is not None
    column, row = found
    assert column.value == pytest.approx(639.5 + aside_px, abs=5.0)
    assert row.value == pytest.approx(TRUE.horizon_row_px, abs=4.0)
    plain = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    assert lanes_aside([shown] * 5 + [plain] * 7, usual) is None
    assert lanes_aside([], usual) is None


def test_a_bend_and_an_empty_road_are_refused_with_what_to_do():
    with pytest.raises(UserError, match="straight"):
        propose_lane_lines(road(bend_per_m=1 / 350), TRUE)
    plain = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    with pytest.raises(UserError, match="no lane lines found in this picture"):
        propose_lane_lines(plain, TRUE)


@pytest.mark.parametrize("number", [0, 300, 600])
def test_the_shipped_drive(number: int):
    image = Pictures(open_source(DEMO)).read(number).image
    left, right = propose_lane_lines(image, assumed_camera(SIZE))
    meeting = vanishing_row(left, right, 1.0)
    assert abs(meeting.value - DEMO_HORIZON_ROW_PX) < 4.0
