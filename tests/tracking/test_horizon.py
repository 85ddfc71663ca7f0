"""The watch for a moved mount, and the lens's prior."""

import math

import numpy as np
import pytest

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.sources.frame import ImageSize
from fcw.tracking.horizon import MountWatch, with_principal_row

SIZE = ImageSize(1280, 720)
FRAME_S = 0.1


WELL_CLICKED_RAD = math.radians(0.05)


def watched(pitches_rad, sigma_rad=WELL_CLICKED_RAD):
    """Whether a moved mount is said at each frame."""
    watch = MountWatch(sigma_rad)
    said = []
    for pitch_rad in pitches_rad:
        watch.update(pitch_rad, FRAME_S)
        said.append(watch.moved)
    return watch, said


def drive(rng, seconds):
    """Pitch of an ordinary drive: slopes of 0.15 degrees for 20 s, a body that swings by 0.25 for 0.5 s."""
    total = np.zeros(round(seconds / FRAME_S))
    for sigma_deg, time_s in ((0.15, 20.0), (0.25, 0.5)):
        lasting, value = math.exp(-FRAME_S / time_s), 0.0
        fresh = math.radians(sigma_deg) * math.sqrt(1 - lasting**2) * rng.standard_normal(len(total))
        for k, step in enumerate(fresh):
            value = lasting * value + step
            total[k] += value
    return total


def test_an_ordinary_drive_of_ten_hours_says_nothing():
    _, said = watched(drive(np.random.default_rng(1), 36_000))
    assert not any(said)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("seed", range(5))
def test_half_a_degree_in_mid_drive_is_said_within_five_minutes_and_which_way(direction, seed):
    pitches = drive(np.random.default_rng(seed), 900)
    pitches[6000:] += direction * math.radians(0.5)
    watch, said = watched(pitches)
    assert not any(said[:6000])
    assert said.index(True) <= 6000 + 3000
    assert watch.note is not None
    assert ("farther down" if direction > 0 else "farther up") in watch.note


def test_what_is_said_is_not_taken_back_by_a_flicker_but_by_a_mended_mount():
    _, said = watched([math.radians(0.5)] * 3000 + [math.radians(0.3)] * 600 + [0.0] * 3000)
    changes = [k for k in range(1, len(said)) if said[k] != said[k - 1]]
    assert len(changes) == 2
    assert changes[1] > 3600


def test_a_deviation_that_the_clicks_explain_is_not_said():
    _, said = watched([math.radians(0.5)] * 6000, sigma_rad=math.radians(0.2))
    assert not any(said)


CLICKED = GroundPlaneCamera(0.02, 740.0, 359.5, 1.4, 639.5)


def test_the_middle_of_the_picture_mends_clicks_that_let_the_horizon_slip():
    rng = np.random.default_rng(4)
    free_errors, mended_errors = [], []
    for _ in range(40):
        points = [GroundPoint(d, CLICKED.row_at(d) + rng.standard_normal()) for d in (8.0, 15.0, 30.0)]
        free = calibrate(points, SIZE, 1.4)
        mended = with_principal_row(free, 0.05)
        free_errors.append(abs(free.horizon_row_px - CLICKED.horizon_row_px))
        mended_errors.append(abs(mended.horizon_row_px - CLICKED.horizon_row_px))
    assert np.median(mended_errors) < np.median(free_errors) / 2


def test_points_that_contradict_the_middle_stand_alone():
    # A picture cut out of a larger one: its axis is below it, and clicks of a tenth of a pixel show that.
    cut = GroundPlaneCamera(0.4, 740.0, 800.0, 1.4, 639.5)
    points = [GroundPoint(d, cut.row_at(d)) for d in (4.0, 8.0, 20.0)]
    clicked = calibrate(points, SIZE, 1.4, row_sigma_px=0.1)
    assert with_principal_row(clicked, 0.05) is clicked


def test_a_calibration_without_points_stays_as_it_is():
    exact = Calibration.from_camera(CLICKED, SIZE)
    assert with_principal_row(exact, 0.05) is exact
