"""What tabs share: drives worst first, words kept at once, and everybody told."""

import errno
import shutil
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from review_drives import ADVISORY_S, QUIET_S, RATE_HZ, DriveWriting, header, result, tear, write_drive

from fcw.annotation.records import Judgement, Note, Verdict
from fcw.annotation.review import reference_to
from fcw.annotation.store import ReviewStore
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.session import DRIVES_KEPT, ReviewSession

WAIT_S = 120.0


@pytest.fixture
def log(drive_log: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(drive_log, tmp_path))


@pytest.fixture
def session(log: Path) -> Iterator[ReviewSession]:
    one = ReviewSession({"made": log}, "anna")
    yield one
    one.close()


@pytest.mark.slow
def test_the_folder_is_listed_worst_first_with_what_cannot_be_read_last(log: Path, tmp_path: Path):
    no_log = tmp_path / "no.mcap"
    no_log.write_bytes(b"something")
    quiet = write_drive(tmp_path / "quiet" / "drive.mcap", QUIET_S)
    torn = tear(log, tmp_path / "torn" / "drive.mcap")
    session = ReviewSession({"no": no_log, "quiet": quiet, "torn": torn, "made": log}, "anna")
    told = threading.Event()

    def is_whole() -> bool:
        return not session.unread and all(card.thumbnail or card.trouble for card in session.cards)

    session.join("tab", lambda: told.set() if is_whole() else None)
    session.start()
    assert told.wait(WAIT_S)
    cards = session.cards
    session.close()
    assert [card.name for card in cards][2:] == ["quiet", "no"]
    assert {card.name for card in cards[:2]} == {"made", "torn"}
    assert next(card for card in cards if card.name == "torn").complete is False
    assert "not a drive log" in cards[-1].trouble
    assert all(card.thumbnail for card in cards[:-1])


def test_a_verdict_is_on_the_disk_and_told_to_all(session: ReviewSession, log: Path):
    told: list[str] = []
    session.join("one", lambda: told.append("one"))
    session.join("two", lambda: told.append("two"))
    drive = session.open("one", "made")
    session.open("two", "made")
    session.say("made", Verdict(reference_to(drive.events[0]), Judgement.TOO_EARLY))
    assert sorted(told) == ["one", "two"]
    assert session.review("made").events[0].judgement is Judgement.TOO_EARLY
    assert b"too_early" in log.with_name("drive.review.anna.jsonl").read_bytes()


def test_taking_back_and_taking_that_back(session: ReviewSession):
    session.open("tab", "made")
    (entry,) = session.say("made", Note(3.0, "rain"))
    taken_back = session.take_back("made", entry.entry_id)
    assert session.review("made").review.notes == ()
    session.take_back("made", taken_back.entry_id)
    assert [one.said.text for one in session.review("made").review.notes] == ["rain"]


def test_what_another_program_says_comes_by_itself(session: ReviewSession, log: Path):
    told = threading.Event()
    session.open("tab", "made")
    session.join("tab", lambda: told.set() if session.review("made").review.notes else None)
    session.start()
    store = ReviewStore(DriveLog(log))
    store.add("bert", Note(3.0, "from elsewhere"))
    store.close()
    assert told.wait(WAIT_S)
    (note,) = session.review("made").review.notes
    assert note.person == "bert"


def test_drives_that_nobody_looks_at_are_let_go(log: Path, tmp_path: Path):
    count = DRIVES_KEPT + 3
    drives = {f"drive {k}": Path(shutil.copy(log, tmp_path / f"{k}.mcap")) for k in range(count)}
    session = ReviewSession(drives, "anna")
    first = session.open("stays", "drive 0")
    opened = [session.open("moves", name) for name in list(drives)[1:]]
    assert session.open("stays", "drive 0") is first
    assert session.open("moves", f"drive {count - 1}") is opened[-1]
    assert session.open("moves", "drive 1") is not opened[0]
    session.close()


def test_an_unknown_drive_is_named(session: ReviewSession):
    with pytest.raises(UserError, match="no drive 'other' here"):
        session.open("tab", "other")


def test_a_listener_that_fails_does_not_keep_the_others_from_hearing(session: ReviewSession):
    told = threading.Event()

    def fail() -> None:
        raise ValueError("broken tab")

    session.join("broken", fail)
    session.join("whole", told.set)
    session.open("whole", "made")
    session.say("made", Note(1.0, "x"))
    assert told.is_set()


def wait(session: ReviewSession, person: object, condition: Callable[[], bool]) -> None:
    """Until the session has told of a change after which a condition holds."""
    told = threading.Event()

    def look() -> None:
        if condition():
            told.set()

    session.join(person, look)
    look()
    assert told.wait(WAIT_S)
    session.leave(person)


@pytest.mark.slow
def test_a_growing_drive_and_new_ones_are_followed_and_those_that_go_leave_the_list(tmp_path: Path):
    writing = DriveWriting(tmp_path / "first" / "drive.mcap")
    writing.write(range(50))
    session = ReviewSession({"first": tmp_path / "first" / "drive.mcap"}, "anna", tmp_path)
    session.start()
    drive = session.open("tab", "first")
    assert drive.events == ()
    writing.write(range(50, 500))
    wait(session, "looks", lambda: len(session.current("first").events) >= 2)
    grown = session.current("first")
    assert grown.origin is drive.origin
    assert not grown.complete
    wait(session, "looks", lambda: len(session.cards[0].events) >= 2)
    writing.close()
    wait(session, "looks", lambda: session.current("first").complete)
    assert session.current("first").last_row == 499

    second = write_drive(tmp_path / "second" / "drive.mcap", QUIET_S)
    wait(session, "looks", lambda: [card.name for card in session.cards] == ["first", "second"])
    second.unlink()
    wait(session, "looks", lambda: [card.name for card in session.cards] == ["first"])
    session.close()


def test_nothing_is_kept_of_a_log_that_is_another_by_now(session: ReviewSession, log: Path, tmp_path: Path):
    drive = session.open("tab", "made")
    write_drive(log, QUIET_S)  # as `fcw run` into the same folder does
    with pytest.raises(UserError, match="the log was replaced or deleted while it was open here"):
        session.say("made", Verdict(reference_to(drive.events[0]), Judgement.RIGHT))
    session.start()
    wait(session, "looks", lambda: session.current("made").origin is not drive.origin)
    assert session.current("made").events == ()
    session.say("made", Note(1.0, "of the new one"))
    log.unlink()
    with pytest.raises(UserError, match="replaced or deleted"):
        session.say("made", Note(1.0, "of none"))


def test_a_log_that_cannot_be_read_any_more_takes_nothing_from_who_has_it_open(
    session: ReviewSession, log: Path
):
    drive = session.open("tab", "made")
    log.write_bytes(b"a run that has just begun")
    with pytest.raises(UserError, match="not a drive log"):
        session.open("another tab", "made")
    assert session.current("made") is drive
    assert len(session.review("made").events) == len(drive.events)


def test_who_looks_at_a_drive_that_is_another_by_now_judges_none_of_its_events(
    session: ReviewSession, log: Path
):
    place = Place(session)
    place.enter(session.open(place, "made"), 0, None)
    told = threading.Event()
    session.join(place, told.set)
    log.unlink()
    sink = McapSink(log)
    sink.open(header())
    for index in range(round(ADVISORY_S * RATE_HZ), round((ADVISORY_S + 1) * RATE_HZ)):
        sink.write(result(index), ())
    sink.close()
    session.open("another tab", "made")
    assert told.is_set()
    assert place.judged is not None
    assert place.judged.event == place.opened.events[0]  # its own, until it follows
    with pytest.raises(UserError, match="the log was replaced"):
        Annotating(place, lambda title, text: None).judge(Judgement.FALSE)
    assert session.review("made").review.verdicts == ()


def test_a_file_that_raises_what_nobody_foresaw_does_not_end_the_list(
    log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    damaged, opens = tmp_path / "damaged.mcap", Drive.open

    def raises(name: str, path: Path) -> Drive:
        if path == damaged:
            raise OSError(errno.EINVAL, "Invalid argument")  # of a seek to where a flipped bit leads
        return opens(name, path)

    shutil.copy(log, damaged)
    monkeypatch.setattr(Drive, "open", raises)
    session = ReviewSession({"damaged": damaged, "made": log}, "anna")
    session.start()
    wait(session, "looks", lambda: not session.unread)
    session.close()
    whole, trouble = session.cards
    assert whole.name == "made"
    assert "cannot be read; see the terminal" in trouble.trouble


def test_the_list_counts_what_others_say_of_drives_that_nobody_has_open_here(
    session: ReviewSession, log: Path
):
    session.start()
    wait(session, "looks", lambda: not session.unread)
    store = ReviewStore(DriveLog(log))
    store.add("bert", Verdict(reference_to(session.cards[0].events[0]), Judgement.FALSE))
    store.close()
    wait(session, "looks", lambda: session.cards[0].judged[0].judgement is Judgement.FALSE)
