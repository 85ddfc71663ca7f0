"""What others wrote into files that are shown here is words, never a part of the page."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

from gui_parts import Parts

from fcw.annotation.records import Entry, FrameConfirmed, MissedEvent
from fcw.annotation.review import JudgedEvent, fold
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.boxes import BoxesPanel
from fcw_viz.review_app.panels.moment_list import event_words
from fcw_viz.review_app.panels.remarks import RemarksPanel
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.session import DriveReview

MARKUP = '"><img src=x onerror=alert(1)>'
TIME = "2026-11-20T10:00:00.000000Z"


def test_names_and_ids_of_another_review_file_are_words(drive: Drive):
    review = fold(
        [
            Entry("a", TIME, MARKUP, FrameConfirmed(0)),
            Entry(MARKUP, TIME, "anna", MissedEvent(1.0, 2.0, "")),
        ]
    )
    session: Any = SimpleNamespace(reviewer="anna", review=lambda *_: DriveReview(review, (), ()))
    place = Place(session)
    place.drive = drive
    boxes = BoxEditor(MagicMock(), place, Annotating(place, MagicMock()), MagicMock())
    boxes.active = True
    parts: Any = Parts()
    BoxesPanel(parts, MagicMock(), boxes, MagicMock()).show()
    RemarksPanel(parts, place).show()
    assert "Confirmed by" in parts.html
    assert "missedlevel" in parts.html
    assert "<img" not in parts.html


def test_a_kind_of_event_in_the_list_of_a_batch_is_a_word(drive: Drive):
    strange: Any = replace(drive.events[0], kind=MARKUP)
    card = DriveCard("made", Path("drive.mcap"), 24.0, (strange,), judged=(JudgedEvent(strange, ()),))
    assert "<img" not in event_words(card, 0)
