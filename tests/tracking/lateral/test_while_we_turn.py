"""What we pass keeps its place beside our way while we change lanes, as far as our turning is known."""

import cmath
import math

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import Ego
from fcw.motion.state import OwnMotion, OwnPath
from fcw.tracking.tracker import Tracker

CAMERA = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.4, 639.5)
STEP_S, OWN_MPS, ITS_MPS = 1 / 30, 25.0, 17.0
CHANGE_S, LANE_M = 3.0, 3.5
"""A change of lane: a whole wave of a sine of lateral acceleration, 2.4 m/s^2 at most."""


def our_lateral_m(time_s: float) -> float:
    """Our place across the road, positive to the left."""
    part = min(max(time_s / CHANGE_S, 0.0), 1.0)
    return LANE_M * (part - math.sin(2 * math.pi * part) / (2 * math.pi))


def our_heading_rad(time_s: float) -> float:
    """Against the road."""
    part = min(max(time_s / CHANGE_S, 0.0), 1.0)
    return LANE_M / CHANGE_S * (1 - math.cos(2 * math.pi * part)) / OWN_MPS


def comes_after_us_mps(turning_is_known: bool) -> float:
    """How fast the lorry in our old lane seems to move towards our way once we go straight in the new one."""
    tracker = Tracker(Calibration.from_camera(CAMERA, ImageSize(1280, 720)))
    rates_mps = []
    for step in range(120):
        time_s = step * STEP_S - 0.5
        ahead_m, aside_m = 50.0 - (OWN_MPS - ITS_MPS) * step * STEP_S, -our_lateral_m(time_s)
        seen_m = (ahead_m + 1j * aside_m) * cmath.exp(-1j * our_heading_rad(time_s))
        turned_rad = our_heading_rad(time_s + STEP_S / 2) - our_heading_rad(time_s - STEP_S / 2)
        yaw_rate_radps = turned_rad / STEP_S
        motion = OwnMotion(speed_mps=OWN_MPS, yaw_rate_radps=yaw_rate_radps if turning_is_known else None)
        tracks = tracker.update(
            round((time_s + 0.5) * 1e9),
            [Detection(CAMERA.ground_box(seen_m.real, seen_m.imag, 2.5, 3.5), 1.0)],
            Ego(motion, OwnPath(curvature_per_m=yaw_rate_radps / OWN_MPS)),
        )
        if time_s > CHANGE_S:
            rates_mps += [track.lateral_speed_mps for track in tracks]
    return max(rates_mps)


def test_a_lorry_behind_which_we_pulled_out_does_not_seem_to_come_after_us():
    assert comes_after_us_mps(turning_is_known=True) < 0.4
    # It is our turning that makes the difference: without it the end of the sweep passes for its own motion.
    assert comes_after_us_mps(turning_is_known=False) > 1.2
