"""Where a drive leads to, told to own motion: wrong calibrations, and cameras that are turned."""

import math

import numpy as np
import pytest
from road_pictures import HEIGHT, WIDTH, Pose, Road, camera

from fcw.camera.calibration import Calibration
from fcw.frame import ImageSize
from fcw.motion.estimator import MotionEstimator
from fcw.motion.travel.looks import FIRST_TOLD_S, LOOK_S, PAUSES_S, TravelLooks

RATE_HZ = 12.0
SPEED_MPS = 12.0
TRUE_PITCH_DEG = 2.0


def pictures(duration_s, pitch_deg=lambda _: TRUE_PITCH_DEG, yaw_deg=0.0, speed_mps=SPEED_MPS):
    """Times and pictures of a straight drive; the pitch of the camera by the time in seconds."""
    road = Road()
    for number in range(round(duration_s * RATE_HZ)):
        time_s = number / RATE_HZ
        picture = road.picture(Pose(speed_mps * time_s), pitch_deg(time_s), yaw_deg=yaw_deg)
        yield round(time_s * 1e9), picture


def calibrated(pitch_deg):
    return Calibration.from_camera(camera(pitch_deg), ImageSize(WIDTH, HEIGHT))


def test_a_look_tells_early_and_whole_and_the_next_one_waits():
    looks, told = TravelLooks(calibrated(-5.0)), []
    for time_ns, picture in pictures(LOOK_S + PAUSES_S[0] + FIRST_TOLD_S + 2.0, yaw_deg=3.0):
        found = looks.update(time_ns / 1e9, picture, ())
        if found is not None:
            told.append((time_ns / 1e9, found))
    (early_s, _), (whole_s, whole), (next_s, _) = told
    assert FIRST_TOLD_S <= early_s < whole_s < LOOK_S + 1.0
    assert whole_s + PAUSES_S[0] < next_s
    assert whole.yaw_rad is not None
    for angle_rad, true_deg in ((whole.pitch_rad, TRUE_PITCH_DEG), (whole.yaw_rad, 3.0)):
        assert math.degrees(angle_rad.value) == pytest.approx(true_deg, abs=0.5)
        assert abs(angle_rad.value - math.radians(true_deg)) < 2 * angle_rad.sigma


def test_who_stands_is_told_nothing():
    looks = TravelLooks(calibrated(TRUE_PITCH_DEG))
    noise = np.random.default_rng(0)
    for time_ns, picture in pictures(4.0, speed_mps=0.0):
        grainy = np.clip(picture + noise.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
        assert looks.update(time_ns / 1e9, grainy, ()) is None


@pytest.mark.parametrize("off_deg", [-4.0, 6.0])
def test_a_calibration_that_is_degrees_off_is_mended_within_seconds(off_deg):
    """Steps alone find no speed with a camera that is thought to look 4 degrees too high."""
    own = MotionEstimator(calibrated(TRUE_PITCH_DEG + off_deg))
    for time_ns, picture in pictures(FIRST_TOLD_S + 2.0):
        own.update(time_ns, picture)
    mount = own.state.mount
    assert mount is not None
    assert math.degrees(mount.pitch_rad) == pytest.approx(TRUE_PITCH_DEG, abs=0.5)
    assert own.state.speed_mps == pytest.approx(SPEED_MPS, rel=0.1)


@pytest.mark.slow
def test_a_camera_that_is_turned_in_mid_drive_is_seen_by_the_next_look():
    """Steps alone were sure of the pitch by then, and would follow in a minute."""
    turned_s, turned_deg = LOOK_S + 2.0, 3.0
    own = MotionEstimator(calibrated(TRUE_PITCH_DEG))
    end_s = LOOK_S + PAUSES_S[0] + LOOK_S + 2.0
    for time_ns, picture in pictures(
        end_s, lambda time_s: TRUE_PITCH_DEG + (turned_deg if time_s > turned_s else 0.0)
    ):
        own.update(time_ns, picture)
    mount = own.state.mount
    assert mount is not None
    now_rad = math.radians(TRUE_PITCH_DEG + turned_deg)
    assert math.degrees(mount.pitch_rad - now_rad) == pytest.approx(0.0, abs=0.5)
    assert abs(mount.pitch_rad - now_rad) < 2 * mount.pitch_sigma_rad
