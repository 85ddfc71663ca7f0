"""`fcw export` says in clear words what it cannot do, and leaves nothing half done."""

import os
import subprocess
import sys

import pandas as pd
import pytest
from marked_drives import FRAMES, export

from fcw.logs.mcap.reader import DriveLog

WRONG = [
    (("--format", "mp4", "--events"), "--events --format mp4: events are a table; choose csv or parquet"),
    (("--format", "csv", "--no-overlay"), "only an mp4 has the overlay"),
    (("--format", "kitti", "--pictures"), "--pictures --format kitti: only for coco"),
    (("--format", "csv", "--every", "3"), "--every 3 --format csv: only for coco"),
    (("--format", "coco", "--every", "0"), "--every 0: expected a whole number of at least 1"),
    (("--format", "csv", "--between", "3", "1"), "--between 3 1: expected two times in seconds"),
    (("--format", "csv", "--between", "9", "12"), "has no frame there; its frames are from 0 to 2.36 s"),
]


@pytest.mark.parametrize(("options", "message"), WRONG)
def test_options_that_make_no_sense_give_one_message(drives, tmp_path, capsys, options, message):
    assert export(drives / "monday", *options, "--out", tmp_path / "out.x") == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_another_format_is_refused(drives, tmp_path, capsys):
    assert export(drives / "monday", "--format", "csv", "--out", tmp_path / "e.parquet") == 2
    said = capsys.readouterr().err
    assert "e.parquet --format csv: .parquet is for parquet; expected a folder or .csv" in said
    assert list(tmp_path.iterdir()) == []
    assert export(drives / "monday", "--format", "mot", "--out", tmp_path / "e.txt") == 0


def test_an_unknown_format_is_refused_with_the_known_ones(drives, tmp_path, capsys):
    with pytest.raises(SystemExit) as exit_info:
        export(drives / "monday", "--format", "avi", "--out", tmp_path / "out.avi")
    assert exit_info.value.code == 2
    message = " ".join(capsys.readouterr().err.split())
    assert "avi" in message
    assert "'parquet'" in message


def test_no_drive_and_a_folder_without_one_are_named(tmp_path, capsys):
    assert export("--format", "csv", "--out", tmp_path / "t.csv") == 2
    assert "no drive given" in capsys.readouterr().err
    assert export(tmp_path, "--format", "csv", "--out", tmp_path / "t.csv") == 2
    assert f"{tmp_path}: no drive.mcap in this folder or below it" in capsys.readouterr().err


def test_a_file_of_another_kind_is_named(tmp_path, capsys):
    (tmp_path / "notes.mcap").write_text("no log")
    assert export(tmp_path / "notes.mcap", "--format", "csv", "--out", tmp_path / "t.csv") == 2
    assert "notes.mcap: not a drive log" in capsys.readouterr().err


def test_an_existing_file_is_replaced_only_with_overwrite(drives, tmp_path, capsys):
    out = tmp_path / "t.csv"
    out.write_text("mine")
    assert export(drives / "monday", "--format", "csv", "--out", out) == 2
    message = f"{out}: exists already; choose another name, or replace it with --overwrite"
    assert message in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert export(drives / "monday", "--format", "csv", "--out", out, "--overwrite") == 0
    assert len(pd.read_csv(out)) == FRAMES


def test_a_drive_is_never_written_over_itself(drives, capsys):
    path = drives / "monday" / "drive.mcap"
    before = path.read_bytes()
    assert export(path, "--format", "mcap", "--out", path, "--overwrite") == 2
    assert "this is the drive itself" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_a_drives_source_is_never_replaced_but_an_earlier_export_of_that_name_is(drives, tmp_path, capsys):
    log = drives / "monday" / "drive.mcap"
    out = tmp_path / DriveLog(log).header.source
    out.write_text("the video")
    made_s = log.stat().st_mtime
    os.utime(out, (made_s - 60, made_s - 60))
    export_it = [log, "--format", "mp4", "--no-overlay", "--out", out, "--overwrite"]
    assert export(*export_it) == 2
    assert "it has the name of the drive's source" in capsys.readouterr().err
    assert out.read_text() == "the video"
    os.utime(out, (made_s + 60, made_s + 60))
    assert export(*export_it) == 0
    assert out.read_bytes() != b"the video"


def test_a_calibration_beside_exported_pictures_is_replaced_only_with_overwrite(drives, tmp_path, capsys):
    theirs = tmp_path / "calibration" / "monday.yaml"
    theirs.parent.mkdir()
    theirs.write_text("mine")
    out = tmp_path / "labels.json"
    assert export(drives / "monday", "--format", "coco", "--pictures", "--out", out) == 2
    assert f"{theirs}: exists already" in capsys.readouterr().err
    assert theirs.read_text() == "mine"


def test_several_drives_do_not_go_into_one_video(drives, tmp_path, capsys):
    assert export(drives, "--format", "mp4", "--out", tmp_path / "out.mp4") == 2
    assert "2 drives need one file each; give a folder" in capsys.readouterr().err


def test_an_out_folder_that_cannot_be_created_is_named(drives, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert export(drives / "monday", "--format", "mot", "--out", tmp_path / "file" / "out") == 2
    assert "cannot make this folder" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("form", ["csv", "mp4", "mcap"])  # test_rerun_log has a full disk of its own
def test_a_full_disk_is_reported_and_leaves_nothing(drives, tmp_path, form: str):
    resource = pytest.importorskip("resource", reason="needs a limit on the size of files, as POSIX has it")
    out = tmp_path / f"out.{form}"
    arguments = ["export", str(drives / "monday"), "--format", form, "--out", str(out)]
    process = subprocess.run(
        [sys.executable, "-m", "fcw_viz.cli", *arguments],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4_000, 4_000)),
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert process.returncode == 2, process.stderr
    assert f"fcw: {out}: cannot " in process.stderr
    assert "Traceback" not in process.stderr
    assert process.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("form", ["csv", "kitti", "mp4", "mcap", "rrd"])
def test_a_missing_folder_is_named(drives, tmp_path, capsys, form: str):
    out = tmp_path / "nowhere" / f"out.{form}"
    assert export(drives / "monday", "--format", form, "--out", out) == 2
    assert f"{out}: cannot write this file" in capsys.readouterr().err
