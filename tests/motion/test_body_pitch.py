"""The body on its springs, as own motion tells it, against pictures of a road whose geometry is exact."""

import math

import numpy as np
import pytest
from road_pictures import HEIGHT, WIDTH, Pose, Road, camera

from fcw.camera.calibration import Calibration
from fcw.frame import ImageSize
from fcw.motion.estimator import MotionEstimator

MOUNT_DEG, STEP_NS = 2.0, 100_000_000


def estimator():
    return MotionEstimator(Calibration.from_camera(camera(MOUNT_DEG), ImageSize(WIDTH, HEIGHT)))


def told_deg(own, nods_deg, speed_mps=10.0):
    """What is told after each picture of a drive whose body nods like this."""
    road, told = Road(), []
    for frame, nod_deg in enumerate(nods_deg):
        pose = Pose(speed_mps * frame * STEP_NS / 1e9)
        own.update(frame * STEP_NS, road.picture(pose, pitch_deg=MOUNT_DEG + nod_deg))
        pitch_rad = own.body_pitch(frame * STEP_NS)
        told.append(math.nan if pitch_rad is None else math.degrees(pitch_rad.value))
    return np.array(told)


def told_after(own, steps):
    pitch_rad = own.body_pitch(steps * STEP_NS)
    assert pitch_rad is not None
    return pitch_rad


@pytest.mark.parametrize("nod_deg", [-1.2, 1.2])
def test_a_nod_is_told_while_it_lasts(nod_deg):
    nods_deg = np.array([0.0] * 12 + [nod_deg / 2] + [nod_deg] * 3 + [nod_deg / 2] + [0.0] * 3)
    assert told_deg(estimator(), nods_deg)[10:] == pytest.approx(nods_deg[10:], abs=0.3)


def test_what_was_told_fades_until_the_next_picture():
    own = estimator()
    told_deg(own, [0.0] * 12 + [1.2])
    now, later, long_after = (told_after(own, steps) for steps in (12, 15, 112))
    assert now.value > later.value > 0
    assert now.sigma < later.sigma < long_after.sigma
    assert long_after.value == pytest.approx(0.0, abs=1e-6)


def test_a_picture_that_shows_no_road_tells_nothing():
    own, black = estimator(), np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for frame in range(3):
        own.update(frame * STEP_NS, black)
        assert own.body_pitch(frame * STEP_NS) is None
