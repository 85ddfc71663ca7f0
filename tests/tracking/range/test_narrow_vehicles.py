"""What is narrow and tall: two-wheelers with their riders, and cars of which a part is hidden."""

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.tracking.tracker import Tracker

CAMERA = GroundPlaneCamera(0.02, 740.0, 359.5, 1.4, 639.5)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720))
CAR_M = 1.75, 1.5
RIDERS_M = {"motorcycle": (0.8, 1.6), "scooter with two": (0.75, 1.75), "bicycle": (0.6, 1.7)}
STEP_NS, FRAMES = 66_666_667, 30


def believed_m(boxes):
    """Distances of the one vehicle after each box, whose sides are off by a pixel."""
    tracker, rng, distances_m = Tracker(CALIBRATION), np.random.default_rng(0), []
    for frame, box in enumerate(boxes):
        left, top, right, bottom = rng.normal(0, 1, 4)
        noisy = Box(box.x + left, box.y + top, box.w + right - left, box.h + bottom - top)
        tracks = tracker.update(frame * STEP_NS, [Detection(noisy, 50.0)])
        distances_m += [track.distance_m for track in tracks]
    return np.array(distances_m)


@pytest.mark.parametrize("size_m", RIDERS_M.values(), ids=RIDERS_M)
@pytest.mark.parametrize("distance_m", [10.0, 20.0, 40.0])
def test_who_rides_on_two_wheels_is_no_lorry_far_away(distance_m, size_m):
    box = CAMERA.ground_box(distance_m, 0.0, *size_m)
    assert believed_m([box] * FRAMES) == pytest.approx(distance_m, rel=0.15)


@pytest.mark.parametrize("distance_m", [10.0, 15.0, 25.0, 40.0])
def test_a_car_that_comes_out_from_behind_something_is_where_it_is_all_the_while(distance_m):
    whole, hidden_part = (
        CAMERA.ground_box(distance_m, 0.0, *CAR_M),
        np.interp(range(FRAMES), (15, 21), (0.55, 0)),
    )
    boxes = [Box(whole.x, whole.y, whole.w * (1 - part), whole.h) for part in hidden_part]
    assert believed_m(boxes) == pytest.approx(distance_m, rel=0.15)
