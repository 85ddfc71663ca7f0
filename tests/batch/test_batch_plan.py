"""What a batch still has to do, by what lies in its folder."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from fcw.batch.drives import find_batch_drives
from fcw.batch.identity import BatchOptions
from fcw.batch.ledger import MANIFEST_NAME, RECORD_NAME, Ledger, State, write_record
from fcw.batch.plan import Plan, plan_batch
from fcw.batch.tables import check_batch_folder, unfinished_drives, write_tables
from fcw.batch.work import run_task
from fcw.logs.names import MCAP_NAME
from fcw_viz.cli import main

OPTIONS = BatchOptions()
LOG = b"a log"


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
    """As if a worker had run all tasks, with logs of seven frames and one event."""
    for task in planned.tasks:
        task.folder.mkdir(parents=True, exist_ok=True)
        (task.folder / MCAP_NAME).write_bytes(LOG)
        write_record(replace(task.record(state, reason), frames=7, events=1, log_bytes=len(LOG)), task.folder)


def names(planned: Plan) -> list[str]:
    return [task.drive.name for task in planned.tasks]


def test_what_is_done_is_not_run_again(drives):
    assert names(plan(drives)) == ["a", "b"]
    end(plan(drives), State.DONE)
    again = plan(drives)
    assert names(again) == []
    assert [record.frames for record in again.records] == [7, 7]


def test_joined_files_are_known_by_all_of_them(tmp_path):
    day = tmp_path / "card" / "monday"
    day.mkdir(parents=True)
    (tmp_path / "card" / "calibration.yaml").write_text("a calibration")
    for name in ("DR_1.MP4", "DR_2.MP4"):
        (day / name).write_bytes(name.encode())

    def planned() -> Plan:
        found = find_batch_drives([tmp_path / "card"], join_files=True)
        return plan_batch(found, OPTIONS, Ledger(tmp_path / "out"))

    assert names(planned()) == ["monday"]
    end(planned(), State.DONE)
    day.rename(day.with_name("moved"))
    assert names(planned()) == []
    (tmp_path / "card" / "moved" / "DR_3.MP4").write_bytes(b"one more")
    assert names(planned()) == ["moved"]


def test_a_drive_is_known_by_its_content_under_any_name(drives):
    end(plan(drives), State.DONE)
    for path in sorted(drives.glob("a.*")):
        path.rename(drives / path.name.replace("a.", "c.", 1))
    again = plan(drives)
    assert names(again) == []
    assert {record.name: Path(record.source).name for record in again.records} == {"a": "c.mp4", "b": "b.mp4"}


def move_away(drives: Path) -> Path:
    """Another folder with the drives, of which a has another name there."""
    moved = drives.rename(drives.with_name("moved"))
    for path in sorted(moved.glob("a.*")):
        path.rename(moved / path.name.replace("a.", "c.", 1))
    return moved


def test_a_drive_that_was_moved_is_listed_where_it_lies_also_by_later_batches(drives):
    end(plan(drives), State.DONE)
    moved = move_away(drives)
    Ledger(moved.parent / "out").note_places(plan(moved).records)
    told = {name: record.source for name, record in Ledger(moved.parent / "out").finished.items()}
    assert told == {"a": str(moved / "c.mp4"), "b": str(moved / "b.mp4")}


def test_a_drive_that_was_moved_and_is_run_anew_counts_once(drives):
    end(plan(drives), State.DONE)
    moved = move_away(drives)
    assert names(plan(moved, replace(OPTIONS, detector="acf"))) == ["b", "a"]
    # Of two folders that are there each has its own, by whichever calibration.
    (moved / "c.calibration.yaml").write_text("another calibration")
    drives.mkdir()
    (drives / "a.mp4").write_bytes(b"a")
    assert names(plan(moved)) == ["c"]


def test_retry_runs_what_failed_also_when_it_was_moved_meanwhile(drives):
    end(plan(drives), State.FAILED, "a.mp4: several topics; name one with --topic")
    assert names(plan(move_away(drives), replace(OPTIONS, detector="acf"), retry=True)) == ["b", "c"]


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
        options = replace(OPTIONS, detector="acf")
    planned = plan(drives, options)
    assert [task.drive.source.name for task in planned.tasks if isinstance(task.drive.source, Path)] == (
        ["a.mp4", "b.mp4"] if changed == "options" else ["a.mp4"]
    )
    # Of the same pictures the new log takes the old one's place; a camera's next card has the same names.
    assert (names(planned)[0] == "a") == (changed != "content")


def test_drives_are_known_by_what_is_in_the_model_not_by_where_it_lies(drives, tmp_path):
    mine, moved = tmp_path / "mine.npz", tmp_path / "moved.npz"
    mine.write_bytes(b"a model")
    end(plan(drives, replace(OPTIONS, model=str(mine))), State.DONE)
    assert names(plan(drives)) == ["a", "b"]
    mine.rename(moved)
    assert names(plan(drives, replace(OPTIONS, model=str(moved)))) == []
    moved.write_bytes(b"another")
    assert names(plan(drives, replace(OPTIONS, model=str(moved)))) == ["a", "b"]


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


def test_of_a_drive_that_a_table_has_no_line_for_the_table_and_its_camera_are_named(tmp_path):
    for camera in ("A", "B"):
        (tmp_path / camera).mkdir()
        (tmp_path / camera / f"{camera.lower()}.mp4").write_bytes(camera.encode())
    (tmp_path / "roof.yaml").write_text("a calibration")
    table = tmp_path / "t2.csv"
    table.write_text("camera,calibration\nA,roof.yaml\n")
    planned = plan_batch(find_batch_drives([tmp_path], table), OPTIONS, Ledger(tmp_path / "out"))
    assert names(planned) == ["a"]
    (record,) = planned.records
    assert record.state is State.UNCALIBRATED
    assert record.reason.startswith(
        f"{table} has no line for camera B, which is the name of the drive's folder; add one, or make"
    )


def test_empty_files_have_failed_and_are_no_copies_of_each_other(drives):
    for name in ("x", "y"):
        (drives / f"{name}.mp4").touch()
        (drives / f"{name}.calibration.yaml").write_text("a calibration")
    planned = plan(drives)
    assert names(planned) == ["a", "b"]
    assert {record.name: (record.state, record.reason) for record in planned.records} == {
        name: (State.FAILED, f"{drives / name}.mp4: empty file; copy it again from where it was recorded")
        for name in ("x", "y")
    }


def test_a_link_to_nothing_is_listed_as_failed(drives):
    (drives / "gone.mp4").symlink_to(drives / "moved.mp4")
    (drives / "round.mp4").symlink_to(drives / "round.mp4")
    planned = plan(drives)
    assert names(planned) == ["a", "b"]
    told = {record.name: (record.state, record.reason) for record in planned.records}
    assert told["gone"] == (
        State.FAILED,
        f"{drives / 'gone.mp4'}: a link to {drives / 'moved.mp4'}, which is not there; "
        "mend the link, or remove it",
    )
    assert told["round"][0] is State.FAILED


def test_drives_of_another_folder_with_the_same_names_get_folders_of_their_own(drives):
    end(plan(drives), State.DONE)
    tomorrow = drives.parent / "tomorrow"
    tomorrow.mkdir()
    (tomorrow / "a.mp4").write_bytes(b"tomorrow's")
    (tomorrow / "a.calibration.yaml").write_text("a calibration")
    (task,) = plan(tomorrow).tasks
    assert task.drive.name.startswith("a-")
    end(plan(tomorrow), State.DONE)
    assert names(plan(tomorrow)) == names(plan(drives)) == []
    assert Ledger(drives.parent / "out").finished.keys() == {"a", "b", task.drive.name}
    # Of a new calibration there is one log still.
    (tomorrow / "a.calibration.yaml").write_text("another calibration")
    assert names(plan(tomorrow)) == [task.drive.name]


def test_a_copy_that_comes_later_is_the_copy(drives):
    end(plan(drives), State.DONE)
    (drives / "0.mp4").write_bytes(b"a")
    (drives / "0.calibration.yaml").write_text("a calibration")
    told = {record.name: record.state for record in plan(drives).records}
    assert told == {"0": State.DUPLICATE, "a": State.DONE, "b": State.DONE}


@pytest.mark.parametrize("done", [True, False])
def test_a_copy_names_its_drive_as_the_batchs_folder_does(drives, done):
    (drives / "A-a.mp4").write_bytes(b"A-a")
    (drives / "A-a.calibration.yaml").write_text("a calibration")
    end(plan(drives), State.DONE)
    # Files of two cards with one name are called after their folders, unless another drive is called that.
    cards = drives.parent / "cards"
    for card in ("A", "B"):
        (cards / card).mkdir(parents=True)
        (cards / card / "a.mp4").write_bytes(b"a" if done else b"new")
        (cards / card / "a.calibration.yaml").write_text("a calibration")
    (cards / "B" / "b.mp4").write_bytes(b"another b")
    (cards / "B" / "b.calibration.yaml").write_text("a calibration")
    planned = plan(cards)
    folders = {record.name for record in planned.records if record.state is State.DONE} | set(names(planned))
    (copy,) = [record for record in planned.records if record.state is State.DUPLICATE]
    original = copy.reason.removeprefix("the same file and calibration as ")
    assert original in folders
    assert (original == "a") == done


def test_no_two_drives_have_one_name(drives):
    end(plan(drives), State.DONE)
    for path in sorted(drives.glob("a.*")):
        path.rename(drives / path.name.replace("a.", "c.", 1))
    (drives / "a.mp4").write_bytes(b"bare")
    (drives / "manifest.json.mp4").write_bytes(b"a file's name")
    (drives / "manifest.json.calibration.yaml").write_text("a calibration")
    planned = plan(drives)
    (task,) = planned.tasks
    assert task.drive.name.startswith(f"{MANIFEST_NAME}-")
    states = {record.name: record.state for record in planned.records}
    assert len(states) == 3
    assert states.pop("a") is State.DONE
    assert states.pop("b") is State.DONE
    ((bare, state),) = states.items()
    assert (bare.startswith("a-"), state) == (True, State.UNCALIBRATED)


@pytest.mark.parametrize(("left", "events", "run"), [(b"", 1, 1), (None, 1, 1), (None, 0, 0), (LOG, 0, 0)])
def test_a_log_that_is_gone_or_torn_is_made_again_but_for_one_without_events(drives, left, events, run):
    planned = plan(drives)
    end(planned, State.DONE)
    task = planned.tasks[0]
    log = task.folder / MCAP_NAME
    log.unlink()
    if left is not None:
        log.write_bytes(left)
    write_record(replace(task.record(State.DONE), events=events, log_bytes=len(LOG)), task.folder)
    assert names(plan(drives)) == ["a"] * run


@pytest.mark.parametrize("mended", ["a.mp4", "a.calibration.yaml"])
def test_retry_runs_what_failed_also_when_it_was_mended(drives, mended):
    end(plan(drives), State.FAILED, "a.mp4: torn; repair it")
    (drives / mended).write_bytes(b"mended")
    assert names(plan(drives, retry=True)) == ["a", "b"]


def test_the_manifest_says_of_earlier_drives_too_what_ran(drives):
    first = plan(drives)
    end(first, State.DONE)
    ledger = Ledger(drives.parent / "out")
    ledger.write_manifest(ledger.finished.values(), first.identities)
    again = Ledger(drives.parent / "out")
    again.write_manifest(again.finished.values(), {})
    ran = [drive["ran"] for drive in json.loads((again.out / MANIFEST_NAME).read_text())["drives"]]
    assert [one["options"]["detector"] for one in ran] == ["net", "net"]


@pytest.mark.parametrize(
    "name", ["manifest.json", "events.parquet", "drives.parquet", "review.parquet", "fleet.html"]
)
def test_a_file_of_another_program_in_the_batchs_folder_is_refused_and_stays(drives, capsys, name):
    theirs = drives.parent / "out" / name
    theirs.parent.mkdir()
    theirs.write_text('{"mine": 1}')
    assert main(["batch", str(drives), "--out", str(theirs.parent)]) == 2
    assert name in capsys.readouterr().err
    assert list(theirs.parent.iterdir()) == [theirs]
    assert theirs.read_text() == '{"mine": 1}'


def test_a_line_break_in_a_name_breaks_no_line_of_what_is_printed(tmp_path, capsys):
    folder = tmp_path / "drives"
    folder.mkdir()
    (folder / "a\nb.mp4").write_bytes(b"a")
    assert main(["batch", str(folder), "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().out.splitlines()
    assert [line.split("  ")[0].strip() for line in told[1:3]] == [
        r"a\nb",
        rf"a\nb: make one with `fcw calibrate '{folder}/a\nb.mp4'` (a rough one, from the drive alone: "
        "--from-clip), or name one for all with --calibration",
    ]


@pytest.mark.parametrize("place", [b"\xe9.mp4", b"\xe9/a.mp4"], ids=["file", "folder"])
def test_a_name_that_is_no_utf_8_fails_alone_and_the_tables_are_written(tmp_path, capsys, place):
    source = tmp_path / "drives" / os.fsdecode(place)
    source.parent.mkdir(parents=True)
    source.write_bytes(b"a")
    out = tmp_path / "out"
    assert main(["batch", str(tmp_path / "drives"), "--out", str(out)]) == 2
    said = capsys.readouterr().out
    assert "(its name is no UTF-8); rename it" in said
    (drive,) = unfinished_drives(out)
    assert drive.state is State.FAILED
    assert "\\udce9" in drive.reason
    assert (out / "fleet.html").is_file()


def test_the_files_of_an_earlier_batch_may_be_replaced(tmp_path):
    Ledger(tmp_path).write_manifest([], {})
    write_tables(tmp_path, [])
    check_batch_folder(tmp_path)


def test_another_programs_batch_file_in_a_drives_folder_stays(drives):
    task = plan(drives).tasks[0]
    task.folder.mkdir()
    theirs = task.folder / RECORD_NAME
    theirs.write_text('{"mine": 1}')
    record = run_task(task)
    assert record.state is State.FAILED
    assert str(theirs) in record.reason
    assert theirs.read_text() == '{"mine": 1}'
