"""The journal on the disk: kills, full disks, damage, versions, two servers."""

import json
import re
import resource
import subprocess
import sys
from contextlib import contextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st
from session_helpers import SIZE, edits, open_session, said, save_path

from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.document.history import Action, Event, History
from fcw_viz.calibrate_app.document.journal import Journal, journal_path, read_journal

EVENTS = (
    Event("2026-11-20T10:00:00+01:00", "tab 1", Action.STEP, (AddMark(600.25, 461.0625, 3, 4.0),)),
    Event("2026-11-20T10:00:01+01:00", "tab 2", Action.STEP, (AddMark(600, 428), SetHeight(1.225))),
    Event("2026-11-20T10:00:02+01:00", "tab 1", Action.UNDO),
    Event("2026-11-20T10:00:03+01:00", "tab ü", Action.REDO),
)


def opened(path, size=SIZE) -> Journal:
    return Journal.open(path, "drive.mp4", Document(size), None)[0]


def histories(events=EVENTS) -> list[History]:
    """The history before the first event and after each."""
    result = [History((Document(SIZE),))]
    for event in events:
        result.append(result[-1].after(event))
    return result


@pytest.fixture
def journal_file(tmp_path):
    path = tmp_path / "drive.calibration.work.jsonl"
    journal = opened(path)
    for event in EVENTS:
        journal.add(event)
    journal.close()
    return path


@contextmanager
def disk_full_at(size):
    """No file of this process can grow beyond a size."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def test_it_lies_beside_the_calibration_file(tmp_path):
    assert journal_path(save_path(tmp_path)) == tmp_path / "drive.calibration.work.jsonl"


def test_read_back_it_gives_the_same_history(journal_file):
    content = read_journal(journal_file)
    assert content is not None
    assert content.history == histories()[-1]
    assert content.event_count == len(EVENTS)
    assert not content.torn


def test_torn_anywhere_it_keeps_every_whole_step_and_goes_on(journal_file):
    data = journal_file.read_bytes()
    expected = histories()
    ends = [at for at in range(1, len(data) + 1) if data[at - 1 : at] == b"\n"]
    for length in range(len(data) + 1):
        journal_file.write_bytes(data[:length])
        lines = sum(end <= length for end in ends)
        content = read_journal(journal_file)
        if lines == 0:
            assert content is None
            continue
        assert content is not None
        assert content.history == expected[lines - 1]
        assert content.torn == (length not in ends)
    # Every write waits for the disk: going on is tried around the ends of lines and once within each.
    for length in {0, 10, *(end + off for end in ends for off in (-1, 0, 1, 30) if end + off <= len(data))}:
        journal_file.write_bytes(data[:length])
        whole = max(sum(end <= length for end in ends) - 1, 0)
        journal = opened(journal_file)
        step = Event("2026-11-20T11:00:00+01:00", "tab 1", Action.STEP, (SetHeight(1.5),))
        journal.add(step)
        journal.close()
        content = read_journal(journal_file)
        assert content is not None
        assert content.history == expected[whole].after(step)


def test_a_last_line_of_rubbish_counts_as_torn(journal_file):
    with journal_file.open("ab") as file:
        file.write(b"\0\0\0\0\n")
    journal = opened(journal_file)
    assert journal.content.torn
    assert journal.content.history == histories()[-1]
    journal.close()


def test_a_damaged_middle_line_is_named(journal_file):
    lines = journal_file.read_text().splitlines(keepends=True)
    lines[2] = lines[2][:20] + "\n"
    journal_file.write_text("".join(lines))
    with pytest.raises(UserError, match=re.escape(f"{journal_file}: line 3 is damaged")) as error:
        opened(journal_file)
    assert "delete that line and all after it" in str(error.value)


def test_an_unknown_edit_in_the_middle_is_damage_too(journal_file):
    lines = journal_file.read_text().splitlines(keepends=True)
    lines[1] = lines[1].replace("AddMark", "SetSail")
    journal_file.write_text("".join(lines))
    with pytest.raises(UserError, match=r"line 2 is damaged .*SetSail"):
        opened(journal_file)


def test_another_version_is_told(journal_file):
    journal_file.write_text(journal_file.read_text().replace('journal_version":1', 'journal_version":2', 1))
    with pytest.raises(UserError, match=r"is 2, this program reads 1; .*delete the file to start anew"):
        opened(journal_file)


def test_another_image_size_is_told(journal_file):
    with pytest.raises(UserError, match=r"clicked in pictures of 1280x720, these are 640x360; .*--save FILE"):
        opened(journal_file, ImageSize(640, 360))


def test_a_file_that_is_no_journal_is_left_alone(tmp_path):
    path = tmp_path / "drive.calibration.work.jsonl"
    path.write_text("my notes, no line feed")
    with pytest.raises(UserError, match="line 1 is damaged"):
        opened(path)
    assert path.read_text() == "my notes, no line feed"


def test_two_pages_on_one_journal_are_kept_apart_and_the_second_is_told_where_the_first_is(tmp_path):
    session = open_session(tmp_path)
    session.announce("http://127.0.0.1:8080")
    with pytest.raises(UserError, match=r"page at http://127\.0\.0\.1:8080/\S+ is already working") as error:
        open_session(tmp_path)
    assert "--save FILE" in str(error.value)
    session.close()
    open_session(tmp_path).close()


def test_a_folder_that_cannot_be_written_is_named_with_the_mend(tmp_path):
    with pytest.raises(UserError, match=r"work\.jsonl: cannot keep your work there .*`--save FILE`"):
        open_session(tmp_path / "nowhere")


def test_nothing_is_left_behind_where_nothing_was_done(tmp_path):
    open_session(tmp_path).close()
    assert list(tmp_path.iterdir()) == []


def test_on_a_full_disk_a_step_is_refused_whole_and_the_next_one_works(tmp_path):
    session = open_session(tmp_path)
    path = journal_path(save_path(tmp_path))
    person = session.join(lambda state: None)
    session.apply(person, AddMark(600, 461, 0, 4))
    before, data = session.state, path.read_bytes()
    with (
        disk_full_at(len(data) + 30),
        pytest.raises(UserError, match=r"cannot be written \(File too large\)"),
    ):
        session.apply(person, AddMark(600, 428, 0, 5))
    assert session.state.document == before.document
    assert path.read_bytes() == data
    session.apply(person, AddMark(600, 428, 0, 5))
    content = read_journal(path)
    assert content is not None
    assert content.history.document == session.state.document == said((4, 461), (5, 428))


def test_a_killed_server_loses_no_click(tmp_path):
    program = """
import os, signal, sys
from pathlib import Path
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.edits import AddMark
from fcw_viz.calibrate_app.session import CalibrationSession
folder = Path(sys.argv[1])
save_path = folder / "drive.calibration.yaml"
session = CalibrationSession.open(folder / "drive.mp4", ImageSize(1280, 720), save_path)
person = session.join(lambda state: None)
for distance_m, row_px in ((4, 461), (5, 428), (7, 383)):
    session.apply(person, AddMark(600.0, row_px, 0, distance_m))
os.kill(os.getpid(), signal.SIGKILL)
"""
    killed = subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=False)
    assert killed.returncode < 0
    session = open_session(tmp_path)
    assert session.state.document == said((4, 461), (5, 428), (7, 383))
    assert "3 steps" in session.state.notice


def test_a_line_is_plain_json_with_time_person_and_edits(journal_file):
    line = json.loads(journal_file.read_text().splitlines()[1])
    assert (line["time"], line["person"]) == ("2026-11-20T10:00:00+01:00", "tab 1")
    assert line["edits"] == [
        {"edit": "AddMark", "column_px": 600.25, "row_px": 461.0625, "frame": 3, "distance_m": 4.0}
    ]


@given(st.lists(st.sampled_from(list(Action)), max_size=40), st.data())
def test_undo_and_redo_walk_along_the_steps(actions, data):
    """Against the textbook's two stacks."""
    history = History((Document(SIZE),))
    done, undone = [history.document], []
    for action in actions:
        event = Event("", "", action, (data.draw(edits),) if action is Action.STEP else ())
        try:
            history = history.after(event)
        except UserError:
            assert action is Action.STEP or not (len(done) > 1 if action is Action.UNDO else undone)
            continue
        if action is Action.STEP:
            done, undone = [*done, event.edits[0].apply(done[-1])], []
        elif action is Action.UNDO:
            undone.append(done.pop())
        else:
            done.append(undone.pop())
        assert history.document == done[-1]
        assert (history.can_undo, history.can_redo) == (len(done) > 1, bool(undone))
