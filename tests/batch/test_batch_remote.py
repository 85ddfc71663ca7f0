"""Drives in object stores: found, known, fetched; what is missing is said."""

import filecmp
import math
import shutil

import fsspec
import pytest
from fsspec.implementations.memory import MemoryFileSystem
from video_making import write_short_drive

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions, identity_of
from fcw.batch.ledger import Ledger, State
from fcw.batch.plan import plan_batch
from fcw.batch.remote import RemoteFile, fetched
from fcw.batch.work import Task, run_task
from fcw.bounded.gpx import EARTH_RADIUS_M
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog


@pytest.fixture
def store():
    """A folder in memory, emptied at the end."""
    filesystem = fsspec.filesystem("memory")
    filesystem.pipe(
        {
            "/drives/van/a.mp4": b"a",
            "/drives/van/a.calibration.yaml": b"of a",
            "/drives/van/b.mp4": b"b",
            "/drives/van/calibration.yaml": b"of the van",
            "/drives/car/c.mp4": b"a",
            "/drives/car/drive.mcap": b"what a run wrote",
        }
    )
    yield filesystem
    filesystem.rm("/drives", recursive=True)


@pytest.mark.usefixtures("store")
def test_folders_of_a_store_are_searched_like_others():
    drives = find_batch_drives(["memory://drives"])
    assert [
        (drive.name, drive.camera, str(drive.calibration or "").rpartition("/")[2]) for drive in drives
    ] == [
        ("a", "van", "a.calibration.yaml"),
        ("b", "van", "calibration.yaml"),
        ("c", "car", ""),
    ]


@pytest.mark.usefixtures("store")
def test_a_file_that_is_named_itself_has_the_calibration_beside_it():
    (drive,) = find_batch_drives(["memory://drives/van/b.mp4"])
    assert str(drive.calibration).endswith("van/calibration.yaml")


def test_a_drive_is_known_by_its_content(store, tmp_path):
    options, ledger = BatchOptions(), Ledger(tmp_path)
    first = plan_batch(find_batch_drives(["memory://drives/van"]), options, ledger)
    store.pipe("/drives/van/a.mp4", b"other pictures")
    second = plan_batch(find_batch_drives(["memory://drives/van"]), options, ledger)
    same = [a.identity == b.identity for a, b in zip(first.tasks, second.tasks, strict=True)]
    assert same == [False, True]


def test_what_a_store_says_of_the_content_is_taken(monkeypatch):
    info = {"name": "x", "size": 5, "ETag": '"abc"', "mtime": 1}
    monkeypatch.setattr(MemoryFileSystem, "info", lambda self, path: info)
    assert RemoteFile("memory://x").content() == 'ETag "abc" 5'


def test_an_empty_file_of_a_store_has_failed(store, tmp_path):
    store.pipe("/drives/van/a.mp4", b"")
    planned = plan_batch(find_batch_drives(["memory://drives/van"]), BatchOptions(), Ledger(tmp_path))
    assert [task.drive.name for task in planned.tasks] == ["b"]
    (failed,) = planned.records
    assert (failed.state, "van/a.mp4: empty file" in failed.reason) == (State.FAILED, True)


@pytest.mark.usefixtures("store")
def test_what_was_fetched_has_its_name_and_goes_again():
    with fetched(RemoteFile("memory://drives/van/a.mp4"), None) as (path, none):
        assert path is not None
        assert (path.name, path.read_bytes(), none) == ("a.mp4", b"a", None)
    assert not path.exists()


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("memory://nowhere", "no such file or folder"),
        ("s3://bucket/drives", r"pip install 'fsspec\[s3\]'"),
        ("nostore://a", "Protocol not known"),
    ],
)
def test_what_cannot_be_read_is_said(url, told):
    with pytest.raises(UserError, match=told):
        find_batch_drives([url])


# 20 m/s to the north.
TRACK = "<gpx><trk><trkseg>{}</trkseg></trk></gpx>".format(
    "".join(
        f'<trkpt lat="{48 + math.degrees(20 * k / EARTH_RADIUS_M):.8f}" lon="11">'
        f"<time>2026-11-20T00:00:{k:02d}Z</time></trkpt>"
        for k in range(5)
    )
).encode()


@pytest.mark.slow
def test_a_fetched_drive_is_the_drive(tmp_path):
    source = write_short_drive(tmp_path / "d.mp4", frames=20)
    source.with_suffix(".gpx").write_bytes(TRACK)
    remote = tmp_path / "remote"
    remote.mkdir()
    for path in tmp_path.glob("d.*"):
        shutil.copy(path, remote / path.name)
    options = BatchOptions(detector="acf")
    (here,), (there,) = find_batch_drives([source]), find_batch_drives([f"file://{remote}"])
    assert isinstance(there.source, RemoteFile)
    for name, drive in (("here", here), ("there", there)):
        identity = identity_of(drive.source, drive.calibration, options, drive.track)
        record = run_task(Task(drive, identity, tmp_path / name))
        assert (record.state, record.frames, record.reason) == (State.DONE, 20, "")
        log = DriveLog(tmp_path / name / "drive.mcap")
        assert log.header.gpx == TRACK
        assert log.series().ego_speed_mps == pytest.approx(20.0, abs=0.01)
        assert identity.key != identity_of(drive.source, drive.calibration, options).key
    logs = (tmp_path / name / "drive.mcap" for name in ("here", "there"))
    assert filecmp.cmp(*logs, shallow=False)
    identity = identity_of(there.source, there.calibration, options)
    shutil.rmtree(remote)
    gone = run_task(Task(there, identity, tmp_path / "gone"))
    assert gone.state is State.FAILED
    assert "no such file" in gone.reason
