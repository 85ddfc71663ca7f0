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
from fcw.motion.ego import Ego
from fcw.motion.path import own_path
from fcw.motion.state import OwnMotion, OwnPath
from fcw.tracking.lead import Corridor
from fcw.tracking.tracker import Tracker

CAMERA = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.4, 639.5)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720))
STEP_S = 1 / 30


def seen_at(distance_m, lateral_m):
    return Detection(CAMERA.ground_box(distance_m, lateral_m, 1.7, 1.5), 1.0)


def turning(own_mps, yaw_rate_radps):
    """What is believed of ourselves by speed and yaw rate."""
    motion = OwnMotion(speed_mps=own_mps, yaw_rate_radps=yaw_rate_radps)
    return Ego(motion, own_path(motion, None))


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
    # What is straight ahead of us is to the right of a camera that looks to the left.
    lateral_m = -distance_m * math.tan(math.radians(yaw_deg))
    found = [seen_at(distance_m, lateral_m)]
    path = OwnPath(heading_rad=-math.radians(yaw_deg))
    with_path, without = (Tracker(CALIBRATION) for _ in range(2))
    for frame in range(10):
        with_path.update(frame * 100_000_000, found, Ego(OwnMotion(), path))
        without.update(frame * 100_000_000, found)
    assert with_path.lead_id is not None
    assert (without.lead_id is not None) == (abs(lateral_m) < 1.2)


def test_on_a_bend_the_lead_is_on_the_bend():
    bend_m = 40.0**2 / 2 / 200.0
    found = [seen_at(40.0, bend_m), seen_at(30.0, -1.5)]
    tracker = Tracker(CALIBRATION)
    ego, tracks = Ego(OwnMotion(), OwnPath(curvature_per_m=1 / 200.0, offset_m=0.1)), ()
    for frame in range(10):
        tracks = tracker.update(frame * 100_000_000, found, ego)
    lead = next(track for track in tracks if track.track_id == tracker.lead_id)
    assert lead.lateral_m > 3.0


def test_a_bend_takes_the_path_with_it():
    # At 20 m/s and 0.2 rad/s the path is 4.5 m to the left 30 m ahead.
    for yaw_rate_radps, expected in ((0.2, [True, False]), (None, [False, True])):
        tracker = Tracker(CALIBRATION)
        tracks = ()
        for k in range(20):
            boxes = [seen_at(30.0, 4.5), seen_at(30.0, 0.0)]
            tracks = tracker.update(round(k * STEP_S * 1e9), boxes, turning(20.0, yaw_rate_radps))
        assert [track.in_path for track in tracks] == expected


def test_what_is_parked_beside_a_bend_keeps_its_place_beside_the_path():
    # It sweeps across the picture as we turn by 0.2 rad/s at 10 m/s, and passes 3.5 m beside us.
    tracker = Tracker(CALIBRATION)
    swept = []
    for k in range(75):
        turned_rad = 0.2 * k * STEP_S
        # We drive on a circle of 50 m to the left; it stands 3.5 m to the right of it, 0.7 rad ahead.
        radius_m, ahead_rad = 50.0 + 3.5, 0.7 - turned_rad
        forward_m, left_m = radius_m * math.sin(ahead_rad), 50.0 - radius_m * math.cos(ahead_rad)
        swept.append(left_m)
        tracks = tracker.update(round(k * STEP_S * 1e9), [seen_at(forward_m, left_m)], turning(10.0, 0.2))
        assert not any(track.in_path for track in tracks)
    assert max(swept) > 2
    assert min(swept) < 0
