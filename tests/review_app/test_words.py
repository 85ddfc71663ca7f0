"""What is said of an event, and in the lists."""

import math
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from review_drives import CAUTION_S, NEAR_MISS_S, RATE_HZ, WARNING_S, result

from fcw.annotation.records import Entry, EventReference, Judgement, Reason, Verdict
from fcw.annotation.review import fold, judged_events, reference_to
from fcw.logs.events import DriveEvent, EventKind
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.review_app.drive import Drive, by_severity
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.event_list import list_html, verdict_html
from fcw_viz.review_app.panels.moment_list import event_words
from fcw_viz.review_app.place import list_order
from fcw_viz.review_app.words import (
    KIND_TITLES,
    event_line,
    moment_words,
    verdict_counts,
    verdict_words,
    why,
)


def row(time_s: float) -> int:
    return round(time_s * RATE_HZ)


def test_kinds_of_events_are_called_what_the_tables_call_them():
    assert {kind: title.lower() for kind, title in KIND_TITLES.items()} == {
        kind: kind for kind in get_args(EventKind)
    }


def test_the_words_of_a_moment_are_its_level_and_reason():
    assert moment_words(result(row(WARNING_S)).told_warning, False) == "Warning: short time to collision"
    assert moment_words(result(row(2.0)).told_warning, False) == "No warning"


def test_why_a_warning_came_is_its_level_rule_ttc_distance_with_interval_and_closing_speed():
    said = dict(why(result(row(WARNING_S)), False))
    assert said["Level"] == "warning: act now"
    assert said["Rule"] == "short time to collision"
    assert said["Collision in"] == "1.5 s"
    assert said["Distance"] == "22 m, 20 m to 27 m"
    assert said["Closing"] == "54 km/h ± 2 km/h"
    assert said["Braking needed"] == "0.51 g"
    assert said["Headway"] == "1.1 s"
    assert said["Own speed"] == "72 km/h"


def test_why_in_feet_and_miles():
    said = dict(why(result(row(WARNING_S)), True))
    assert said["Distance"] == "74 ft, 66 ft to 89 ft"
    assert said["Closing"] == "34 mph ± 1 mph"


def test_a_near_miss_is_told_by_the_lead():
    said = dict(why(result(row(NEAR_MISS_S)), False))
    assert said["Level"] == "no warning"
    assert said["Vehicle"] == "#9, the lead"
    assert said["Collision in"] == "1.1 s"


def test_a_warned_vehicle_that_is_lost_keeps_its_figures_and_the_threat_is_told():
    one = result(row(CAUTION_S))
    state = WarningState(
        WarningLevel.WARNING,
        7,
        "braking_due",
        ttc_s=1.3,
        required_deceleration_mps2=3.92266,
        distance_m=13.0,
        distance_low_m=12.0,
        distance_high_m=14.0,
        closing_speed_mps=10.0,
        overlap_m=0.9,
        collision_probability=0.83,
        needed_distance_m=15.0,
        assumes="1.2 s to react and 0.40 g",
        extrapolated=True,
    )
    said = dict(why(replace(one, tracks=(), warning=state), False))
    assert said["Rule"] == "braking is due, because with 1.2 s to react and 0.40 g you are 2.0 m too close"
    assert said["Vehicle"] == "#7, not seen any more; extrapolated figures"
    assert (said["Distance"], said["Closing"], said["Collision in"]) == ("13.0 m", "36 km/h", "1.3 s")
    assert (said["Braking needed"], said["Overlap"]) == ("0.40 g", "0.9 m")
    assert said["Collision"] == "83% likely if nobody reacts"


@pytest.mark.parametrize(
    ("overlap_m", "imperial", "said"),
    [
        (0.9, False, "0.9 m"),
        (0.04, False, "next to none"),
        (-0.04, False, "next to none"),
        (-0.3, False, "none, 0.3 m apart"),
        (0.1, True, "next to none"),
        (0.9, True, "3 ft"),
    ],
)
def test_an_overlap_that_rounds_to_nothing_is_said_in_words(overlap_m: float, imperial: bool, said: str):
    warned = result(row(WARNING_S))
    state = replace(warned.warning, overlap_m=overlap_m, collision_probability=0.5)
    assert dict(why(replace(warned, warning=state), imperial))["Overlap"] == said


def test_nothing_ahead_and_no_upper_end():
    one = result(row(CAUTION_S))
    assert dict(why(replace(one, tracks=()), False))["Ahead"] == "not seen any more"
    far = replace(one.tracks[1], distance_high_m=math.inf)
    assert dict(why(replace(one, tracks=(far,)), False))["Distance"] == "22 m, more than 20 m"


def test_the_line_of_an_event(drive: Drive):
    lines = [event_line(event, False) for event in drive.events]
    assert lines == ["22 m · TTC 1.5 s · 0.51 g", "11.0 m · TTC 1.1 s · 0.46 g", "12.0 m", ""]


def test_lists_are_sorted_by_severity_or_by_time(drive: Drive):
    judged, _ = judged_events(fold(()), drive.events[::-1])
    assert list_order(judged, by_time=False)[0] == 3
    assert list_order(judged, by_time=True) == [0, 1, 2, 3]
    severities = [drive.events[number].severity for number in by_severity(drive.events)]
    assert severities == sorted(severities, reverse=True)


def test_what_people_typed_is_no_html(drive: Drive):
    event = drive.events[0]
    about = EventReference(event.kind, event.track_id, event.start_s, event.end_s)
    verdict = Verdict(about, Judgement.FALSE, Reason.CURVE, "<script>x</script>")
    entry = Entry("1", "2026-11-20T10:00:00.000000Z", "be<r>t", verdict)
    judged, _ = judged_events(fold([entry]), drive.events)
    assert verdict_words(entry).startswith("be<r>t: false, vehicle beside the path in a curve")
    for html in (verdict_html(judged[0], "anna"), list_html("made", judged, False, 0, False)):
        assert "<script>" not in html
        assert "be&lt;r&gt;t" in html


def test_where_there_are_no_events_the_list_says_what_the_run_told(drive: Drive):
    told = "the calibration looks <wrong>", "7.5 pictures a second"
    html = list_html("made", (), False, None, False, told)
    assert "No events in this drive" in html
    assert html.index("the calibration looks &lt;wrong&gt;") < html.index("7.5 pictures a second")
    assert "Notes from the run" not in list_html("made", (), False, None, False)
    judged, _ = judged_events(fold(()), drive.events)
    assert told[1] not in list_html("made", judged, False, None, False, told)  # they are among the notes


def entry_on(event: DriveEvent, number: int, person: str, judgement: Judgement) -> Entry[Verdict]:
    verdict = Verdict(reference_to(event), judgement)
    return Entry(f"{number} {person}", f"2026-11-20T10:00:0{number}.000000Z", person, verdict)


def test_the_list_of_a_folder_shows_what_each_of_several_people_says_and_that_they_disagree(drive: Drive):
    first, second = drive.events[:2]
    said = [
        entry_on(first, 0, "anna", Judgement.RIGHT),
        entry_on(first, 1, "bert", Judgement.FALSE),
        entry_on(second, 2, "anna", Judgement.TOO_LATE),
        entry_on(second, 3, "bert", Judgement.TOO_LATE),
    ]
    judged, _ = judged_events(fold(said), drive.events)
    card = DriveCard("made", Path("drive.mcap"), 24.0, drive.events, judged=judged)
    assert "<span>≠ anna: right; bert: false</span>" in event_words(card, 0)
    assert "<span>▸ anna: too late; bert: too late</span>" in event_words(card, 1)
    assert not any(sign in event_words(card, 2) for sign in "✓◂▸✗≠")


def test_what_people_judge_differently_is_counted_apart_as_the_summary_does(drive: Drive):
    said = [
        entry_on(drive.events[0], 0, "anna", Judgement.FALSE),
        entry_on(drive.events[0], 0, "bert", Judgement.RIGHT),
        entry_on(drive.events[1], 1, "anna", Judgement.FALSE),
        entry_on(drive.events[2], 2, "bert", Judgement.RIGHT),
    ]
    judged, _ = judged_events(fold(said), drive.events)
    assert verdict_counts(judged) == ("2 judged, 1 of them false, 1 judged differently")
    assert verdict_counts(judged[3:]) == ""
