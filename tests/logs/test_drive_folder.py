"""The folder of a run: locked, no input, no stranger's, and an earlier drive until there is a new one."""

import hashlib
import io
import json
import re
from contextlib import suppress
from pathlib import Path

import pytest
from export_drives import drive_header
from mcap.writer import Writer

from fcw.errors import UserError
from fcw.logs.drive_folder import drive_folder
from fcw.logs.export.clip import find_drives
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import mcap_path
from fcw.versions import versions


def mcap_start(library: str, profile: str = "") -> bytes:
    """How an MCAP file of a program begins."""
    data = io.BytesIO()
    Writer(data).start(profile=profile, library=library)
    return data.getvalue()


MCAP = mcap_start("fcw 0.1.0")
RRD = bytes.fromhex(  # as rerun 0.41 writes it, with an application's name to follow
    "52524632002900000102000001000000000000005600000000000000"
    "0a1209916ac261078aea1811bb564a6dfe7a895812401"
    "22b08011220303734303036393537653562346336396464633462643837326139386264391a050a"
)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def an_earlier_drive(folder: Path) -> None:
    (folder / "drive.mcap").write_bytes(MCAP + b"earlier")
    (folder / "drive.rrd").write_bytes(RRD + b"\x03fcwearlier")
    (folder / "summary.json").write_text(json.dumps({"versions": versions()}))


def digests(folder: Path) -> dict[Path, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def fail(out: Path, log: bytes | None) -> str:
    """The message of a run that ends half way, perhaps before it has a log."""
    try:
        with drive_folder(out, []):
            if log is not None:
                (out / "drive.mcap").write_bytes(log)
            raise UserError("a picture is damaged")
    except UserError as error:
        return str(error)


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


def test_no_recording_that_was_not_finished_stays_on_what_may_be_a_full_disk(tmp_path: Path):
    with suppress(UserError), drive_folder(tmp_path, []):
        (tmp_path / "drive.mcap").write_bytes(MCAP)
        (tmp_path / "drive.partial.rrd").write_bytes(RRD)
        raise UserError("the disk is full")
    assert names(tmp_path) == {"failed-drive.mcap"}


def test_the_message_of_a_failed_run_says_where_its_log_is_and_where_the_earlier_one(tmp_path: Path):
    an_earlier_drive(tmp_path)
    assert fail(tmp_path, None) == "a picture is damaged"
    assert fail(tmp_path, MCAP) == (
        f"a picture is damaged; what was written of this drive is {tmp_path / 'failed-drive.mcap'}, and "
        f"{tmp_path / 'drive.mcap'} is the earlier one again"
    )


def test_nobody_takes_what_a_first_run_left_that_failed_for_a_whole_drive(tmp_path: Path):
    out = tmp_path / "out"
    failed = out / "failed-drive.mcap"
    assert fail(out, None) == "a picture is damaged"
    assert fail(out, MCAP) == f"a picture is damaged; what was written of this drive is {failed}"
    assert names(out) == {"failed-drive.mcap"}
    with pytest.raises(UserError, match=f"no drive.mcap .*{re.escape(str(failed))} of a run that failed"):
        find_drives([out])
    assert find_drives([failed]) == {"failed-drive": failed.resolve()}
    with pytest.raises(UserError, match=f"name what it left of the drive: {re.escape(str(failed))}"):
        mcap_path(out)
    assert mcap_path(failed) == failed


def test_two_runs_do_not_write_to_one_folder(tmp_path: Path):
    with drive_folder(tmp_path, []), pytest.raises(UserError, match="another run is writing to this folder"):
        drive_folder(tmp_path, []).__enter__()
    with drive_folder(tmp_path, []):
        pass


@pytest.mark.parametrize(
    "name",
    ["drive.mcap", "drive.rrd", "summary.json", "drive.partial.rrd", "failed-drive.mcap", ".fcw.lock"],
)
def test_no_input_is_replaced_by_whatever_link_it_is_named(tmp_path: Path, name: str):
    an_earlier_drive(tmp_path)
    (tmp_path / name).touch()
    before = digests(tmp_path)
    link = tmp_path / "link"
    link.symlink_to(tmp_path / name)
    for read in (tmp_path / name, link):
        with pytest.raises(UserError, match=f"the new {name} would replace"):
            drive_folder(tmp_path, [read]).__enter__()
    link.unlink()
    assert digests(tmp_path) == before


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("drive.mcap", mcap_start("libmcap 1.3.0", "ros2")),
        ("drive.mcap", b"a text that names fcw 0.1.0"),
        ("drive.rrd", RRD + b"\x09other_appfcw"),
        ("summary.json", b"a text"),
        ("summary.json", b'["fcw"]'),
        ("summary.json", b'{"versions": {"pip": "25.0"}}'),
        ("drive.partial.rrd", b"a text"),
        ("failed-drive.mcap", mcap_start("libmcap 1.3.0", "ros2")),
        (".fcw.lock", b"a text"),
    ],
)
def test_another_programs_file_is_refused_and_stays(tmp_path: Path, name: str, content: bytes):
    an_earlier_drive(tmp_path)
    (tmp_path / name).write_bytes(content)
    before = digests(tmp_path)
    with pytest.raises(UserError, match=f"the {name} in it is no drive's of this program"):
        drive_folder(tmp_path, []).__enter__()
    assert digests(tmp_path) == before


def test_a_log_whose_writer_was_killed_is_ours(tmp_path: Path):
    (tmp_path / "drive.rrd").touch()  # killed before its first bytes
    log = tmp_path / "drive.mcap"
    McapSink(log).open(drive_header())
    torn = log.read_bytes()
    fail(tmp_path, MCAP)
    assert log.read_bytes() == torn
    with drive_folder(tmp_path, []):
        log.write_bytes(MCAP)
    assert names(tmp_path) == {"drive.mcap", "failed-drive.mcap"}


def test_folders_of_such_names_are_not_touched(tmp_path: Path):
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
    assert names(tmp_path / "out") == {"drive.mcap", "failed-drive.mcap"}


def test_earlier_folders_of_others_and_earlier_drives_that_are_read_stay(tmp_path: Path):
    for name in (".earlier-holiday", ".earlier-0a1b2c3d", "elsewhere"):
        (tmp_path / name).mkdir()
        an_earlier_drive(tmp_path / name)
    (tmp_path / ".earlier-0a1b2c3d" / "notes.txt").write_text("mine")
    (tmp_path / ".earlier-4e5f6a7b").symlink_to(tmp_path / "elsewhere")
    before = digests(tmp_path)
    read = tmp_path / ".earlier-0a1b2c3d" / "drive.mcap"
    with drive_folder(tmp_path, [read]):
        pass
    gone = {read.with_name("drive.rrd"), read.with_name("summary.json")}
    assert digests(tmp_path) == {path: digest for path, digest in before.items() if path not in gone}
