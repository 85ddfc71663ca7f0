"""The own path: who crosses it comes in once and leaves once."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.state import OwnPath
from fcw.tracking.lead import Corridor
from fcw.tracking.tracker import Tracker

STEP_S = 1 / 30


@given(st.floats(0.2, 4.0), st.sampled_from([-1.0, 1.0]))
def test_a_crossing_vehicle_is_in_the_path_once_without_a_flicker(speed_mps, side):
    corridor, inside, seen = Corridor(), False, []
    steps = round(12.0 / speed_mps / STEP_S)
    for step in range(steps):
        lateral_m = side * (-6.0 + step * STEP_S * speed_mps)
        inside = corridor.holds(lateral_m, side * speed_mps, inside)
        seen.append((abs(lateral_m), inside))
    changes = sum(now != before for (_, before), (_, now) in pairwise(seen))
    assert changes == 2
    assert all(is_inside for distance_m, is_inside in seen if distance_m <= corridor.enter_m)
    assert not any(is_inside for distance_m, is_inside in seen if distance_m > 2.4)


@pytest.mark.parametrize("yaw_deg", [-3.0, 3.0])
@pytest.mark.parametrize("distance_m", [20.0, 40.0, 60.0])
def test_a_camera_that_looks_aside_has_its_lead_where_we_go(yaw_deg, distance_m):
    camera = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.4, 639.5)
    # What is straight ahead of us is to the right of a camera that looks to the left.
    lateral_m = -distance_m * math.tan(math.radians(yaw_deg))
    found = [Detection(camera.ground_box(distance_m, lateral_m, 1.7, 1.5), 1.0)]
    path = OwnPath(heading_rad=-math.radians(yaw_deg))
    with_path, without = (Tracker(Calibration.from_camera(camera, ImageSize(1280, 720))) for _ in range(2))
    for frame in range(10):
        with_path.update(frame * 100_000_000, found, path=path)
        without.update(frame * 100_000_000, found)
    assert with_path.lead_id is not None
    assert (without.lead_id is not None) == (abs(lateral_m) < 1.2)


def test_on_a_bend_the_lead_is_on_the_bend():
    camera = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.4, 639.5)
    bend_m = 40.0**2 / 2 / 200.0
    found = [
        Detection(camera.ground_box(40.0, bend_m, 1.7, 1.5), 1.0),
        Detection(camera.ground_box(30.0, 0.0 - 1.5, 1.7, 1.5), 1.0),
    ]
    tracker = Tracker(Calibration.from_camera(camera, ImageSize(1280, 720)))
    tracks = ()
    for frame in range(10):
        tracks = tracker.update(
            frame * 100_000_000, found, path=OwnPath(curvature_per_m=1 / 200.0, offset_m=0.1)
        )
    lead = next(track for track in tracks if track.track_id == tracker.lead_id)
    assert lead.lateral_m > 3.0
