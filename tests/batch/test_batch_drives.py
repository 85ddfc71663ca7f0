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


def test_videos_of_cameras_that_use_other_containers_are_drives_too(tmp_path):
    touch(*(tmp_path / name for name in ("a.MTS", "b.m2ts", "c.3gp", "d.asf", "e.wmv", "f.flv", "g.MPEG")))
    assert [drive.name for drive in find_batch_drives([tmp_path])] == list("abcdefg")


def test_a_drive_whose_name_is_as_long_as_can_be_does_not_stop_the_others(tmp_path):
    longest = "n" * 251  # with its suffix 255 bytes, so that no file beside it can have a longer one
    touch(tmp_path / f"{longest}.mp4", tmp_path / "a.mp4", tmp_path / "calibration.yaml")
    found = {drive.name: (drive.calibration, drive.track) for drive in find_batch_drives([tmp_path])}
    assert found == dict.fromkeys(("a", longest), (tmp_path / "calibration.yaml", None))


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
        "own": own.with_name("a.calibration.yaml"),
        "folders": folders.with_name("calibration.yaml"),
        "tables": tmp_path / "roof.yaml",
        "none": None,
    }


def test_blanks_around_the_cells_of_a_table_do_not_count(tmp_path):
    touch(tmp_path / "A" / "a.mcap", tmp_path / "roof.yaml")
    table = tmp_path / "cameras.csv"
    table.write_text("camera , calibration , topic \n A ,roof.yaml , /front/image \n")
    (drive,) = find_batch_drives([tmp_path], table)
    assert (drive.calibration, drive.topic) == (tmp_path / "roof.yaml", "/front/image")


def test_the_topic_of_an_mcap_file_is_that_of_its_camera_or_else_the_one_for_all(tmp_path):
    touch(*(tmp_path / name for name in ("front/a.mcap", "front/b.mp4", "roof/c.mcap", "other/d.mcap")))
    touch(tmp_path / "any.yaml")
    table = tmp_path / "cameras.csv"
    table.write_text("camera,topic,calibration\nfront,/front/image,any.yaml\nroof,,any.yaml\n")
    found = find_batch_drives([tmp_path], table, "/image")
    assert {drive.name: drive.topic for drive in found} == {
        "a": "/front/image",
        "b": None,  # a video has no topics
        "c": "/image",
        "d": "/image",
    }
    assert {drive.topic for drive in find_batch_drives([tmp_path], tmp_path / "any.yaml")} == {None}


def test_a_gpx_track_beside_a_drive_is_its_own(tmp_path):
    touch(tmp_path / "a.mp4", tmp_path / "b.mp4", tmp_path / "a.gpx")
    touch(tmp_path / "C.MP4", tmp_path / "C.GPX")
    shouted, first, second = find_batch_drives([tmp_path])
    assert (first.track, second.track) == (tmp_path / "a.gpx", None)
    assert shouted.track == tmp_path / "C.GPX"


def test_a_link_has_the_name_the_camera_and_the_files_beside_it(tmp_path):
    touch(tmp_path / "store" / "0001.mp4", tmp_path / "store" / "0001.gpx", tmp_path / "store" / "2.mp4")
    touch(tmp_path / "store" / "2.calibration.yaml", tmp_path / "van" / "calibration.yaml")
    touch(tmp_path / "van" / "monday.gpx", tmp_path / "bus" / "x.txt")
    (tmp_path / "van" / "monday.mp4").symlink_to(tmp_path / "store" / "0001.mp4")
    (tmp_path / "bus" / "tuesday.mp4").symlink_to(Path("..", "store", "2.mp4"))
    monday, tuesday = find_batch_drives([tmp_path / "van", tmp_path / "bus"])
    assert (monday.name, monday.camera, monday.source) == ("monday", "van", tmp_path / "van" / "monday.mp4")
    assert monday.calibration == tmp_path / "van" / "calibration.yaml"
    assert monday.track == tmp_path / "van" / "monday.gpx"
    assert (tuesday.name, tuesday.camera) == ("tuesday", "bus")
    assert tuesday.calibration == tmp_path / "store" / "2.calibration.yaml"  # there is none beside the link


def test_a_file_goes_before_links_to_it_and_each_is_one_drive(tmp_path):
    touch(tmp_path / "van" / "b.mp4")
    for link in (tmp_path / "a.mp4", tmp_path / "van" / "a.mp4"):
        link.symlink_to(tmp_path / "van" / "b.mp4")
    (drive,) = find_batch_drives([tmp_path])
    assert drive.source == tmp_path / "van" / "b.mp4"


def test_linked_folders_are_searched_once_each_and_by_their_own_paths_first(tmp_path):
    touch(tmp_path / "drives" / "van" / "deep" / "a.mp4", tmp_path / "elsewhere" / "b.mp4")
    (tmp_path / "drives" / "again").symlink_to(tmp_path / "drives" / "van")
    (tmp_path / "drives" / "van" / "loop").symlink_to(tmp_path / "drives")
    (tmp_path / "drives" / "bus").symlink_to(tmp_path / "elsewhere")
    found = [drive.source for drive in find_batch_drives([tmp_path / "drives"])]
    assert found == [
        tmp_path / "drives" / "van" / "deep" / "a.mp4",
        tmp_path / "drives" / "bus" / "b.mp4",
    ]


def test_the_camera_of_a_file_above_is_the_name_of_its_folder(tmp_path, monkeypatch):
    touch(tmp_path / "van" / "a.mp4", tmp_path / "van" / "here" / "x.txt")
    monkeypatch.chdir(tmp_path / "van" / "here")
    assert [drive.camera for drive in find_batch_drives([Path("..", "a.mp4")])] == ["van"]


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
        ("camera,calibration\na,b.yaml\na,c.yaml\na,b.yaml\n", "camera a has 2 unlike lines; keep one"),
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


def test_files_of_one_folder_are_one_drive_where_that_is_asked(tmp_path):
    monday, tuesday = tmp_path / "card" / "2026.05.04", tmp_path / "card" / "2026.05.05"
    touch(*(day / f"DR_{i}.MP4" for day in (monday, tuesday) for i in range(3)))
    touch(tuesday / "calibration.yaml", tmp_path / "card" / "calibration.yaml", monday / "log.mcap")
    touch(tmp_path / "card" / "2026.05.04.gpx", tmp_path / "card" / "2026.05.05.calibration.yaml")
    touch(tmp_path / "roof" / "alone.mp4", tmp_path / "roof" / "a" / "DR_1.MP4", tmp_path / "roof" / "b.mp4")
    touch(monday / "._DR_0.MP4", tmp_path / "roof" / "calibration.yaml")
    found = {drive.name: drive for drive in find_batch_drives([tmp_path], join_files=True)}
    assert {name: drive.source for name, drive in found.items()} == {
        "2026.05.04": monday,
        "2026.05.05": tuesday,
        "log": monday / "log.mcap",
        "roof": tmp_path / "roof",
        "DR_1": tmp_path / "roof" / "a" / "DR_1.MP4",
    }
    assert found["2026.05.04"].calibration == tmp_path / "card" / "calibration.yaml"
    assert found["2026.05.04"].track == tmp_path / "card" / "2026.05.04.gpx"
    assert found["2026.05.05"].calibration == tmp_path / "card" / "2026.05.05.calibration.yaml"
    assert found["roof"].calibration == tmp_path / "roof" / "calibration.yaml"
    assert {found[name].camera for name in ("2026.05.04", "2026.05.05")} == {"card"}


def test_files_of_a_store_are_not_joined():
    with pytest.raises(UserError, match="memory://card: --join-files takes folders of this computer"):
        find_batch_drives(["memory://card"], join_files=True)
