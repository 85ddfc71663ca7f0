"""Where the camera looks elsewhere than it was calibrated, its pose and the rows of distances go with it."""

from dataclasses import replace

import numpy as np
import pytest
from rerun_drives import CALIBRATION, CAMERA, result, rows, write_drive

from fcw.motion.state import Mount, OwnMotion
from fcw_viz.rerun import blueprint as scene
from fcw_viz.rerun.log import FRAMES_PER_BATCH

TURNED_RAD = 0.02


def test_pose_and_rows_are_logged_anew_when_the_camera_is_turned(tmp_path):
    moved = FRAMES_PER_BATCH + 7
    drive = []
    for index in range(moved + 5):
        mount = Mount(pitch_rad=CAMERA.pitch_rad + TURNED_RAD * (index >= moved))
        drive.append(replace(result(index), own_motion=OwnMotion(mount=mount)))
    path = write_drive(tmp_path / "drive.rrd", drive)
    poses = list(rows(path, scene.CAMERA))
    lines = [row for row in rows(path, scene.IMAGE_ROWS) if row.get("LineStrips2D:strips")]
    for found in (poses, lines):
        assert [row[scene.FRAME_TIMELINE] for row in found] == [0, moved]
    for pose, line, turned_rad in zip(poses, lines, (0.0, TURNED_RAD), strict=True):
        looking = replace(CAMERA, pitch_rad=CAMERA.pitch_rad + turned_rad)
        rotation = np.reshape(pose["Transform3D:mat3x3"][0], (3, 3), order="F")  # pyright: ignore[reportIndexIssue]
        down_rad = np.arcsin(-rotation[2, 2])
        assert down_rad == pytest.approx(looking.pitch_rad, abs=1e-6)
        nearest_row_px = line["LineStrips2D:strips"][0][0][1]  # pyright: ignore[reportIndexIssue]
        expected_px = looking.row_at(5.0 + CALIBRATION.reference_offset_m) + 0.5
        assert nearest_row_px == pytest.approx(expected_px, abs=1e-2)
