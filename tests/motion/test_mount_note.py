"""What is said of a mount that looks elsewhere than calibrated."""

import math

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.frame import ImageSize
from fcw.motion.mount import MountNote, calibration_of_mount
from fcw.motion.state import Mount

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)


def note_of(*off_deg, sigma_deg=0.05):
    note = MountNote(Calibration.from_camera(CAMERA, SIZE))
    for off in off_deg:
        note.update(Mount(pitch_rad=0.03 + math.radians(off), pitch_sigma_rad=math.radians(sigma_deg)), 11.0)
    return note.text


def test_what_is_small_or_unsure_is_not_said():
    assert note_of(0.3) is None
    assert note_of(0.6, sigma_deg=0.3) is None


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
    note = MountNote(Calibration.from_camera(CAMERA, SIZE))
    wrong = Mount(pitch_rad=0.03 + math.radians(1.0), pitch_sigma_rad=math.radians(0.1))
    for second in range(9):
        note.update(wrong, 1.0)
        assert note.text is None, second
    note.update(wrong, 1.0)
    assert note.text is not None


def test_what_is_believed_can_be_made_the_calibration():
    calibration = calibrate([GroundPoint(d, CAMERA.row_at(d)) for d in (6.0, 15.0, 30.0)], SIZE, 1.3)
    mount = Mount(pitch_rad=0.05, pitch_sigma_rad=0.0)
    again = calibration_of_mount(calibration, mount)
    assert again.camera.pitch_rad == 0.05
    assert again.camera.focal_y_px == calibration.camera.focal_y_px
    # No drive tells it better than 0.1 degrees, which are 1.75 px of rows, and at 30 m 4 %.
    low_m, high_m = again.distance_interval(float(again.row_at(30.0)))
    assert 28.4 < low_m < 29.2
    assert 30.8 < high_m < 31.9


def test_it_is_withdrawn_later_than_it_is_said():
    assert note_of(0.5, 0.25) is not None
    assert note_of(0.25) is None
    assert note_of(0.5, 0.15) is None
