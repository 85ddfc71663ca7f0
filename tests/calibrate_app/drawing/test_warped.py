"""Seen from above, the lane lines of a straight road are straight, parallel and as wide as they are."""

from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from drawing_states import good_document, shown, state_of

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.drawing.birds_eye import GroundScale
from fcw_viz.calibrate_app.drawing.warped import OUTSIDE, warp_to_ground, warped_scale, warped_svg

SVG = "{http://www.w3.org/2000/svg}"
SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
LANE_HALF_M = 1.75
SCALE = GroundScale(220.0, 360.0, 30.0, 1.0)
DETAIL = 2.0


def road(camera: GroundPlaneCamera) -> np.ndarray:
    image = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    for side in (-1, 1):
        distances_m = np.linspace(4.0, 60.0, 400)
        columns = camera.column_at(np.full(400, side * LANE_HALF_M), distances_m)
        places = np.column_stack((columns, camera.row_at(distances_m)))
        cv2.polylines(
            image, [np.round(16 * places).astype(np.int32)], False, (255, 255, 255), 2, cv2.LINE_AA, shift=4
        )
    return image


def lines_m(image: np.ndarray, calibration: Calibration, distance_m: float) -> tuple[float, float]:
    """Lateral positions of the left and the right line in the warped picture."""
    warped = warp_to_ground(image, calibration, SCALE, DETAIL)
    row = round(SCALE.place(distance_m, 0.0)[1] * DETAIL)
    bright = warped[row, :, 0].astype(float) - 90
    bright[(bright < 20) | (warped[row, :, 0] == OUTSIDE[0])] = 0
    half = len(bright) // 2
    columns = (np.arange(len(bright)) + 0.5) / DETAIL
    left, right = (
        float(np.average(columns[part], weights=bright[part])) for part in (slice(half), slice(half, None))
    )
    middle = SCALE.width_px / 2
    return (middle - left) / SCALE.px_per_m, (middle - right) / SCALE.px_per_m


@pytest.mark.parametrize("distance_m", [6.0, 10.0, 15.0, 20.0, 28.0])
@pytest.mark.parametrize("offset_m", [0.0, 1.6])
def test_lane_lines_come_out_straight_parallel_and_of_true_width(distance_m: float, offset_m: float):
    calibration = Calibration.from_camera(CAMERA, SIZE, offset_m)
    left_m, right_m = lines_m(road(CAMERA), calibration, distance_m)
    assert (left_m, right_m) == pytest.approx((LANE_HALF_M, -LANE_HALF_M), abs=0.05)


def test_a_wrong_height_shows_as_a_wrong_width_and_a_wrong_horizon_as_lines_that_open_or_close():
    too_high = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3 * 1.2, 639.5)
    left_m, right_m = lines_m(road(CAMERA), Calibration.from_camera(too_high, SIZE), 15.0)
    assert left_m - right_m == pytest.approx(1.2 * 2 * LANE_HALF_M, rel=0.04)
    tilted = GroundPlaneCamera(0.06, 1000.0, 359.5, 1.3, 639.5)
    widths_m = [
        left - right
        for left, right in (
            lines_m(road(CAMERA), Calibration.from_camera(tilted, SIZE), d) for d in (7.0, 25.0)
        )
    ]
    assert widths_m[1] < 0.9 * widths_m[0]


def test_what_the_picture_does_not_see_is_grey():
    warped = warp_to_ground(road(CAMERA), Calibration.from_camera(CAMERA, SIZE), SCALE, DETAIL)
    assert warped.shape == (720, 440, 3)
    assert tuple(warped[-1, 220]) == OUTSIDE


@pytest.mark.parametrize("imperial", [False, True])
def test_words_on_the_picture_are_white_and_stand_on_a_dark_ground(imperial: bool):
    result = shown(state_of(good_document()))
    svg = ElementTree.fromstring(warped_svg(road(CAMERA), result, warped_scale(result), imperial))
    grounds = [
        [float(rect.get(name, "nan")) for name in ("x", "y", "width", "height")]
        for rect in svg.iter(f"{SVG}rect")
        if rect.get("fill") == "black"
    ]
    white = [text for group in svg.iter(f"{SVG}g") if group.get("style") == "color: white" for text in group]
    assert {text.text for text in white} >= ({"12 ft", "98.4 ft"} if imperial else {"3.5 m", "10 m"})
    assert len(white) == len(list(svg.iter(f"{SVG}text")))
    for text in white:
        x, y = float(text.get("x", "nan")), float(text.get("y", "nan"))
        assert any(left < x < left + w and top < y - 4 < top + h for left, top, w, h in grounds)
