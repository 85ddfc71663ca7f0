"""What a batch still has to do, by what lies in its folder."""

import dataclasses
from pathlib import Path

import pytest

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions
from fcw.batch.ledger import RECORD_NAME, Ledger, Record, State, write_record
from fcw.batch.plan import Plan, plan_batch

OPTIONS = BatchOptions()


@pytest.fixture
def drives(tmp_path) -> Path:
    folder = tmp_path / "drives"
    folder.mkdir()
    for name in ("a", "b"):
        (folder / f"{name}.mp4").write_bytes(name.encode())
        (folder / f"{name}.calibration.yaml").write_text("a calibration")
    return folder


def plan(folder: Path, options: BatchOptions = OPTIONS, retry: bool = False) -> Plan:
    return plan_batch(find_batch_drives([folder]), options, Ledger(folder.parent / "out"), retry)


def end(planned: Plan, state: State, reason: str = "") -> None:
    """As if a worker had run all tasks."""
    for task in planned.tasks:
        drive = task.drive
        record = Record(drive.name, str(drive.source), drive.camera, state, reason, task.identity, frames=7)
        write_record(record, task.folder)


def names(planned: Plan) -> list[str]:
    return [task.drive.name for task in planned.tasks]


def test_what_is_done_is_not_run_again(drives):
    assert names(plan(drives)) == ["a", "b"]
    end(plan(drives), State.DONE)
    again = plan(drives)
    assert names(again) == []
    assert [record.frames for record in again.records] == [7, 7]


def test_a_drive_is_known_by_its_content_under_any_name(drives):
    end(plan(drives), State.DONE)
    for path in sorted(drives.glob("a.*")):
        path.rename(drives / path.name.replace("a.", "c.", 1))
    again = plan(drives)
    assert names(again) == []
    assert {record.name: Path(record.source).name for record in again.records} == {"a": "c.mp4", "b": "b.mp4"}


def test_a_new_drive_does_not_take_the_folder_of_one_that_was_renamed(drives):
    end(plan(drives), State.DONE)
    for path in sorted(drives.glob("a.*")):
        path.rename(drives / path.name.replace("a.", "c.", 1))
    (drives / "a.mp4").write_bytes(b"new")
    (drives / "a.calibration.yaml").write_text("a calibration")
    (task,) = plan(drives).tasks
    assert task.drive.name.startswith("a-")
    assert not task.folder.exists()


@pytest.mark.parametrize("changed", ["content", "calibration", "options"])
def test_whatever_the_result_depends_on_makes_another_drive_of_it(drives, changed):
    end(plan(drives), State.DONE)
    options = OPTIONS
    if changed == "content":
        (drives / "a.mp4").write_bytes(b"other pictures")
    elif changed == "calibration":
        (drives / "a.calibration.yaml").write_text("another")
    else:
        options = dataclasses.replace(OPTIONS, detector="acf")
    assert names(plan(drives, options)) == (["a", "b"] if changed == "options" else ["a"])


def test_a_record_torn_by_a_crash_counts_for_nothing(drives):
    end(plan(drives), State.DONE)
    record = drives.parent / "out" / "a" / RECORD_NAME
    record.write_text(record.read_text()[:40])
    assert names(plan(drives)) == ["a"]


def test_what_failed_is_named_again_and_run_only_by_retry(drives):
    end(plan(drives), State.FAILED, "a.mp4: torn; repair it")
    again = plan(drives)
    assert names(again) == []
    assert all(record.reason.endswith("run it again with --retry") for record in again.records)
    (drives / "c.mp4").write_bytes(b"c")
    (drives / "c.calibration.yaml").write_text("a calibration")
    assert names(plan(drives)) == ["c"]
    retried = plan(drives, retry=True)
    assert names(retried) == ["a", "b"]
    assert [(record.name, record.state) for record in retried.records] == [("c", State.LOST)]


def test_copies_and_drives_without_calibration_are_listed(drives):
    (drives / "copy.mp4").write_bytes(b"a")
    (drives / "copy.calibration.yaml").write_text("a calibration")
    (drives / "bare.mp4").write_bytes(b"bare")
    planned = plan(drives)
    assert names(planned) == ["a", "b"]
    told = {record.name: (record.state, record.reason) for record in planned.records}
    assert told["copy"] == (State.DUPLICATE, "the same file and calibration as a")
    assert told["bare"][0] is State.UNCALIBRATED
    assert "fcw calibrate" in told["bare"][1]
