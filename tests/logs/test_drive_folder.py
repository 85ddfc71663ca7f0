"""The folder of a run: locked, no input, no stranger's, and an earlier drive until there is a new one."""

import json
from pathlib import Path

import pytest

from fcw.errors import UserError
from fcw.logs.drive_folder import drive_folder
from fcw.logs.export.clip import find_drives

MCAP = b"\x89MCAP0\r\n"


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def an_earlier_drive(folder: Path) -> None:
    (folder / "drive.mcap").write_bytes(MCAP + b"earlier")
    (folder / "drive.rrd").write_bytes(b"RRF2earlier")
    (folder / "summary.json").write_text(json.dumps({"versions": {}}))


def fail(out: Path, log: bytes) -> None:
    """A run that ends half way."""
    try:
        with drive_folder(out, []):
            (out / "drive.mcap").write_bytes(log)
            raise UserError("a picture is damaged")
    except UserError:
        pass


def test_a_whole_run_replaces_the_earlier_drive(tmp_path: Path):
    an_earlier_drive(tmp_path)
    with drive_folder(tmp_path, []):
        assert not (tmp_path / "drive.mcap").exists()
        (tmp_path / "drive.mcap").write_bytes(MCAP + b"new")
    assert names(tmp_path) == {"drive.mcap"}
    assert (tmp_path / "drive.mcap").read_bytes() == MCAP + b"new"


def test_a_run_that_fails_leaves_the_earlier_drive_and_what_there_is_of_its_own(tmp_path: Path):
    an_earlier_drive(tmp_path)
    fail(tmp_path, MCAP + b"new")
    assert names(tmp_path) == {"drive.mcap", "drive.rrd", "summary.json", "failed-drive.mcap"}
    assert (tmp_path / "drive.mcap").read_bytes() == MCAP + b"earlier"
    assert (tmp_path / "failed-drive.mcap").read_bytes() == MCAP + b"new"


def test_a_first_run_that_fails_keeps_its_log_where_it_is(tmp_path: Path):
    fail(tmp_path / "out", MCAP)
    assert names(tmp_path / "out") == {"drive.mcap"}


def test_two_runs_do_not_write_to_one_folder(tmp_path: Path):
    with drive_folder(tmp_path, []), pytest.raises(UserError, match="another run is writing to this folder"):
        drive_folder(tmp_path, []).__enter__()
    with drive_folder(tmp_path, []):
        pass


@pytest.mark.parametrize("name", ["drive.mcap", "drive.rrd", "summary.json"])
def test_no_input_is_replaced_by_whatever_link_it_is_named(tmp_path: Path, name: str):
    an_earlier_drive(tmp_path)
    before = (tmp_path / name).read_bytes()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / name)
    for read in (tmp_path / name, link):
        with pytest.raises(UserError, match=f"the new {name} would replace"):
            drive_folder(tmp_path, [read]).__enter__()
    assert (tmp_path / name).read_bytes() == before


def test_another_programs_summary_and_folders_are_not_touched(tmp_path: Path):
    summary = tmp_path / "summary.json"
    summary.write_text('{"mine": 1}')
    with pytest.raises(UserError, match=r"the summary\.json in it is no drive's"):
        drive_folder(tmp_path, []).__enter__()
    assert summary.read_text() == '{"mine": 1}'
    summary.unlink()
    (tmp_path / "drive.mcap").mkdir()
    with pytest.raises(UserError, match=r"the drive\.mcap in it is no drive's"):
        drive_folder(tmp_path, []).__enter__()


def test_links_are_removed_and_never_followed(tmp_path: Path):
    other = tmp_path / "other"
    other.write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    for name in ("drive.mcap", "drive.rrd", "drive.partial.rrd"):
        (out / name).symlink_to(other)
    with drive_folder(out, []):
        (out / "drive.mcap").write_bytes(MCAP)
    assert other.read_text() == "mine"
    assert names(out) == {"drive.mcap"}


def test_what_a_kill_left_aside_is_no_drive_and_goes_away_when_a_later_run_is_whole(tmp_path: Path):
    aside = tmp_path / "out" / ".earlier-0a1b2c3d"
    aside.mkdir(parents=True)
    an_earlier_drive(aside)
    (tmp_path / "other").mkdir()
    an_earlier_drive(tmp_path / "other")
    assert list(find_drives([tmp_path])) == ["other"]
    fail(tmp_path / "out", MCAP)
    assert aside.is_dir()  # the earlier drive is the only whole one still
    with drive_folder(tmp_path / "out", []):
        (tmp_path / "out" / "drive.mcap").write_bytes(MCAP)
    assert names(tmp_path / "out") == {"drive.mcap"}
