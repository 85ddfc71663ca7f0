"""Which drives and frames an export takes."""

import os
import sys
from pathlib import Path

import pytest
from export_drives import START_NS, STEP_NS, drive_header, marked_drive, write_log

from fcw.errors import UserError
from fcw.logs.export.clip import DriveClip, check_between, find_drives
from fcw.logs.export.columns import TRACK_COLUMNS, track_rows
from fcw.logs.export.table import write_csv


@pytest.fixture(scope="module")
def log_bytes(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("log") / "drive.mcap"
    write_log(path, [(result, ()) for result, _ in marked_drive(30)], drive_header())
    return path.read_bytes()


def put(path: Path, data: bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path.resolve()


def test_a_log_a_folder_and_a_folder_of_folders_stand_for_their_drives(tmp_path, log_bytes):
    a = put(tmp_path / "all" / "monday" / "drive.mcap", log_bytes)
    b = put(tmp_path / "all" / "tuesday" / "drive.mcap", log_bytes)
    c = put(tmp_path / "kept.mcap", log_bytes)
    assert find_drives([a]) == {"monday": a}
    assert find_drives([a.parent]) == {"monday": a}
    assert find_drives([tmp_path / "all", c]) == {"monday": a, "tuesday": b, "kept": c}


def test_links_that_lead_nowhere_or_to_themselves_are_no_drives(tmp_path, log_bytes):
    drive = put(tmp_path / "monday" / "drive.mcap", log_bytes)
    for name, target in (("loop", "drive.mcap"), ("gone", "nowhere.mcap"), ("linked", str(drive))):
        (tmp_path / name).mkdir()
        (tmp_path / name / "drive.mcap").symlink_to(target)
    assert find_drives([tmp_path]) == {"monday": drive}


def test_a_drive_named_twice_is_taken_once(tmp_path, log_bytes):
    a = put(tmp_path / "monday" / "drive.mcap", log_bytes)
    assert find_drives([a, a.parent, tmp_path]) == {"monday": a}


def test_drives_of_the_same_name_are_told_apart_by_the_folders_above(tmp_path, log_bytes):
    a = put(tmp_path / "car" / "monday" / "drive.mcap", log_bytes)
    b = put(tmp_path / "van" / "monday" / "drive.mcap", log_bytes)
    c = put(tmp_path / "van" / "tuesday" / "drive.mcap", log_bytes)
    assert find_drives([tmp_path]) == {"car-monday": a, "van-monday": b, "tuesday": c}


def test_a_log_beside_the_folder_of_its_name_is_told_apart_by_a_number(tmp_path, log_bytes):
    folders = put(tmp_path / "monday" / "drive.mcap", log_bytes)
    cut, second = (put(tmp_path / name, log_bytes) for name in ("monday.mcap", "monday-2.mcap"))
    assert find_drives([folders, cut]) == {"monday": folders, "monday-2": cut}
    assert find_drives([cut, folders, second]) == {"monday": cut, "monday-2": folders, "monday-2-2": second}


@pytest.mark.skipif(sys.platform != "linux", reason="other systems allow no such names")
def test_a_name_that_is_no_utf_8_is_written_with_escapes(tmp_path, log_bytes):
    latin_1 = tmp_path / os.fsdecode(b"caf\xe9")
    drive = put(latin_1 / "drive.mcap", log_bytes)
    drives = find_drives([tmp_path])
    assert drives == {r"caf\udce9": drive}
    rows = track_rows([DriveClip.open(drive, name) for name in drives], lambda: None)
    assert write_csv(tmp_path / "tracks.csv", TRACK_COLUMNS, rows) == 30
    assert DriveClip.open(drive).name == r"caf\udce9"


def test_other_mcap_files_in_a_folder_are_no_drives(tmp_path, log_bytes):
    put(tmp_path / "truth.mcap", log_bytes)
    with pytest.raises(UserError, match=r"no drive\.mcap in this folder or below it"):
        find_drives([tmp_path])


def test_a_path_that_is_not_there_is_named(tmp_path):
    with pytest.raises(UserError, match=r"nowhere: no such file or folder; expected a drive\.mcap"):
        find_drives([tmp_path / "nowhere"])


@pytest.mark.parametrize(
    ("between", "frames"),
    [
        (None, range(30)),
        ((0, 0), range(1)),
        ((0.04, 0.12), range(1, 4)),
        ((0.05, 0.11), range(2, 3)),
        ((1, 99), range(25, 30)),
    ],
)
def test_a_range_takes_the_frames_in_it_with_both_ends(tmp_path, log_bytes, between, frames):
    clip = DriveClip.open(put(tmp_path / "drive.mcap", log_bytes), between=between)
    assert [result.index for result in clip.results()] == list(frames)
    assert clip.times_ns.tolist() == [START_NS + index * STEP_NS for index in frames]
    assert clip.time_s(START_NS + STEP_NS) == 0.04


def test_a_range_without_a_frame_tells_how_long_the_drive_is(tmp_path, log_bytes):
    path = put(tmp_path / "drive.mcap", log_bytes)
    with pytest.raises(UserError, match=r"--between 5 9: .*drive\.mcap has no frame there; .* 0 to 1\.16 s"):
        DriveClip.open(path, between=(5, 9))


def test_a_drive_without_frames_says_so(tmp_path):
    write_log(tmp_path / "drive.mcap", [], drive_header())
    with pytest.raises(UserError, match="holds no frame; there is nothing to export"):
        DriveClip.open(tmp_path / "drive.mcap")


@pytest.mark.parametrize("between", [(2, 1), (-1, 1), (float("nan"), 1), (0, float("inf"))])
def test_a_range_that_is_none_is_refused(between):
    with pytest.raises(UserError, match=r"expected two times in seconds .* the earlier one first"):
        check_between(between)
