"""Commands that are suggested with a path can be pasted into a shell, whatever the path is."""

import io
import re
import shlex
from pathlib import Path

import pytest
from export_drives import drive_header, marked_drive, write_log
from rich.console import Console

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions
from fcw.batch.ledger import Ledger
from fcw.batch.plan import plan_batch
from fcw.errors import UserError
from fcw.job import DriveJob, DriveOutcome, prepare_drive
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw.simulation.drive import SPEED_NAME
from fcw_viz.cli import main
from fcw_viz.commands.run.report import report_drive

DEMO = Path(__file__).parents[3] / "recordings" / "demo"


@pytest.fixture
def folder(tmp_path) -> Path:
    path = tmp_path / "Ann's $drives of May"
    path.mkdir()
    return path


def suggested(text: str) -> list[list[str]]:
    """What a shell makes of the commands in a text: in backticks, or from `fcw` to the end of the line."""
    marked = re.findall(r"`(fcw [^`]*)`", text)
    return [shlex.split(command) for command in marked or re.findall(r"\b(fcw \w.*)", text)]


def test_a_batch_names_the_calibration_to_make(folder):
    source = folder / "a.mp4"
    source.write_bytes(b"a")
    planned = plan_batch(find_batch_drives([folder]), BatchOptions(), Ledger(folder / "out"))
    assert suggested(planned.records[0].reason) == [["fcw", "calibrate", str(source)]]


def test_so_does_a_run(folder):
    source = folder / "a.mp4"
    source.symlink_to(DEMO / "drive.mp4")
    with pytest.raises(UserError) as caught:
        prepare_drive(DriveJob(source, folder / "out"))
    assert suggested(str(caught.value)) == [["fcw", "calibrate", str(source)]]


def test_the_end_of_a_run_names_its_review(folder):
    summary = {"source": "a", "frames": 1, "duration_s": 1.0, "frames_per_second": 9.0}
    summary |= {"frames_with_lead": 0, "warnings": [], "blind_s": 0.0}
    told = io.StringIO()
    report_drive(DriveOutcome(summary, (), False), folder, Console(file=told, width=300))
    review = ["fcw", "review", str(folder)]
    assert suggested(told.getvalue()) == [review, [*review, "--rerun"]]


@pytest.mark.parametrize(("duration_s", "said"), [(0.5, True), (1.0, False)])
def test_a_drive_too_short_for_a_warning_says_so(folder, duration_s, said):
    summary = {"source": "a", "frames": 15, "duration_s": duration_s, "frames_per_second": 9.0}
    summary |= {"frames_with_lead": 0, "warnings": [], "blind_s": 0.0}
    told = io.StringIO()
    report_drive(DriveOutcome(summary, (), False), folder, Console(file=told, width=300))
    assert ("no warnings, but the drive is too short for any" in told.getvalue()) == said


def test_the_end_of_a_simulation_names_its_run(folder, monkeypatch, capsys):
    monkeypatch.setattr("fcw.simulation.drive.write_drive", lambda *_: None)
    assert main(["simulate", "braking", "--out", str(folder)]) == 0
    (run,) = suggested(capsys.readouterr().out.splitlines()[-1])
    assert run == ["fcw", "run", str(folder / "drive.mp4"), "--ego-speed", str(folder / SPEED_NAME)]


def test_a_torn_log_names_its_recovery(folder):
    path = folder / MCAP_NAME
    write_log(path, marked_drive(30), drive_header())
    path.write_bytes(path.read_bytes()[:-30_000])
    assert suggested(DriveLog(path).notes[0]) == [["fcw", "recover", str(path)]]


def test_a_drive_without_verdicts_names_its_review(folder, capsys):
    log = write_log(folder / MCAP_NAME, marked_drive(30), drive_header())
    assert main(["evaluate", "warning", "--log", str(log.path)]) == 2
    assert suggested(capsys.readouterr().err) == [["fcw", "review", str(log.path)]]
