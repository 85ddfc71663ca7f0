"""Lorries beside our path: much more of their side shows than of a car's, and it is not their rear."""

import math

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import Ego
from fcw.motion.state import STRAIGHT, OwnMotion, OwnPath
from fcw.tracking.range.model import REARS
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track

LORRY = REARS[2]
LENGTH_M = 12.0
"""The longest that is allowed of a bus or of a lorry without a trailer."""
CAMERA = GroundPlaneCamera(0.0, 1000.0, 359.5, 1.3, 639.5)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720), reference_offset_m=0.0)


def box_of_lorry(distance_m: float, lateral_m: float, heading_rad: float) -> Box:
    """Around its rear, whose middle is given, and the side that shows; its tyres stand an overhang ahead."""
    forward, left = math.cos(heading_rad), math.sin(heading_rad)
    columns = [
        CAMERA.column_at(
            lateral_m + along_m * left + across_m * forward, distance_m + along_m * forward - across_m * left
        )
        for along_m in (0.0, LENGTH_M)
        for across_m in (-LORRY.width_m / 2, LORRY.width_m / 2)
    ]
    rear = CAMERA.ground_box(distance_m, lateral_m, LORRY.width_m, LORRY.height_m)
    bottom = CAMERA.row_at(distance_m + LORRY.overhang_m)
    return Box(min(columns), rear.y, max(columns) - min(columns), bottom - rear.y)


def followed(
    distance_m: float, lateral_m: float, heading_rad: float = 0.0, path: OwnPath = STRAIGHT
) -> Track:
    """What is believed of a lorry that keeps its place ahead of us for a second."""
    tracker, tracks = Tracker(CALIBRATION), tuple[Track, ...]()
    box = box_of_lorry(distance_m, lateral_m, heading_rad)
    for frame in range(30):
        tracks = tracker.update(frame * 33_333_333, [Detection(box, 1.0)], Ego(OwnMotion(), path))
    (track,) = tracks
    return track


@pytest.mark.parametrize("distance_m", [12.0, 20.0, 30.0])
@pytest.mark.parametrize("lateral_m", [-3.3, 3.3])
def test_a_lorry_in_the_next_lane_is_as_far_away_as_it_is(distance_m, lateral_m):
    track = followed(distance_m, lateral_m)
    # With the side of a car, 5 to 6 % too near, and 0.35 m nearer to our path.
    assert track.distance_m == pytest.approx(distance_m, rel=0.03)
    assert track.lateral_m == pytest.approx(lateral_m, abs=0.15)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("along_m", [30.0, 45.0])
def test_a_lorry_on_the_outside_of_a_motorway_bend_shows_all_of_its_side(side, along_m):
    radius_m, aside_m = 300.0, 3.5
    angle_rad = along_m / radius_m
    distance_m = (radius_m + aside_m) * math.sin(angle_rad)
    lateral_m = side * (radius_m - (radius_m + aside_m) * math.cos(angle_rad))
    path = OwnPath(curvature_per_m=side / radius_m)
    track = followed(distance_m, lateral_m, side * angle_rad, path)
    # With the side of a car, 8 to 10 % too near, and 0.3 to 0.4 m nearer to our path.
    assert track.distance_m == pytest.approx(distance_m, rel=0.03)
    assert track.lateral_m == pytest.approx(lateral_m, abs=0.15)
