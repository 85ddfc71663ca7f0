"""Own motion against poses: the truth from poses by hand, and the command's messages."""

import math
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.evaluation.motion.motion import evaluate_motion
from fcw.evaluation.motion.poses import read_poses, true_motion
from fcw.frame import ImageSize
from fcw.sources import open_source
from fcw_viz.cli import main

DATA = os.environ.get("FCW_DATA")


def pose(x, z, heading_left_rad, pitch_rad=0.0):
    """A camera (x right, y down, z forward) turned to the left and then looking down."""
    c, s = math.cos(-heading_left_rad), math.sin(-heading_left_rad)
    turned = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    c, s = math.cos(-pitch_rad), math.sin(-pitch_rad)
    lowered = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return np.column_stack((turned @ lowered, [x, 0.0, z]))


def test_poses_say_speed_turn_and_mount():
    poses = np.array([pose(0, 1.2 * k, 0.01 * k if k > 4 else 0.0, 0.02) for k in range(5)])
    truth = true_motion(poses, np.linspace(0.0, 0.4, 5))
    assert truth.speeds_mps == pytest.approx([12.0] * 5)
    assert truth.pitch_rad == pytest.approx(0.02)
    assert truth.yaw_rad == pytest.approx(0.0, abs=1e-12)
    turning = np.array([pose(0, 1.2 * k, 0.01 * k) for k in range(3)])
    assert true_motion(turning, np.linspace(0.0, 0.2, 3)).yaw_rates_radps == pytest.approx([0.1] * 3)


@pytest.mark.parametrize(
    ("text", "said"), [("1 2 3\n", "line 1: expected 12 numbers"), ("", "0 poses"), ("x " * 12, "line 1")]
)
def test_a_wrong_file_of_poses_is_named_with_its_line(tmp_path, text, said):
    path = tmp_path / "poses.txt"
    path.write_text(text)
    with pytest.raises(UserError, match=said):
        read_poses(path)


def test_what_a_short_clip_does_not_tell_is_said_to_be_unknown(tmp_path, capsys):
    pictures, poses, camera = tmp_path / "pictures", tmp_path / "poses.txt", tmp_path / "camera.yaml"
    pictures.mkdir()
    for number in range(4):
        cv2.imwrite(str(pictures / f"{number}.png"), np.full((180, 320, 3), 90, np.uint8))
    np.savetxt(poses, [pose(0, 1.2 * number, 0.0).ravel() for number in range(4)])
    ground = GroundPlaneCamera(0.0, 300.0, 90.0, 1.3, 160.0)
    write_calibration(Calibration.from_camera(ground, ImageSize(320, 180)), camera)
    command = ["evaluate", "motion", str(pictures), "--poses", str(poses), "--calibration", str(camera)]
    assert main([*command, "--frame-rate", "10"]) == 0
    said = capsys.readouterr().out
    assert "median error unknown" in said
    assert "nan" not in said


@pytest.mark.slow
@pytest.mark.skipif(DATA is None, reason="needs the real drives of FCW_DATA")
@pytest.mark.parametrize("pitch_deg", [-0.3, 0.7])
def test_a_real_drive_is_measured_as_asked_for(pitch_deg):
    folder = Path(DATA or "") / "kitti-odometry-03"
    source = open_source(folder / "drive.mp4", None, None)
    camera = GroundPlaneCamera(math.radians(pitch_deg), 721.538, 172.854, 1.65, 609.559)
    calibration = Calibration.from_camera(camera, ImageSize(1242, 374))
    result = evaluate_motion(source, calibration, read_poses(folder / "poses.txt"))
    assert result.known_part >= 0.9
    assert result.speed_median <= 0.03
    assert result.speed_p90 <= 0.10
    assert math.degrees(result.yaw_rate_median_radps) <= 0.15
    # The camera's axis is 0.3 degrees above the direction of travel.
    assert math.degrees(result.pitch_after_30_s_rad) == pytest.approx(-0.3, abs=0.2)
