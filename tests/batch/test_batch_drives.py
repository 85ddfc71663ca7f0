"""Which drives a batch finds, and which calibration each gets."""

from pathlib import Path

import pytest

from fcw.batch.drives import find_batch_drives
from fcw.errors import UserError


def touch(*paths: Path) -> None:
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")


def test_folders_are_searched_with_all_below_and_logs_of_runs_are_no_drives(tmp_path):
    touch(tmp_path / "a.mp4", tmp_path / "front" / "b.MKV", tmp_path / "front" / "c.mcap")
    touch(tmp_path / "out" / "drive.mcap", tmp_path / "notes.txt", tmp_path / ".hidden.mp4")
    touch(tmp_path / "out" / "failed-drive.mcap")
    touch(tmp_path / "out" / "truth.mcap")  # of `fcw simulate`, with the same pictures as its video
    assert [drive.name for drive in find_batch_drives([tmp_path])] == ["a", "b", "c"]


def test_a_drive_that_is_named_twice_is_one(tmp_path):
    touch(tmp_path / "a.mp4")
    assert len(find_batch_drives([tmp_path, tmp_path / "a.mp4"])) == 1


def test_drives_of_one_name_are_told_apart_by_their_folders_or_suffixes(tmp_path):
    touch(tmp_path / "x" / "a.mp4", tmp_path / "y" / "a.mp4")
    assert [drive.name for drive in find_batch_drives([tmp_path])] == ["x-a", "y-a"]
    touch(tmp_path / "z" / "b.mp4", tmp_path / "z" / "b.mkv")
    names = [drive.name for drive in find_batch_drives([tmp_path / "z"])]
    assert len(set(names)) == 2


def test_the_nearest_calibration_counts(tmp_path):
    own, folders, tables, nobodys = (
        tmp_path / name / "a.mp4" for name in ("own", "folders", "tables", "none")
    )
    touch(
        own, folders, tables, nobodys, own.with_name("a.calibration.yaml"), own.with_name("calibration.yaml")
    )
    touch(folders.with_name("calibration.yaml"), tmp_path / "roof.yaml")
    table = tmp_path / "cameras.csv"
    table.write_text("camera,calibration\ntables,roof.yaml\nown,roof.yaml\n")
    found = {drive.camera: drive.calibration for drive in find_batch_drives([tmp_path], table)}
    assert found == {
        "own": own.with_name("a.calibration.yaml").resolve(),
        "folders": folders.with_name("calibration.yaml").resolve(),
        "tables": tmp_path / "roof.yaml",
        "none": None,
    }


def test_a_gpx_track_beside_a_drive_is_its_own(tmp_path):
    touch(tmp_path / "a.mp4", tmp_path / "b.mp4", tmp_path / "a.gpx")
    first, second = find_batch_drives([tmp_path])
    assert (first.track, second.track) == ((tmp_path / "a.gpx").resolve(), None)


def test_one_file_serves_all_that_have_none(tmp_path):
    touch(tmp_path / "a.mp4", tmp_path / "any.yaml")
    (drive,) = find_batch_drives([tmp_path], tmp_path / "any.yaml")
    assert drive.calibration == tmp_path / "any.yaml"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("kamera,file\na,b.yaml\n", "expected camera and calibration"),
        ("camera,calibration\na,b.yaml\n", "b.yaml of camera a is not there"),
        ("camera,calibration\n", "names no camera"),
    ],
)
def test_a_wrong_table_is_refused(tmp_path, text, told):
    touch(tmp_path / "a.mp4")
    (tmp_path / "cameras.csv").write_text(text)
    with pytest.raises(UserError, match=told):
        find_batch_drives([tmp_path], tmp_path / "cameras.csv")


def test_nothing_found_is_said(tmp_path):
    with pytest.raises(UserError, match="no drive in this folder"):
        find_batch_drives([tmp_path])
    with pytest.raises(UserError, match="no such file"):
        find_batch_drives([tmp_path / "gone"])
