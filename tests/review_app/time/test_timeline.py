"""The time line: every event is a mark where it happened."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import combinations

import cv2
import numpy as np
import pytest
from review_drives import ADVISORY_S, CAUTION_S, MOVED_S, NEAR_MISS_S, RATE_HZ, WARNING_END_S

from fcw.annotation.records import (
    BoxEdit,
    Entry,
    EventReference,
    FrameConfirmed,
    Judgement,
    MissedEvent,
    Note,
    Verdict,
)
from fcw.annotation.review import JudgedEvent, fold, judged_events
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.strip import _missed_ends_html
from fcw_viz.review_app.time.timeline import KIND_COLORS, drawn_events, labelled_spans, timeline_svg

SVG = "{http://www.w3.org/2000/svg}"
TIME = "2026-11-20T10:00:00.00000{}Z"


JUST_NOTICEABLE = 2.3
"""Distance of two colours in CIELAB that an eye just tells apart side by side (Mahy et al. 1994)."""


def rgb(color: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", color)]


def test_the_colours_of_two_kinds_of_events_are_never_alike():
    colors = np.array([[rgb(color) for color in KIND_COLORS.values()]], np.float32) / 255
    (lab,) = cv2.cvtColor(colors, cv2.COLOR_RGB2Lab)
    for (kind, one), (other_kind, other) in combinations(zip(KIND_COLORS, lab, strict=True), 2):
        assert np.linalg.norm(one - other) > 8 * JUST_NOTICEABLE, f"{kind}, {other_kind}"


def entries(*said):
    return [Entry(str(k), TIME.format(k), person, one) for k, (person, one) in enumerate(said)]


def drawn(drive: Drive, *said, selected: int | None = None) -> ET.Element:
    review = fold(entries(*said))
    judged, _ = judged_events(review, drive.events)
    axis = TimeAxis(0.0, drive.duration_s, 1000.0)
    return ET.fromstring(timeline_svg(axis, judged, review, (5.0, 10.0), selected, False))


def test_each_event_is_where_it_happened_and_says_its_number(drive: Drive):
    marks = drawn(drive).findall(f".//{SVG}g[@data-event]")
    lefts_s = {}
    for mark in marks:
        assert mark.get("data-fcw") == f"event:{mark.get('data-event')}"
        x = mark.find(f"{SVG}rect")
        assert x is not None
        lefts_s[int(mark.get("data-event", ""))] = (float(x.get("x", "")) + 4) / 1000 * drive.duration_s
    starts_s = [CAUTION_S, NEAR_MISS_S, ADVISORY_S, MOVED_S]
    assert [lefts_s[number] for number in range(4)] == pytest.approx(starts_s, abs=0.05)


def test_a_warning_is_as_long_as_it_lasted_and_higher_than_an_advisory(drive: Drive):
    marks = {mark.get("data-event"): mark for mark in drawn(drive).findall(f".//{SVG}g[@data-event]")}
    warning, advisory = (marks[number].findall(f"{SVG}rect")[1] for number in ("0", "2"))
    seconds = float(warning.get("width", "")) / 1000 * drive.duration_s
    assert seconds == pytest.approx(WARNING_END_S - CAUTION_S, abs=0.1)
    assert float(warning.get("height", "")) > float(advisory.get("height", ""))


def test_verdicts_and_remarks_stand_over_their_moments(drive: Drive):
    about = EventReference("warning", 7, CAUTION_S, drive.events[0].end_s)
    svg = drawn(
        drive,
        ("anna", Verdict(about, Judgement.FALSE)),
        ("anna", Note(3.0, "<b>rain</b>")),
        ("bert", MissedEvent(14.0, 16.0, "")),
    )
    texts = ["".join(text.itertext()) for text in svg.iter(f"{SVG}text")]
    assert "✗" in texts
    titles = [title.text for title in svg.iter(f"{SVG}title")]
    assert "anna: <b>rain</b>" in titles
    assert "bert: missed" in titles
    assert svg.findall(f".//{SVG}g[@data-fcw='goto:3.0']")


def test_people_who_disagree_are_shown_to_disagree(drive: Drive):
    about = EventReference("warning", 7, CAUTION_S, drive.events[0].end_s)
    svg = drawn(drive, ("anna", Verdict(about, Judgement.FALSE)), ("bert", Verdict(about, Judgement.RIGHT)))
    assert "≠" in ["".join(text.itertext()) for text in svg.iter(f"{SVG}text")]


def test_of_events_on_the_same_pixels_the_worst_is_drawn_and_the_selected_one(drive: Drive):
    warning = drive.events[0]
    crowd = tuple(
        JudgedEvent(replace(warning, start_s=9.0 + 1e-4 * k, severity=0.1 * k), ()) for k in range(5)
    )
    axis = TimeAxis(0.0, drive.duration_s, 1000.0)
    assert drawn_events(axis, crowd, None) == {4}
    assert 1 in drawn_events(axis, crowd, 1)


def test_the_marks_of_a_folder_name_their_drive(drive: Drive):
    axis = TimeAxis(0.0, drive.duration_s, 1000.0)
    judged, _ = judged_events(fold(()), drive.events)
    text = timeline_svg(axis, judged, fold(()), None, None, False, 'open:a "b" <c>#')
    marks = ET.fromstring(text).findall(f".//{SVG}g[@data-event]")
    assert {mark.get("data-fcw") for mark in marks} == {f'open:a "b" <c>#{number}' for number in range(4)}
    assert not re.search(r"data-name=.shown", text)


def test_labelled_frames_in_a_row_are_one_bar_with_what_is_confirmed_apart(drive: Drive):
    said = [BoxEdit(index, "track 3", None) for index in (10, 11, 12, 40)]
    said += [FrameConfirmed(index) for index in (12, 13)]
    spans = labelled_spans(drive, fold(entries(*(("anna", one) for one in said))))
    assert [(round(a * RATE_HZ), round(b * RATE_HZ), sure) for a, b, sure in spans] == [
        (10, 11, False),
        (12, 13, True),
        (40, 40, False),
    ]


@pytest.mark.parametrize(
    ("duration_s", "texts"), [(2.0, ["0.0 s", "0.5 s", "1.0 s", "1.5 s", "2.0 s"]), (4.0, ["0 s", "1 s"])]
)
def test_ticks_have_as_many_digits_as_their_step(duration_s: float, texts: list[str]):
    drawn = ET.fromstring(timeline_svg(TimeAxis(0.0, duration_s, 500.0), (), fold(()), None, None, False))
    assert [each.text for each in drawn.iter() if each.tag.endswith("text")][: len(texts)] == texts


def test_ends_to_drag_stand_on_the_time_line_of_the_run_that_is_shown():
    missed = entries(("anna", MissedEvent(1.0, 2.0, "")), ("anna", MissedEvent(2.5, 40.0, "")))
    html = _missed_ends_html(TimeAxis(0.0, 3.0, 300.0), fold(missed), "anna")
    assert re.findall(r"left:([\d.]+)px", html) == ["100.0", "200.0", "250.0"]
