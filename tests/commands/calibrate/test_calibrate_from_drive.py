"""`fcw calibrate --from-drive`: what a person reads of it, and the file that it writes."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from export_drives import drive_header, marked_drive

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.file import read_calibration
from fcw.camera.lens.model import Lens
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation
from fcw.logs.mcap.writer import McapSink
from fcw.motion.state import Mount, OwnMotion
from fcw_viz.cli import main

LENS = Lens("radtan", 500.0, 500.0, 319.5, 179.5, (-0.2, 0.05, 0.0, 0.0, 0.0), drive_header().image_size)


def drive_of(folder: Path, calibration: Calibration, pitch_rad: float, sigma_deg: float) -> Path:
    """A log of straight pictures whose camera was believed at last to have a pitch, and no other yaw."""
    sigma_rad = math.radians(sigma_deg)
    mount = Mount(
        pitch_rad=pitch_rad, pitch_sigma_rad=sigma_rad, yaw_sigma_rad=sigma_rad, roll_sigma_rad=sigma_rad
    )
    header = drive_header()
    sink = McapSink(folder / "drive.mcap")
    sink.open(replace(header, calibration=calibration))
    for result, packets in marked_drive(3, header.image_size):
        sink.write(replace(result, own_motion=OwnMotion(mount=mount)), packets)
    sink.close()
    return folder


def clicked() -> Calibration:
    camera = drive_header().calibration.camera
    points = [GroundPoint(d, camera.row_at(d)) for d in (6.0, 15.0, 30.0)]
    return calibrate(points, drive_header().image_size, camera.height_m)


def test_the_file_keeps_lens_and_yaw_and_before_and_after_are_told(tmp_path, capsys):
    taken = replace(
        clicked(), points=(), residuals_px=(), lens=LENS, orientation=Orientation(math.radians(2.03), 0.0)
    )
    drive = drive_of(tmp_path, taken.straight(), taken.camera.pitch_rad, 0.1)
    save = tmp_path / "new.calibration.yaml"
    assert main(["calibrate", "--from-drive", str(drive), "--save", str(save)]) == 0
    captured = capsys.readouterr()
    # To a decimal more than distances are told with: else both would be 29 m to 31 m.
    assert "the road at 30 m is known to two times in three: 28.9 m to 31.2 m by the drive's" in captured.out
    assert "calibration, 29.1 m to 30.9 m now" in captured.out
    assert captured.err == ""
    again = read_calibration(save)
    assert again.lens == LENS
    assert again.undone is None
    assert again.orientation.yaw_rad == pytest.approx(math.radians(2.03), abs=1e-6)
    assert again.orientation.yaw_sigma_rad > 0
    assert again.camera.principal_column_px == pytest.approx(taken.camera.principal_column_px)


def test_a_camera_that_was_moved_is_said_and_that_distances_are_less_sure(tmp_path, capsys):
    calibration = clicked()
    drive = drive_of(tmp_path, calibration.straight(), calibration.camera.pitch_rad + 0.04, 0.3)
    assert main(["calibrate", "--from-drive", str(drive), "--save", str(tmp_path / "new.yaml")]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "the camera points elsewhere than its calibration says" in told
    assert "this drive does not make distances better known: 30 m is" in told


def test_a_drive_that_tells_nothing_saves_nothing(tmp_path, capsys):
    calibration = clicked()
    save = tmp_path / "new.yaml"
    for of_log, sigma_deg, message in (
        (calibration.straight(), 0.7, "the drive tells too little about the camera's pitch"),
        (
            calibration,
            0.1,
            "this log, of an older version, does not say whether its pictures were straightened",
        ),
    ):
        drive = drive_of(tmp_path, of_log, 0.02, sigma_deg)
        assert main(["calibrate", "--from-drive", str(drive), "--save", str(save)]) == 2
        captured = capsys.readouterr()
        assert captured.err.startswith(f"fcw: {drive}: {message}")
        assert captured.out == ""
        assert not save.exists()
