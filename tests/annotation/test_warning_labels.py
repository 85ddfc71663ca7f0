"""Verdicts as the labels by which warnings are measured."""

import json
import shutil
from pathlib import Path

import pytest
from annotation_helpers import frame_result, write_log

from fcw.annotation.records import Entry, Judgement, MissedEvent, Verdict
from fcw.annotation.review import fold, reference_to
from fcw.annotation.store import ReviewStore
from fcw.annotation.warning_labels import warning_labels
from fcw.evaluation.warning.events import Event, compare_with_events
from fcw.logs.events import find_events
from fcw.logs.mcap.reader import DriveLog
from fcw.warning.types import WarningLevel
from fcw_viz.cli import main

WARNING, CAUTION, ADVISORY, NONE = (WarningLevel[name] for name in ("WARNING", "CAUTION", "ADVISORY", "NONE"))
SHOWN = {
    WARNING: ((1.0, 1.4), (2.5, 2.9), (4.0, 4.4), (6.0, 6.4)),
    CAUTION: ((8.0, 8.4),),
}


def levels(shown):
    """Ten seconds of ten frames each."""
    result = [NONE] * 100
    for level, spans in shown.items():
        for start_s, end_s in spans:
            for frame in range(round(10 * start_s), round(10 * end_s) + 1):
                result[frame] = level
    return result


def write_drive(folder, shown=SHOWN):
    return write_log(folder / "drive.mcap", [frame_result(i, level) for i, level in enumerate(levels(shown))])


@pytest.fixture(scope="module")
def unjudged(tmp_path_factory):
    return write_drive(tmp_path_factory.mktemp("drive"))


@pytest.fixture(scope="module")
def events(unjudged):
    return find_events(unjudged.series())


@pytest.fixture
def drive(unjudged, tmp_path):
    folder = tmp_path / "first"
    folder.mkdir()
    return DriveLog(Path(shutil.copy(unjudged.path, folder)))


def judge(log, *judged, missed=()):
    """Let people judge a drive: (person, the event's start, judgement)."""
    store = ReviewStore(log)
    for person, start_s, judgement in judged:
        (event,) = (event for event in find_events(log.series()) if event.start_s == start_s)
        store.add(person, Verdict(reference_to(event), judgement))
    for start_s, end_s in missed:
        store.add("Ann", MissedEvent(start_s, end_s, "cut in"))
    store.close()


def test_the_drive_warns_where_it_should(events):
    assert [(event.kind, event.start_s, event.end_s) for event in events] == [
        *(("warning", *span) for span in SHOWN[WARNING]),
        *(("caution", *span) for span in SHOWN[CAUTION]),
    ]


def labels_of(events, *said, missed=()):
    """The labels of Ann's and others' verdicts by the events' numbers."""
    sayings = [(person, Verdict(reference_to(events[i]), judgement)) for person, i, judgement in said]
    sayings += [("Ann", one) for one in missed]
    return warning_labels(
        fold(
            Entry(str(i), f"2026-11-20T10:00:{i:02}.000000Z", person, what)
            for i, (person, what) in enumerate(sayings)
        ),
        events,
    )


def test_right_early_and_late_ones_are_events_false_ones_none_and_missed_ones_are_added(events):
    labels = labels_of(
        events,
        ("Ann", 0, Judgement.RIGHT),
        ("Ann", 1, Judgement.FALSE),
        ("Ann", 2, Judgement.TOO_LATE),
        ("Ann", 4, Judgement.TOO_EARLY),
        missed=[MissedEvent(5.0, 5.5, "")],
    )
    assert labels.events == (
        Event(1.0, 1.4),
        Event(2.5, 2.9, justified=False),
        Event(4.0, 4.4),
        Event(5.0, 5.5),
        Event(8.0, 8.4, CAUTION),
    )
    assert dict(labels.judgements) == dict.fromkeys(Judgement, 1)
    assert (labels.disagreements, labels.lost) == ((), 0)


def test_what_people_judge_differently_is_no_label(events):
    labels = labels_of(
        events, ("Ann", 0, Judgement.RIGHT), ("Bo", 0, Judgement.FALSE), ("Bo", 1, Judgement.RIGHT)
    )
    assert labels.events == (Event(2.5, 2.9),)
    assert [one.event for one in labels.disagreements] == [events[0]]


def test_a_missed_event_that_two_people_added_is_one(events):
    missed = [MissedEvent(5.0, 5.5, "", CAUTION), MissedEvent(5.3, 5.4, ""), MissedEvent(5.6, 5.7, "")]
    assert labels_of(events, missed=missed).events == (Event(5.0, 5.5, WARNING), Event(5.6, 5.7))


def test_a_verdict_on_a_warning_that_is_gone_is_counted_as_lost(events):
    labels = labels_of(events, ("Ann", 0, Judgement.RIGHT))
    gone = warning_labels(
        fold(
            [
                Entry(
                    "0",
                    "2026-11-20T10:00:00.000000Z",
                    "Ann",
                    Verdict(reference_to(events[0]), Judgement.RIGHT),
                )
            ]
        ),
        events[1:],
    )
    assert (len(labels.events), labels.lost) == (1, 0)
    assert (gone.events, gone.lost) == ((), 1)


# Compared with a log of which not everything is judged


def compared(labels, shown):
    frames = (frame_result(i, level) for i, level in enumerate(levels(shown)))
    return compare_with_events(frames, labels, complete=False)


def test_a_false_alarm_is_a_warning_where_it_was_judged_false_and_others_are_unjudged():
    labels = [Event(1.0, 1.4), Event(2.5, 2.9, justified=False)]
    found = compared(labels, SHOWN)
    assert (found.hits, found.missed) == ((labels[0],), ())
    assert [(run.start_s, run.end_s) for run in found.false_alarms] == [(2.5, 2.9)]
    assert [run.start_s for run in found.unjudged] == [4.0, 6.0]


def test_what_is_not_shown_any_more_is_no_false_alarm_and_what_was_due_is_missed():
    labels = [Event(1.0, 1.4), Event(2.5, 2.9, justified=False)]
    found = compared(labels, {CAUTION: ((1.0, 1.4), (2.5, 2.9))})
    assert (found.hits, found.missed, found.false_alarms, found.unjudged) == ((), (labels[0],), (), ())


def test_a_warning_judged_false_right_after_a_caution_judged_right_is_a_false_alarm():
    labels = [Event(1.0, 1.4, CAUTION), Event(1.5, 1.9, justified=False)]
    found = compared(labels, {CAUTION: ((1.0, 1.4),), WARNING: ((1.5, 1.9),)})
    assert [(run.start_s, run.end_s, run.highest) for run in found.false_alarms] == [(1.5, 1.9, WARNING)]
    assert found.hits == (labels[0],)


# As it is typed


def evaluated(capsys, *arguments):
    assert main(["evaluate", "warning", *map(str, arguments), "--json"]) == 0
    captured = capsys.readouterr()
    return json.loads(captured.out), captured.err


def test_a_reviewed_log_is_measured_by_its_own_verdicts(drive, capsys):
    judge(
        drive,
        ("Ann", 1.0, Judgement.RIGHT),
        ("Ann", 2.5, Judgement.FALSE),
        ("Ann", 4.0, Judgement.RIGHT),
        ("Bo", 4.0, Judgement.FALSE),
        missed=[(5.0, 5.5)],
    )
    result, notes = evaluated(capsys, "--log", drive.path.parent)
    assert (result["hits"], result["missed"], result["false_alarms"]) == (1, 1, 1)
    assert [event["start_s"] for event in result["missed_events"]] == [5.0]
    assert [run["start_s"] for run in result["false_alarm_spans"]] == [2.5]
    # Judged differently, or by nobody: neither good nor bad.
    assert [run["start_s"] for run in result["unjudged_spans"]] == [4.0, 6.0]
    assert result["judgements"] == {"right": 1, "too_early": 0, "too_late": 0, "false": 1}
    assert (result["disagreements"], result["lost_verdicts"]) == (1, 0)
    assert "people disagree about 1 warning: not used as a label" in notes


def test_another_run_of_the_drive_is_measured_by_the_verdicts_on_the_first(drive, tmp_path, capsys):
    judge(drive, ("Ann", 1.0, Judgement.RIGHT), ("Ann", 2.5, Judgement.FALSE), missed=[(5.0, 5.5)])
    second = write_drive(tmp_path / "second", {WARNING: ((1.2, 1.6), (5.4, 5.6))})
    result, _ = evaluated(capsys, "--events", drive.path, "--log", second.path)
    assert (result["hits"], result["missed"], result["false_alarms"]) == (2, 0, 0)


def test_in_words_the_unjudged_ones_are_told(drive, capsys):
    judge(drive, ("Ann", 1.0, Judgement.RIGHT))
    assert main(["evaluate", "warning", "--log", str(drive.path)]) == 0
    assert "1 event warned of, 0 missed, 0 false alarms, 3 unjudged" in capsys.readouterr().out


def test_a_drive_that_nobody_judged_is_told_with_the_mend(drive, capsys):
    assert main(["evaluate", "warning", "--log", str(drive.path), "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "no warning of this drive has a verdict yet; judge them with `fcw review" in captured.err


def test_damage_in_a_review_is_told(drive, capsys):
    judge(drive, ("Ann", 1.0, Judgement.RIGHT))
    with drive.path.with_name("drive.review.Ann.jsonl").open("a") as file:
        file.write("rubbish\n")
    assert "line 3 is damaged and left out" in evaluated(capsys, "--log", drive.path)[1]
