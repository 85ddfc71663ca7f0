"""`fcw run --live`: complete logs whatever ends it, and clear words for wrong input."""

import os
import signal
import subprocess
import sys
import time
import urllib.request
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from review_drives import result
from running.programs import start_program

from fcw.frame import ImageSize
from fcw.job import DriveOutcome
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.pictures import LogPictures
from fcw.sources import open_source
from fcw.sources.camera import camera_name
from fcw.sources.live import LiveSource
from fcw.summary import DriveSummary
from fcw_viz.cli import main
from fcw_viz.commands.run import live
from fcw_viz.commands.run.report import report_drive
from fcw_viz.console import RESULTS
from fcw_viz.live_app.feed import LiveFeed

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
PATIENCE_S = 600  # on a busy machine


def started(*arguments: str) -> subprocess.Popen[str]:
    """`fcw run --live`."""
    return start_program("run", *arguments, "--live", "--no-open", "--port", "8480")


def address(process: subprocess.Popen[str]) -> str:
    """Where the page is, as the command says it."""
    assert process.stderr is not None
    for line in process.stderr:
        if "live at " in line:
            return line.split()[2]
    raise AssertionError("the command says no address")


@pytest.mark.slow
def test_ctrl_c_ends_a_live_drive_with_complete_logs(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = started(str(DEMO / "drive.mp4"), "--out", str(out))
    with urllib.request.urlopen(address(process), timeout=PATIENCE_S) as page:
        assert page.status == 200
    deadline = time.monotonic() + PATIENCE_S
    while not (out / "drive.mcap").is_file() or (out / "drive.mcap").stat().st_size < 300_000:
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < deadline, "the log does not grow"
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=PATIENCE_S)

    assert process.returncode == 130, stderr
    log = DriveLog(out / "drive.mcap")
    results = list(log.results())
    assert log.complete
    assert [result.index for result in results] == list(range(len(results)))
    # The times are the source's own, of the frames that were not left out; and so are the pictures.
    wanted = {result.time_ns: result.index for result in results[::7]}
    pictures, compared = LogPictures(log), 0
    for frame in open_source(DEMO / "drive.mp4").frames():
        if frame.time_ns > results[-1].time_ns:
            break
        if frame.time_ns in wanted:
            assert np.array_equal(pictures.at(wanted[frame.time_ns]), frame.image)
            compared += 1
    pictures.close()
    assert compared == len(wanted)
    assert (out / "summary.json").is_file()


def test_everything_is_compiled_before_the_first_picture_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compiles_until_ctrl_c(*_: object) -> None:
        raise KeyboardInterrupt

    def looks(*_: object) -> None:
        raise AssertionError("a picture was taken")

    monkeypatch.setattr(live, "rehearse", compiles_until_ctrl_c)
    monkeypatch.setattr(LiveSource, "frames", looks)
    out = tmp_path / "out"
    arguments = ["run", str(DEMO / "drive.mp4"), "--live", "--no-open", "--port", "8490", "--out", str(out)]
    assert main(arguments) == 130
    told = capsys.readouterr().err.splitlines()
    assert [line.split(" ", 1)[0] for line in told] == ["live", "getting", "fcw:"]
    assert not out.exists()


class NamedCamera:
    """As far as it is looked at before the page is there."""

    image_size = ImageSize(1280, 720)
    frame_count = None
    frame_rate_hz = 30.0
    relays_video = recorded = False
    notes = ()

    def __init__(self, address: str, wanted_size: ImageSize) -> None:
        self.name = camera_name(address)


def test_the_page_has_the_whole_name_of_a_camera(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    titles: list[str] = []

    def page(_feed: LiveFeed, title: str, _port: int) -> None:
        titles.append(title)
        raise KeyboardInterrupt

    monkeypatch.setattr(live, "CameraSource", NamedCamera)
    monkeypatch.setattr(live, "LivePage", page)
    monkeypatch.chdir(tmp_path)
    for address in ("http://127.0.0.1:8081/s", "rtsp://10.0.0.7/live.sdp"):
        assert main(["run", address, "--live", "--calibration", str(DEMO / "drive.calibration.yaml")]) == 130
    assert main(["run", str(DEMO / "drive.mp4"), "--live"]) == 130
    assert titles == ["127.0.0.1-8081-s", "10.0.0.7-live.sdp", "drive"]


# In a process of its own, where nothing is compiled or loaded before.
LOADED_ANEW = """
import gc, sys, threading
from pathlib import Path
from numba.core.dispatcher import Dispatcher
from fcw.job import DriveJob, run_drive
from fcw_viz.jobs.rehearsal import rehearse

def kernels():
    return {
        (each.py_func.__qualname__, signature)
        for each in gc.get_objects() if isinstance(each, Dispatcher) for signature in each.signatures
    }

enough = threading.Event()
drive, out = map(Path, sys.argv[1:])
job = DriveJob(drive, out)
rehearse(job, drive)
before = kernels()
assert before
run_drive(job, stop=enough, on_result=lambda result: result.index < 90 or enough.set())
print(kernels() - before)
"""


@pytest.mark.slow
def test_a_drive_after_the_rehearsal_needs_no_other_kernel(tmp_path: Path) -> None:
    command = [sys.executable, "-c", LOADED_ANEW, str(DEMO / "drive.mp4"), str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert (done.returncode, done.stdout) == (0, "set()\n"), done.stderr


def test_no_warnings_do_not_stand_alone_where_the_drive_was_not_seen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    summary = DriveSummary("drive.mp4", {})
    for time_s in (0, 30, 40):
        summary.add(replace(result(0), time_ns=time_s * 1_000_000_000))
    report_drive(DriveOutcome(summary.as_json(1.0), (), False), tmp_path, RESULTS)
    assert "no warnings, but blind for 40.0 s of 40.0 s" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("0",), "0: a camera needs --live; add it"),
        (("rtsp://10.0.0.1/main",), "rtsp://10.0.0.1/main: a camera needs --live; add it"),
        (("drive.mp4", "--port", "8500"), "--port and --no-open need --live"),
        (("0", "--live"), "camera-0.calibration.yaml: no calibration for camera-0; make one with"),
        (("0", "--live", "--topic", "/x"), "0: a camera has neither --frame-rate nor --topic"),
        (("nothing.mp4", "--live"), "nothing.mp4: no such file or folder"),
        (
            ("97", "--live", "--calibration", str(DEMO / "drive.calibration.yaml")),
            "camera-97: no camera there with pictures of 1280x720",
        ),
        ((str(DEMO / "drive.mp4"), "--live", "--port", "0"), "--port 0: expected a number from 1 to 65535"),
    ],
)
def test_wrong_input_gives_one_message(
    arguments: tuple[str, ...],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_a_calibration_no_page_is_opened(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "drive.mp4"
    source.write_bytes((DEMO / "drive.mp4").read_bytes())
    assert main(["run", str(source), "--live", "--no-open"]) == 2
    error = capsys.readouterr().err
    assert "drive.calibration.yaml: no calibration for" in error
    assert "live at" not in error
