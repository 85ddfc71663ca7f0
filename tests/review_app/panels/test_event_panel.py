"""What the panel says of a drive's events, and that it says it once."""

import re
from pathlib import Path
from typing import Any

from gui_parts import Parts
from review_drives import QUIET_S, write_drive

from fcw.annotation.records import Judgement
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.panels.event import EventPanel
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.session import ReviewSession


def shown(place: Place) -> str:
    parts: Any = Parts()
    EventPanel(parts, place, Annotating(place, lambda title, text: None)).show()
    return parts.html


def test_that_a_drive_has_no_events_is_said_once(tmp_path: Path):
    session = ReviewSession({"quiet": write_drive(tmp_path / "drive.mcap", QUIET_S)}, "anna")
    place = Place(session)
    place.enter(session.open(place, "quiet"), None, None)
    said = shown(place).lower()
    session.close()
    assert said.count("event") == 1
    assert "no events in this drive" in said


def test_where_no_event_is_selected_the_key_to_one_is_told(place: Place):
    place.selected = None
    assert "No event selected. Press N for the next one." in shown(place)


def test_a_comment_half_typed_about_one_event_is_not_in_the_field_of_another(place: Place):
    annotating, fields = Annotating(place, lambda title, text: None), []
    for number in (0, 1, 0):
        place.selected = number
        if annotating.own_verdict is None:
            annotating.judge(Judgement.RIGHT)
        fields.append(re.findall('<input[^>]*data-fcw-enter="explain"[^>]*>', shown(place)))
    assert fields[0] == fields[2] != fields[1]
