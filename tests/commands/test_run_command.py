"""`fcw run` on real drives: complete logs, exact times, a JSON summary, a clear message for wrong input."""

import hashlib
import json
import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import pytest
from drives.rrd_files import read_frame_times
from mcap.reader import make_reader
from running.programs import start_program
from running.tiny_nets import write_quick_net
from video_making import write_short_drive

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.file import write_calibration
from fcw.camera.solve import calibrate
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.frame import ImageSize
from fcw.logs.mcap.reader import DriveLog
from fcw.sources import open_source
from fcw_viz.cli import main
from fcw_viz.commands.run.options import RunCommand, job_of

CLIPS = (
    "kb_dashcam1",
    "kb_dashcam2",
    "muchlisin_driving",
    "solidWhiteRight",
    "tmo_countryroad",
    "tmo_seattlestreet2",
    "udacity_project_video_cut",
    "udacity_test_small1",
    "udacity_test_small2",
    "udacity_test_video",
)
DEMO = Path(__file__).parents[2] / "recordings" / "demo"
DEMO_FRAMES = 1200
PATIENCE_S = 600  # on a busy machine


def rough_calibration(data_dir: Path, clip: str) -> Calibration:
    """The calibration of a clip as `calibrations.txt` of the data lists it."""
    for line in (data_dir / "calibrations.txt").read_text().splitlines():
        name, *fields = line.split()
        if name == clip:
            width, height = map(int, fields[0].split("x"))
            points = [GroundPoint(*map(float, field.split(":"))) for field in fields[2:5]]
            return calibrate(points, ImageSize(width, height), float(fields[1]))
    raise LookupError(clip)


def short_drive(folder: Path, frames: int = 25) -> Path:
    """The first frames of the shipped drive as pictures, with its calibration beside the folder."""
    import cv2

    pictures = folder / "short"
    pictures.mkdir()
    for frame in open_source(DEMO / "drive.mp4").frames():
        if frame.index == frames:
            break
        cv2.imwrite(str(pictures / f"{frame.index:03d}.jpg"), frame.image)
    (folder / "short.calibration.yaml").write_bytes((DEMO / "drive.calibration.yaml").read_bytes())
    return pictures


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The detector where a run is about its logs."""
    return f"onnx:{write_quick_net(tmp_path_factory.mktemp('net') / 'quick.onnx')}"


def test_by_default_a_drive_has_a_folder_of_its_own_name(tmp_path, monkeypatch):
    (tmp_path / "2026.05.01" / "left").mkdir(parents=True)
    (tmp_path / "2026.05.01.mp4").touch()
    monkeypatch.chdir(tmp_path / "2026.05.01" / "left")
    for source, name in (("..", "2026.05.01"), ("../../2026.05.01.mp4", "2026.05.01"), (".", "left")):
        assert job_of(RunCommand(source), Path(source)).out == Path("recordings") / name


@pytest.mark.parametrize("clip", CLIPS)
def test_both_logs_hold_every_shown_frame_of_a_real_clip_at_its_own_time(
    clip: str, quick: str, data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = data_dir / "clips" / f"{clip}.mp4"
    calibration_path = tmp_path / "camera.yaml"
    write_calibration(rough_calibration(data_dir, clip), calibration_path)

    arguments = ["run", str(path), "--calibration", str(calibration_path), "--out", str(tmp_path), "--json"]
    assert main([*arguments, "--detector", quick]) == 0

    times_ns = [frame.time_ns for frame in open_source(path).frames()]
    log = DriveLog(tmp_path / "drive.mcap")
    results = list(log.results())
    assert log.complete
    assert [result.time_ns for result in results] == times_ns
    assert [result.index for result in results] == list(range(len(times_ns)))
    assert read_frame_times(tmp_path / "drive.rrd") == list(enumerate(times_ns))
    summary = json.loads(capsys.readouterr().out)
    assert summary == json.loads((tmp_path / "summary.json").read_text())
    assert summary["frames"] == len(times_ns)
    assert summary["frames_with_lead"] == sum(result.lead_id is not None for result in results)


def test_a_trained_model_is_run_and_the_log_says_which(tmp_path: Path, capsys) -> None:
    source, mine = short_drive(tmp_path, frames=4), tmp_path / "mine.npz"
    replace(Model.load(SHIPPED_MODEL_PATH), score_threshold=1e9).save(mine)
    arguments = ["run", str(source), "--out", str(tmp_path / "out"), "--model", str(mine)]
    assert main([*arguments, "--detector", "acf"]) == 0
    log = DriveLog(tmp_path / "out" / "drive.mcap")
    assert log.header.model_sha256 == hashlib.sha256(mine.read_bytes()).hexdigest()
    assert [len(result.detections) for result in log.results()] == [0] * 4
    capsys.readouterr()
    assert main(arguments) == 2
    assert f"{mine}: a model of acf, but --detector net is to use it; name --detector acf" in (
        capsys.readouterr().err
    )


@pytest.mark.slow
def test_a_run_needs_no_flag_where_the_calibration_lies_beside_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    source = short_drive(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(source), "--frame-rate", "30"]) == 0
    out = tmp_path / "recordings" / "short"
    assert sorted(path.name for path in out.iterdir()) == ["drive.mcap", "drive.rrd", "summary.json"]
    assert "25 frames" in capsys.readouterr().out
    with (out / "drive.mcap").open("rb") as file:
        statistics = make_reader(file).get_summary()
        assert statistics is not None
        assert statistics.statistics is not None


def test_the_rerun_log_can_be_left_out(quick: str, tmp_path: Path, capsys) -> None:
    source, out = short_drive(tmp_path, frames=4), tmp_path / "out"
    command = ["run", str(source), "--out", str(out), "--detector", quick]
    assert main(command) == 0
    assert (out / "drive.rrd").is_file()
    assert "drive.rrd" in capsys.readouterr().out
    assert main([*command, "--no-rerun-log"]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["drive.mcap", "summary.json"]
    assert "drive.rrd" not in capsys.readouterr().out
    assert DriveLog(out / "drive.mcap").complete


def test_why_a_log_is_much_larger_than_its_video_is_said(quick: str, tmp_path: Path, capsys) -> None:
    small = {"bf": "2", "b_strategy": "0", "crf": "45"}
    video = write_short_drive(tmp_path / "small.mp4", options=small)
    command = ["run", str(video), "--out", str(tmp_path / "out"), "--detector", quick]
    assert main(command) == 0
    said = capsys.readouterr().err
    times = (tmp_path / "out" / "drive.mcap").stat().st_size / video.stat().st_size
    assert f"drive.mcap and drive.rrd are each {times:.1f} times as large as small.mp4" in said
    assert "encoded again, because the video has B frames" in said
    assert "--no-rerun-log leaves one of them out" in said
    assert main([*command, "--no-rerun-log"]) == 0
    said = capsys.readouterr().err
    assert "drive.mcap is " in said
    assert "--no-rerun-log" not in said


def test_of_a_log_with_the_videos_own_packets_nothing_is_said(quick: str, tmp_path: Path, capsys) -> None:
    video = write_short_drive(tmp_path / "plain.mp4", frames=10)
    assert main(["run", str(video), "--out", str(tmp_path / "out"), "--detector", quick]) == 0
    assert "times as large" not in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("detector", ["acf", "acf-full"])
def test_either_detector_can_be_chosen_and_stands_in_the_log(detector: str, tmp_path: Path) -> None:
    source = short_drive(tmp_path, frames=3)
    assert main(["run", str(source), "--out", str(tmp_path / "out"), "--detector", detector]) == 0
    assert DriveLog(tmp_path / "out" / "drive.mcap").header.detector == detector


@pytest.mark.slow
def test_every_picture_is_searched_unless_fewer_are_asked_for(tmp_path: Path) -> None:
    source = short_drive(tmp_path, frames=40)
    command = ["run", str(source), "--out", str(tmp_path / "out"), "--frame-rate", "30"]
    assert main(command) == 0
    assert all(result.searched for result in DriveLog(tmp_path / "out" / "drive.mcap").results())
    assert main([*command, "--search-rate", "12"]) == 0
    searched = [result.searched for result in DriveLog(tmp_path / "out" / "drive.mcap").results()]
    assert all(searched[::2])
    assert all(searched[1:15:2])  # the lead is new
    assert not any(searched[31::2])  # it keeps its distance


@pytest.mark.slow
def test_ego_speed_stands_in_every_frame(tmp_path: Path) -> None:
    source = short_drive(tmp_path, frames=5)
    assert main(["run", str(source), "--out", str(tmp_path / "out"), "--ego-speed", "22.5"]) == 0
    results = DriveLog(tmp_path / "out" / "drive.mcap").results()
    assert [result.ego_speed_mps for result in results] == [22.5] * 5


@pytest.mark.slow
def test_ctrl_c_closes_both_logs_and_exits_with_130(quick: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start_program("run", DEMO / "drive.mp4", "--out", out, "--json", "--detector", quick)
    deadline = time.monotonic() + PATIENCE_S
    while not (out / "drive.mcap").is_file() or (out / "drive.mcap").stat().st_size < 100_000:
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < deadline, "the log does not grow"
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    stdout, stderr = process.communicate(timeout=PATIENCE_S)

    assert process.returncode == 130, stderr
    log = DriveLog(out / "drive.mcap")
    results = list(log.results())
    assert log.complete
    assert 0 < len(results) < DEMO_FRAMES
    assert json.loads(stdout)["frames"] == len(results)
    assert read_frame_times(out / "drive.rrd") == [(result.index, result.time_ns) for result in results]


@pytest.mark.slow
@pytest.mark.parametrize("limit_bytes", [200_000, 1_500_000])
def test_a_log_that_may_not_grow_ends_the_run_with_a_message_and_keeps_the_beginning(
    quick: str, tmp_path: Path, limit_bytes: int
) -> None:
    resource = pytest.importorskip("resource", reason="needs a limit on the size of files, as POSIX has it")
    out = tmp_path / "out"
    arguments = ("run", DEMO / "drive.mp4", "--out", out, "--detector", quick)
    process = start_program(
        *arguments, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    )
    _, told = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2, told
    assert "allow larger files (ulimit -f)" in told
    assert "Traceback" not in told
    assert "re_log_encoding" not in told  # rerun's own lines
    assert not (out / "summary.json").exists()
    assert not (out / "drive.rrd").exists()
    assert not (out / "drive.mcap").exists()  # nobody takes it for a whole drive
    assert f"what was written of this drive is {out / 'failed-drive.mcap'}" in " ".join(told.split())
    results = list(DriveLog(out / "failed-drive.mcap").results())  # the beginning is not lost
    assert [result.index for result in results] == list(range(len(results)))
    assert len(results) < DEMO_FRAMES


def wrong_input(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The message of a command that must refuse its input."""
    assert main(list(arguments)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fcw: ")
    assert "Traceback" not in err
    return err


def test_a_missing_source_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nowhere.mp4" in wrong_input(capsys, "run", str(tmp_path / "nowhere.mp4"))


def test_a_missing_calibration_names_the_file_looked_for_and_both_ways_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = tmp_path / "mine.mp4"
    drive.write_bytes((DEMO / "drive.mp4").read_bytes())
    message = wrong_input(capsys, "run", str(drive), "--out", str(tmp_path / "out"))
    assert "mine.calibration.yaml" in message
    assert "fcw calibrate" in message
    assert "--calibration" in message
    assert not (tmp_path / "out").exists()


def test_a_calibration_for_another_picture_shape_is_refused_with_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = [GroundPoint(5, 400), GroundPoint(10, 330), GroundPoint(20, 300)]
    path = tmp_path / "square.yaml"
    write_calibration(calibrate(points, ImageSize(640, 640), 1.2), path)
    message = wrong_input(capsys, "run", str(DEMO / "drive.mp4"), "--calibration", str(path))
    assert "square.yaml" in message
    assert "640x640" in message
    assert "1280x720" in message


def test_an_unknown_detector_lists_the_known_ones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    message = wrong_input(
        capsys, "run", str(DEMO / "drive.mp4"), "--out", str(tmp_path / "out"), "--detector", "magic"
    )
    assert "magic" in message
    assert "acf, acf-full" in message


def test_a_negative_rate_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = "--out", str(tmp_path / "out"), "--search-rate", "-1"
    message = wrong_input(capsys, "run", str(DEMO / "drive.mp4"), *options)
    assert "--search-rate -1" in message
    assert "e.g. 12" in message


def test_a_file_where_the_logs_should_go_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "taken"
    file.write_text("mine")
    message = wrong_input(capsys, "run", str(DEMO / "drive.mp4"), "--out", str(file))
    assert str(file) in message
    assert file.read_text() == "mine"


def test_an_empty_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert str(tmp_path) in wrong_input(capsys, "run", str(tmp_path))
