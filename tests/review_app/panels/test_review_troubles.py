"""A damaged review file, or one of an earlier run, is shown to the reviewer in words."""

import shutil
from pathlib import Path

import pytest

from fcw.annotation.records import EventReference, Judgement, Note, Verdict
from fcw.annotation.store import ReviewStore, review_path
from fcw.logs.mcap.reader import DriveLog
from fcw_viz.review_app.drive_card import read_card
from fcw_viz.review_app.panels.folder_list import folder_html
from fcw_viz.review_app.panels.troubles import MOST_TOLD, troubles_html
from fcw_viz.review_app.session import ReviewSession

GONE = EventReference("warning", 7, 300.0, 301.0)
"""An event that the made drive does not have."""


@pytest.fixture
def log(drive_log: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(drive_log, tmp_path))


def say(log: Path, person: str, *said: Note | Verdict) -> Path:
    store = ReviewStore(DriveLog(log))
    store.add_all(person, said)
    store.close()
    return review_path(log, person)


@pytest.mark.slow
def test_a_damaged_line_stands_in_the_list_and_in_the_drive(log: Path):
    path = say(log, "bert", Note(3.0, "rain"), Note(4.0, "sun"))
    path.write_text(path.read_text().replace('"time_s":3.0', '"time_s":"soon"'))
    session = ReviewSession({"made": log}, "anna")
    session.open("tab", "made")
    (trouble,) = session.review("made").troubles
    session.close()
    assert f"{path}: line 2 is damaged and left out" in trouble
    card = read_card("made", log)
    assert card.review_troubles == (trouble,)
    listed = folder_html("drives", [card], 0, 1000.0)
    for html in (listed, troubles_html(card.review_troubles)):
        assert "Problems in the review files" in html
        assert f"{path}: line 2 is damaged" in html


def test_a_review_of_an_earlier_run_and_its_lost_verdicts_are_told(log: Path):
    path = say(log, "bert", Verdict(GONE, Judgement.RIGHT))
    header, entry = path.read_text().splitlines()
    path.write_text(header.replace('"log":"', '"log":"0') + "\n" + entry + "\n")
    card = read_card("made", log)
    of_the_file, of_the_verdict = card.review_troubles
    assert of_the_file.startswith(f"{path}: was written for an earlier run of this drive")
    assert of_the_verdict.startswith("1 verdict is about an event that this log does not have")


def test_whole_reviews_give_no_problem(log: Path):
    say(log, "bert", Note(3.0, "rain"))
    card = read_card("made", log)
    assert card.review_troubles == ()
    assert "Problems" not in folder_html("drives", [card], 0, 1000.0)


def test_of_many_problems_the_first_and_a_count_are_told():
    html = troubles_html([f"file: line {number} <b>" for number in range(MOST_TOLD + 3)])
    assert html.count("file: line") == MOST_TOLD
    assert "and 3 more" in html
    assert "&lt;b&gt;" in html
