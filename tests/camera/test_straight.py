"""The straight picture: there and back, and what a level camera would have seen."""

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening, straight_column, turn
from fcw.frame import Frame, ImageSize
from fcw.simulation.world.scenario import load_scenario
from fcw.sources import open_source
from fcw.sources.straight import straightened

DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
LENSES = [
    None,
    Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.001, -0.001), SIZE),
    Lens("equidistant", 900.0, 900.0, 630.0, 350.0, (-0.02, 0.003, 0.0, 0.0), SIZE),
    Lens("radtan", 900.0, 810.0, 639.5, 359.5, (-0.2, 0.05, 0.0, 0.0, -0.01), SIZE),
]
angles = st.floats(-0.1, 0.1)


@given(angles, angles, st.sampled_from(LENSES))
def test_there_and_back_is_the_same_place(yaw_rad, roll_rad, lens):
    way = Straightening(CAMERA, Orientation(yaw_rad, roll_rad), lens, SIZE)
    places = np.array([[200.0, 650.0], [640.0, 400.0], [1100.0, 500.0]])
    assert way.to_straight(way.to_picture(places)) == pytest.approx(places, abs=1e-3)


@given(angles, angles)
def test_turning_is_a_rotation(yaw_rad, roll_rad):
    there = turn(0.1, Orientation(yaw_rad, roll_rad))
    assert there @ there.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(there) == pytest.approx(1)


def test_a_camera_rolled_to_the_right_sees_the_horizon_fall_to_the_left():
    way = Straightening(CAMERA, Orientation(0.0, math.radians(2)), None, SIZE)
    horizon = np.array([[100.0, CAMERA.horizon_row_px], [1180.0, CAMERA.horizon_row_px]])
    (left, right) = way.to_picture(horizon)
    assert math.atan2(left[1] - right[1], right[0] - left[0]) == pytest.approx(math.radians(2), abs=1e-9)


def test_a_camera_that_looks_left_sees_the_way_ahead_to_the_right_of_its_axis():
    real_column_px = 639.5
    column_px = straight_column(CAMERA, Orientation(math.radians(3)))
    assert column_px - real_column_px == pytest.approx(1000 * math.tan(math.radians(3)), rel=0.01)


def test_a_camera_that_is_straight_changes_nothing():
    calibration = Calibration.from_camera(CAMERA, SIZE)
    assert calibration.straightening is None
    assert calibration.straight() == calibration
    source = open_source(DEMO)
    assert straightened(source, calibration)[0] is source


class OneFrame:
    """A source of one picture."""

    name, image_size, frame_count, frame_rate_hz, relays_video, notes = "one", SIZE, 1, 10.0, True, ()

    def __init__(self, image: np.ndarray) -> None:
        self._image = image

    def frames(self, start_ns: int | None = None):
        yield Frame(0, 0, self._image, ())


@pytest.mark.slow
def test_the_simulators_picture_comes_back_from_a_turned_wide_camera():
    """Yaw 3 degrees, roll 2 degrees, k1 -0.25 put on a picture of the shipped drive, and taken off again."""
    frame = next(open_source(DEMO).frames())
    camera = load_scenario("demo").camera.camera()
    lens = Lens(
        "radtan",
        camera.focal_y_px,
        camera.focal_y_px,
        639.5,
        camera.principal_row_px,
        (-0.25, 0.06, 0, 0),
        SIZE,
    )
    orientation = Orientation(math.radians(3), math.radians(2))
    way = Straightening(camera, orientation, lens, SIZE)
    columns, rows = np.meshgrid(np.arange(1280.0), np.arange(720.0))
    places = way.to_straight(np.column_stack((columns.ravel(), rows.ravel()))).astype(np.float32)
    bent = cv2.remap(frame.image, places.reshape(720, 1280, 2), np.empty(0), cv2.INTER_CUBIC)
    calibration = Calibration.from_camera(camera, SIZE)
    source, straight = straightened(OneFrame(bent), replace(calibration, orientation=orientation, lens=lens))
    assert straight == calibration
    assert not source.relays_video
    assert "yaw of +3.0 degrees, roll of +2.0 degrees, the lens's distortion" in source.notes[-1]
    (again,) = source.frames()
    inside = (slice(150, 650), slice(200, 1080))
    difference = np.abs(again.image[inside].astype(int) - frame.image[inside].astype(int))
    wrong = np.abs(bent[inside].astype(int) - frame.image[inside].astype(int))
    assert difference.mean() < 4
    assert difference.mean() < wrong.mean() / 3
