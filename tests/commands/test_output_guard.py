"""No command writes onto what it reads: exit 2, and every input byte for byte as it was."""

import hashlib
import os
import shutil
from pathlib import Path

import pytest

from fcw_viz.cli import main
from fcw_viz.console_text import one_line, printable

DEMO = Path(__file__).parents[2] / "recordings" / "demo"


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """One of each kind of input."""
    shutil.copy(DEMO / "drive.mp4", tmp_path)
    shutil.copy(DEMO / "drive.calibration.yaml", tmp_path)
    (tmp_path / "pictures").mkdir()
    for name in ("labels.json", "samples.txt", "model.onnx", "model.npz", "drive.mcap", "pictures/1.jpg"):
        (tmp_path / name).write_text(f"the {name}")
    (tmp_path / "label_02").mkdir()
    (tmp_path / "label_02" / "0000.txt").write_text("labels")
    os.link(tmp_path / "labels.json", tmp_path / "hard-link.json")
    (tmp_path / "link.mp4").symlink_to(tmp_path / "drive.mp4")
    return tmp_path


def digests(folder: Path) -> dict[Path, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


POINTS = ["--points", "6:640", "15:520", "30:480", "--height", "1.25"]
EVALUATE = ["evaluate", "detection", "labels.json", "--images", "pictures"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["calibrate", "drive.mp4", *POINTS, "--save", "drive.mp4"],
        ["calibrate", "drive.mp4", *POINTS, "--save", "link.mp4"],
        ["calibrate", "drive.mp4", *POINTS, "--export", "camera_info", "drive.mp4"],
        ["calibrate", "pictures", *POINTS, "--save", "pictures/1.jpg"],
        ["calibrate", "--from-drive", "drive.mcap", "--save", "drive.mcap"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "labels.json"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "hard-link.json"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "drive.calibration.yaml"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "pictures/1.jpg"],
        [
            *EVALUATE,
            "--calibration",
            "drive.calibration.yaml",
            "--model",
            "model.npz",
            "--detections",
            "model.npz",
        ],
        ["evaluate", "distance", "--kitti-tracking", ".", "--samples", "label_02/0000.txt"],
        ["export", "drive.mcap", "--format", "csv", "--out", "drive.mcap", "--overwrite"],
        ["recover", "drive.mcap", "--out", "drive.mcap"],
        ["recover", ".", "--out", "drive.mcap"],
        ["train", "--data", ".", "--out", "labels.json"],
        ["run", "drive.mcap", "--out", "."],
        ["simulate", "drive.calibration.yaml", "--out", "drive.calibration.yaml"],
    ],
    ids=" ".join,
)
def test_no_output_replaces_an_input(
    arguments: list[str], files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(files)
    before = digests(files)
    assert main(arguments) == 2
    assert digests(files) == before
    assert "Traceback" not in capsys.readouterr().err


def test_a_benchmark_does_not_replace_the_figures_that_it_is_compared_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    earlier = tmp_path / "bench.json"
    earlier.write_text('{"ratios": {}}')
    assert main(["bench", "--against", str(earlier), "--report", str(tmp_path)]) == 2
    assert f"would replace --against {earlier}" in capsys.readouterr().err
    assert earlier.read_text() == '{"ratios": {}}'


def test_an_earlier_result_may_be_replaced(files: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(files)
    save = ["--save", "drive.calibration.yaml"]
    for file_format in ("kalibr", "camera_info"):
        assert main(["calibrate", "drive.mp4", *POINTS, *save, "--export", file_format, "lens.yaml"]) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["calibrate", "link.mp4", *POINTS, "--save", "c.yaml", "--export", "camera_info", "./c.yaml"],
        ["calibrate", "link.mp4", *POINTS, "--export", "kalibr", "link.calibration.yaml"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "r", "--report", "r"],
    ],
    ids=" ".join,
)
def test_no_output_replaces_another_one(
    arguments: list[str], files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(files)
    before = digests(files)
    assert main(arguments) == 2
    assert digests(files) == before
    assert "is written there too" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["calibrate", "drive.mp4", *POINTS, "--save", "other.mp4"],
        ["calibrate", "drive.mp4", *POINTS, "--save", "notes.txt"],
        ["calibrate", "drive.mp4", *POINTS, "--save", "lens.yaml"],
        ["calibrate", "drive.mp4", *POINTS, "--export", "kalibr", "notes.txt"],
        ["calibrate", "pictures", "--chessboard", "9x6", "--save", "drive.calibration.yaml"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--detections", "notes.txt"],
        [*EVALUATE, "--calibration", "drive.calibration.yaml", "--report", "site"],
        ["evaluate", "distance", "--kitti-tracking", "label_02", "--samples", "notes.txt"],
        ["evaluate", "distance", "--kitti-tracking", ".", "--report", "charts"],
        ["bench", "--report", "bench"],
        ["calibrate", "other.mp4", *POINTS],
        ["calibrate", "other.mp4", "--from-clip"],
    ],
    ids=" ".join,
)
def test_no_output_replaces_a_file_of_another_kind(
    arguments: list[str], files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(files)
    shutil.copy(DEMO / "drive.mp4", "other.mp4")
    (files / "notes.txt").write_text("mine")
    (files / "lens.yaml").write_text("image_width: 1280\ncamera_matrix: {rows: 3}\n")
    (files / "other.calibration.yaml").write_text("my own notes: 1\n")
    for name in ("site", "charts", "bench"):
        (files / name).mkdir()
    (files / "charts" / "coverage.svg").write_text("<svg><title>my own</title></svg>")
    (files / "bench" / "bench.txt").write_text("3 km in 12 minutes")
    (files / "site" / "report.html").write_text("<!DOCTYPE html>\n<html><head>")
    before = digests(files)
    assert main(arguments) == 2
    assert digests(files) == before
    assert "is there already, and is no " in capsys.readouterr().err


def test_control_characters_of_a_foreign_text_do_not_reach_the_terminal():
    assert printable("a\x1b[31mb\ud800\n[bold]ü") == "a\\x1b[31mb\\ud800\n[bold]ü"
    assert one_line("a\x1b[31mb\ud800\n[bold]ü") == "a\\x1b[31mb\\ud800\\n[bold]ü"
