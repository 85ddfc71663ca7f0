"""The files beside a log: kills, full disks, damage, versions, two programs, several people."""

import json
import re
import resource
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from annotation_helpers import WARNED, frame_result, sayings, warned_drive, write_log
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fcw.annotation.records import Judgement, Note, Reason, Verdict
from fcw.annotation.review import Review
from fcw.annotation.store import ReviewStore, read_review, review_files, review_path
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog

RIGHT, FALSE = Verdict(WARNED, Judgement.RIGHT), Verdict(WARNED, Judgement.FALSE, Reason.ONCOMING, "a bus")


@pytest.fixture(scope="session")
def warned_log(tmp_path_factory):
    return warned_drive(tmp_path_factory.mktemp("warned") / "drive.mcap").path


@pytest.fixture
def log(tmp_path, warned_log):
    return DriveLog(Path(shutil.copy(warned_log, tmp_path / "drive.mcap")))


def said(review):
    return [(entry.person, entry.said) for entry in review.entries]


def filled(log, person="Ann"):
    """A file with three entries, and what they were."""
    store = ReviewStore(log)
    notes = tuple(Note(float(number), f"note {number}") for number in range(3))
    for note in notes:
        store.add(person, note)
    store.close()
    return review_path(log.path, person), notes


@contextmanager
def disk_full_at(size):
    """No file of this process can grow beyond a size."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def test_it_lies_beside_the_log_under_the_persons_name(tmp_path):
    assert review_path(tmp_path / "drive.mcap", "Ann") == tmp_path / "drive.review.Ann.jsonl"
    assert review_path(tmp_path / "a.b.mcap", "Jörg / QA ../x").name == "a.b.review.Jörg_QA_x.jsonl"


@pytest.mark.parametrize("name", ["", "  ", " Ann", "a\nb", "x" * 41])
def test_an_impossible_name_is_refused(log, name):
    with pytest.raises(UserError, match="expected the name of a person, of 1 to 40 letters"):
        ReviewStore(log).add(name, RIGHT)


def test_looking_leaves_nothing_behind_and_saying_something_leaves_the_log_as_it_was(log):
    before = log.path.read_bytes(), log.path.stat().st_mtime_ns
    store = ReviewStore(log)
    assert store.review == Review()
    store.close()
    assert [path.name for path in log.path.parent.iterdir()] == ["drive.mcap"]
    filled(log)
    assert (log.path.read_bytes(), log.path.stat().st_mtime_ns) == before


def test_a_line_is_plain_json_with_id_time_person_and_what_was_said(log):
    store = ReviewStore(log)
    entry = store.add("Ann", FALSE)
    header, line = map(json.loads, review_path(log.path, "Ann").read_text().splitlines())
    assert header["fcw_review_version"] == 1
    assert line == {
        "id": entry.entry_id,
        "time": entry.time,
        "person": "Ann",
        "said": "Verdict",
        "event": {"kind": "warning", "track_id": 7, "start_s": 1.0, "end_s": 1.9},
        "judgement": "false",
        "reason": "oncoming",
        "text": "a bus",
    }
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z", entry.time)


@examples(10)
@given(st.lists(st.tuples(st.sampled_from(["Ann", "Bo"]), sayings), max_size=6))
def test_the_state_is_a_replay_of_the_files(warned_log, tmp_path_factory, steps):
    log = DriveLog(Path(shutil.copy(warned_log, tmp_path_factory.mktemp("replay") / "drive.mcap")))
    store = ReviewStore(log)
    for person, what in steps:
        store.add(person, what)
    replayed, troubles = read_review(log)
    assert replayed == store.review
    assert said(replayed) == steps
    assert troubles == ()
    store.close()


# Kills and disks


def test_a_killed_program_loses_nothing_that_counted(log):
    """It says on its standard output what counts, and is killed in the middle of going on."""
    program = """
import sys
from pathlib import Path
from fcw.annotation.records import Note
from fcw.annotation.store import ReviewStore
from fcw.logs.mcap.reader import DriveLog
store = ReviewStore(DriveLog(Path(sys.argv[1])))
for number in range(100000):
    print(store.add("Ann", Note(number, "note")).entry_id, flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", program, str(log.path)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        counted = [process.stdout.readline().decode().strip() for _ in range(20)]
        process.send_signal(signal.SIGKILL)
        counted += process.stdout.read().decode().split()
        assert process.wait() == -signal.SIGKILL
    store = ReviewStore(log)
    assert store.troubles == ()
    kept = [entry.entry_id for entry in store.review.entries]
    # The last one may be on the disk without the program having come to say so.
    assert kept[: len(counted)] == counted
    assert len(kept) <= len(counted) + 1
    store.add("Ann", RIGHT)
    assert said(read_review(log)[0])[-1] == ("Ann", RIGHT)


@pytest.mark.slow
def test_torn_anywhere_it_keeps_every_whole_line_and_goes_on(log):
    path, notes = filled(log)
    data = path.read_bytes()
    ends = [at for at in range(1, len(data) + 1) if data[at - 1 : at] == b"\n"]
    for length in range(len(data) + 1):
        path.write_bytes(data[:length])
        whole = max(sum(end <= length for end in ends) - 1, 0)
        review, troubles = read_review(log)
        assert (said(review), troubles) == ([("Ann", note) for note in notes[:whole]], ())
    # Every write waits for the disk: going on is tried around the ends of lines and once within each.
    for length in {0, 10, *(end + off for end in ends for off in (-1, 0, 1, 30) if end + off <= len(data))}:
        path.write_bytes(data[:length])
        whole = max(sum(end <= length for end in ends) - 1, 0)
        store = ReviewStore(log)
        store.add("Ann", RIGHT)
        store.close()
        expected = [("Ann", what) for what in (*notes[:whole], RIGHT)]
        assert (said(read_review(log)[0]), read_review(log)[1]) == (expected, ())


def test_on_a_full_disk_a_word_is_refused_whole_and_the_next_one_counts(log):
    store = ReviewStore(log)
    store.add("Ann", RIGHT)
    path = review_path(log.path, "Ann")
    data, before = path.read_bytes(), store.review
    with (
        disk_full_at(len(data) + 30),
        pytest.raises(UserError, match=r"cannot be written \(File too large\)"),
    ):
        store.add("Ann", FALSE)
    assert (path.read_bytes(), store.review) == (data, before)
    store.add("Ann", FALSE)
    assert said(read_review(log)[0]) == [("Ann", RIGHT), ("Ann", FALSE)]


def test_a_folder_that_cannot_be_written_is_named(log, monkeypatch):
    store = ReviewStore(log)
    shutil.rmtree(log.path.parent)
    with pytest.raises(
        UserError, match=r"drive\.review\.Ann\.jsonl: cannot be written .*nothing was changed"
    ):
        store.add("Ann", RIGHT)
    assert store.review == Review()


# Damage, versions, other logs


def test_a_damaged_line_is_told_and_all_others_count(log):
    path, notes = filled(log)
    lines = path.read_text().splitlines(keepends=True)
    lines[2] = lines[2][:20] + "\n"
    path.write_text("".join(lines))
    store = ReviewStore(log)
    assert [what for _, what in said(store.review)] == [notes[0], notes[2]]
    assert len(store.troubles) == 1
    assert store.troubles[0].startswith(f"{path}: line 3 is damaged and left out")
    store.add("Ann", RIGHT)
    assert path.read_text().startswith("".join(lines))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('"said":"Note"', '"said":"Song"', "'Song' is no said of this program"),
        ('"time_s":1.0', '"time_s":NaN', "expected a moment of the drive"),
        ('"time_s":1.0', '"time_s":1e308', "expected a moment of the drive"),
        ('"time_s":1.0', '"time_s":"soon"', "'soon' is not of type float"),
        ('"time_s":1.0,', "", "time_s"),
        ('"person":"Ann"', '"person":3', "3 is not of type str"),
        ('"time_s":1.0', '"time_s":' + "9" * 400, "has 400 digits"),
        ('"time_s":1.0', '"time_s":' + "[" * 5000, "nested too deeply"),
        ('"time_s":1.0', r'"time_s":"\ud800"', "incomplete character"),
    ],
)
def test_a_line_that_says_what_cannot_be_said_is_damaged_too(log, old, new, reason):
    path, _ = filled(log)
    header, first, second, third = path.read_text().splitlines(keepends=True)
    assert old in second
    path.write_text(header + first + second.replace(old, new) + third)
    review, (trouble,) = read_review(log)
    assert len(review.entries) == 2
    assert "line 3 is damaged" in trouble
    assert reason in trouble


def test_a_time_that_would_not_sort_is_damage(log):
    path, _ = filled(log)
    path.write_text(re.sub(r"(\.\d{6})Z", "Z", path.read_text()))
    review, troubles = read_review(log)
    assert (review, len(troubles)) == (Review(), 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("my notes, no line feed", "not a review of fcw, left out"),
        ("my notes\n", "not a review of fcw, left out"),
        ('{"fcw_review_version":2}\n', "fcw_review_version is 2, this program reads 1"),
    ],
)
def test_a_file_that_is_no_review_or_of_another_version_is_told_and_left_alone(log, text, message):
    path = review_path(log.path, "Ann")
    path.write_text(text)
    store = ReviewStore(log)
    assert message in store.troubles[0]
    with pytest.raises(UserError, match=r"move it away to add something about this drive") as error:
        store.add("Ann", RIGHT)
    assert str(path) in str(error.value)
    assert path.read_text() == text
    store.add("Bo", RIGHT)
    assert said(store.review) == [("Bo", RIGHT)]


def test_that_the_drive_was_run_anew_since_is_told(log):
    path, _ = filled(log)
    write_log(log.path, [frame_result(0)], detector="acf-full")
    store = ReviewStore(DriveLog(log.path))
    assert store.troubles[0].startswith(f"{path}: was written for an earlier run of this drive")
    assert len(store.review.entries) == 3


# Several people and programs


def test_all_peoples_files_are_read_and_a_copied_one_counts_once(log):
    store = ReviewStore(log)
    store.add("Ann", RIGHT)
    store.add("Bo", FALSE)
    store.close()
    shutil.copy(review_path(log.path, "Bo"), review_path(log.path, "Bo (copy)"))
    assert [path.name for path in review_files(log.path)] == [
        "drive.review.Ann.jsonl",
        "drive.review.Bo.jsonl",
        "drive.review.Bo_copy_.jsonl",
    ]
    assert said(read_review(log)[0]) == [("Ann", RIGHT), ("Bo", FALSE)]


def test_another_logs_review_in_the_same_folder_is_not_this_ones(log):
    shutil.copy(log.path, log.path.with_name("drive2.mcap"))
    filled(log)
    assert read_review(DriveLog(log.path.with_name("drive2.mcap")))[0] == Review()


def test_a_second_program_cannot_write_as_the_same_person_but_as_another_and_sees_the_first_ones_words(log):
    first, second = ReviewStore(log), ReviewStore(log)
    first.add("Ann", RIGHT)
    with pytest.raises(UserError, match="another `fcw review` writes to this file"):
        second.add("Ann", FALSE)
    assert second.refresh()
    assert said(second.review) == [("Ann", RIGHT)]
    assert not second.refresh()
    second.add("Bo", FALSE)
    assert first.refresh()
    assert said(first.review) == said(second.review) == [("Ann", RIGHT), ("Bo", FALSE)]
    first.close()
    second.refresh()
    second.add("Ann", Note(1, "now"))
    assert said(second.review)[-1] == ("Ann", Note(1, "now"))
    second.close()


def test_what_another_takes_away_is_gone_and_a_folder_that_is_gone_is_told(log):
    path, _ = filled(log, "Bo")
    store = ReviewStore(log)
    path.unlink()
    assert store.refresh()
    assert store.review == Review()
    shutil.rmtree(log.path.parent)
    with pytest.raises(UserError, match="cannot read this folder of a drive"):
        store.refresh()


def test_what_was_seen_is_before_what_was_answered_though_a_clock_is_wrong(log):
    path, _ = filled(log)
    path.write_text(re.sub(r'"time":"20\d\d', '"time":"2099', path.read_text()))
    store = ReviewStore(log)
    store.add("Bo", RIGHT)
    assert said(store.review)[-1] == ("Bo", RIGHT)


def test_one_takes_back_ones_own_words_once_and_that_too(log):
    store = ReviewStore(log)
    verdict = store.add("Ann", RIGHT)
    with pytest.raises(UserError, match="only Ann can take this back"):
        store.take_back("Bo", verdict.entry_id)
    undo = store.take_back("Ann", verdict.entry_id)
    assert store.review.verdicts == ()
    with pytest.raises(UserError, match="taken back already"):
        store.take_back("Ann", verdict.entry_id)
    store.take_back("Ann", undo.entry_id)
    assert store.review.verdicts == (verdict,)
    assert review_files(log.path) == (review_path(log.path, "Ann"),)


def test_after_closing_nothing_is_said(log):
    store = ReviewStore(log)
    store.close()
    with pytest.raises(UserError, match=r"the review is closed; start `fcw review` again"):
        store.add("Ann", RIGHT)
