"""What is said of a mount that looks elsewhere than calibrated."""

import math

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.motion.mount import MountNote
from fcw.motion.state import Mount

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)


TAPED_RAD = math.radians(0.1)
"""Horizon of a calibration by taped points."""


def note_of(*off_deg, sigma_deg=0.05, calibration_sigma_deg=0.1):
    note = MountNote(Calibration.from_camera(CAMERA, SIZE), math.radians(calibration_sigma_deg))
    for off in off_deg:
        note.update(Mount(pitch_rad=0.03 + math.radians(off), pitch_sigma_rad=math.radians(sigma_deg)), 11.0)
    return note.text


def test_what_is_small_or_unsure_is_not_said():
    assert note_of(0.3) is None
    assert note_of(0.6, sigma_deg=0.3) is None


def test_a_rough_calibration_is_not_accused_of_what_it_said_itself():
    assert note_of(0.9, calibration_sigma_deg=0.5) is None
    assert note_of(1.1, calibration_sigma_deg=0.5) is not None


def test_a_wrong_pitch_is_said_with_what_it_does():
    text = note_of(1.0)
    assert text is not None
    assert "1.0 degrees farther down" in text
    # One degree farther down: the road at 30 m shows one degree higher, where the calibration has
    # 1.3 / tan(atan(1.3 / 30) - 1 deg) = 50.3 m.
    assert "30 m would read 50 m" in text
    up = note_of(-1.0)
    assert up is not None
    assert "farther up" in up


def test_it_must_be_so_for_ten_seconds():
    note = MountNote(Calibration.from_camera(CAMERA, SIZE), TAPED_RAD)
    wrong = Mount(pitch_rad=0.03 + math.radians(1.0), pitch_sigma_rad=math.radians(0.1))
    for second in range(9):
        note.update(wrong, 1.0)
        assert note.text is None, second
    note.update(wrong, 1.0)
    assert note.text is not None


def test_it_is_withdrawn_later_than_it_is_said():
    assert note_of(0.5, 0.25) is not None
    assert note_of(0.25) is None
    assert note_of(0.5, 0.15) is None
