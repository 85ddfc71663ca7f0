"""What a worker keeps of a drive."""

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from mcap_files import DEMO, demo_frames, foxglove_images
from running.tiny_nets import write_quick_net

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions, identity_of
from fcw.batch.ledger import RECORD_NAME, State, read_record
from fcw.batch.tables import DRIVES_NAME, write_tables
from fcw.batch.work import Task, run_task


def task_for(source: Path, out: Path) -> Task:
    """A drive with a detector that takes no time."""
    (drive,) = find_batch_drives([source])
    options = BatchOptions(detector=f"onnx:{write_quick_net(source.with_name('quick.onnx'))}")
    identity = identity_of(drive.source, drive.calibration, options, drive.track)
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
