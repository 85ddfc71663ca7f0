"""What a worker keeps of a drive."""

import errno
import shutil
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from mcap_files import DEMO, demo_frames, foxglove_images
from running.demo_cut import cut_demo
from running.tiny_nets import write_quick_net
from video_making import write_short_drive

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions, identity_of
from fcw.batch.ledger import DRIVES_NAME, RECORD_NAME, Ledger, Record, State, read_record
from fcw.batch.plan import plan_batch
from fcw.batch.tables import TABLE_NAMES, write_tables
from fcw.batch.work import Task, run_task
from fcw.detection.model import SHIPPED_MODEL_PATH, Model, model_sha256
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME


def task_for(source: Path, out: Path, topic: str | None = None, join_files: bool = False) -> Task:
    """A drive with a detector that takes no time."""
    (drive,) = find_batch_drives([source], topic=topic, join_files=join_files)
    options = BatchOptions(detector=f"onnx:{write_quick_net(source.with_name('quick.onnx'))}")
    identity = identity_of(drive.source, drive.calibration, options, drive.track, drive.topic)
    return Task(drive, identity, out / drive.name)


@pytest.mark.slow
def test_that_the_end_of_a_file_is_missing_is_kept_with_the_drive(tmp_path):
    source = foxglove_images(tmp_path / "torn.mcap", demo_frames(30))
    shutil.copy(DEMO / "drive.calibration.yaml", tmp_path / "calibration.yaml")
    source.write_bytes(source.read_bytes()[:-200_000])
    record = run_task(task_for(source, tmp_path / "out"))
    assert (record.state, 0 < record.frames < 30) == (State.DONE, True)
    (note,) = record.notes
    assert "torn.mcap: the file was never finished or is damaged" in note
    assert read_record(tmp_path / "out" / "torn" / RECORD_NAME) == record
    write_tables(tmp_path / "out", [record])
    assert pq.read_table(tmp_path / "out" / DRIVES_NAME).column("notes").to_pylist() == [note]


@pytest.mark.slow
def test_of_several_cameras_the_named_one_is_run_and_known_by_its_topic(tmp_path):
    source = foxglove_images(tmp_path / "two.mcap", demo_frames(5), ("/front", "/rear"))
    shutil.copy(DEMO / "drive.calibration.yaml", tmp_path / "calibration.yaml")
    unnamed = task_for(source, tmp_path / "out")
    refused = run_task(unnamed)
    assert (refused.state, "--topic" in refused.reason) == (State.FAILED, True)
    front, rear = (task_for(source, tmp_path / "out", topic) for topic in ("/front", "/rear"))
    assert run_task(front).frames == 5
    assert len({task.identity.key for task in (unnamed, front, rear)}) == 3


@pytest.mark.slow
def test_the_files_of_a_dash_camera_are_run_as_one_drive(tmp_path):
    for part in (1, 2):
        cut_demo(tmp_path / "card" / "monday", part, 0.5, name=f"DR_{part}")
    shutil.copy(DEMO / "drive.calibration.yaml", tmp_path / "card" / "calibration.yaml")
    record = run_task(task_for(tmp_path / "card", tmp_path / "out", join_files=True))
    assert (record.name, record.state, record.frames) == ("monday", State.DONE, 30)
    assert record.source == str(tmp_path / "card" / "monday")
    assert record.duration_s == pytest.approx(29 / 30)


def test_a_trained_model_is_that_of_the_drive(tmp_path):
    source, mine = write_short_drive(tmp_path / "d.mp4", frames=4), tmp_path / "mine.npz"
    replace(Model.load(SHIPPED_MODEL_PATH), score_threshold=1e9).save(mine)
    (drive,) = find_batch_drives([source])
    identity = identity_of(drive.source, drive.calibration, BatchOptions("acf", model=str(mine)))
    assert run_task(Task(drive, identity, tmp_path / "out")).state is State.DONE
    assert DriveLog(tmp_path / "out" / MCAP_NAME).header.model_sha256 == model_sha256(mine)


@pytest.mark.slow
def test_a_record_that_a_full_disk_has_no_room_for_is_no_fault_of_the_program(tmp_path, monkeypatch):
    source = write_short_drive(tmp_path / "d.mp4", frames=10)
    task = task_for(source, tmp_path / "out")
    rename = Path.replace

    def full(path: Path, target: Path) -> Path:
        if target.name == RECORD_NAME:
            raise OSError(errno.ENOSPC, "full")
        return rename(path, target)

    monkeypatch.setattr(Path, "replace", full)
    lost = run_task(task)
    assert lost.state is State.LOST
    assert "batch.json: cannot write this file (No space left on device); make room on the disk, and run" in (
        lost.reason
    )
    source.write_bytes(b"")
    failed = run_task(task)
    assert failed.state is State.FAILED
    assert "d.mp4: not a readable video" in failed.reason
    assert "--retry" not in failed.reason  # nothing says that it failed


def test_a_drive_that_fails_says_at_once_and_once_only_how_it_is_run_again(tmp_path):
    source = tmp_path / "d.mp4"
    source.write_bytes(b"no video")
    (tmp_path / "d.calibration.yaml").write_bytes((DEMO / "drive.calibration.yaml").read_bytes())
    options, ledger = BatchOptions("acf"), Ledger(tmp_path / "out")
    (task,) = plan_batch(find_batch_drives([source]), options, ledger).tasks
    failed = run_task(task)
    assert failed.reason.endswith("; once it is mended, run it again with --retry")
    again = plan_batch(find_batch_drives([source]), options, Ledger(tmp_path / "out"))
    assert [record.reason for record in again.records] == [failed.reason]
    retried = plan_batch(find_batch_drives([source]), options, Ledger(tmp_path / "out"), retry=True)
    assert len(retried.tasks) == 1


def test_the_tables_of_a_batch_fit_each_other_on_a_full_disk_too(tmp_path, monkeypatch):
    write_tables(tmp_path, [Record("a", "/a.mp4", "van", State.FAILED, "torn")])
    earlier = {name: (tmp_path / name).read_bytes() for name in TABLE_NAMES}

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr("fcw.batch.tables.fill_review_list", full)
    with pytest.raises(UserError, match=r"fleet\.html: cannot write these files .*; make room on the disk"):
        write_tables(tmp_path, [Record(name, f"/{name}.mp4", "van", State.FAILED, "torn") for name in "ab"])
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == earlier
