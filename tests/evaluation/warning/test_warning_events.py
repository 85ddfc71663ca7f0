"""Labelled events against the warnings in a log."""

import json
import re

import pytest

from fcw.errors import UserError
from fcw.evaluation.warning.events import Event, compare_with_events, read_events
from fcw.logs.records import FrameResult
from fcw.warning.types import WarningLevel, WarningState

WARNING, CAUTION, ADVISORY, NONE = (WarningLevel[name] for name in ("WARNING", "CAUTION", "ADVISORY", "NONE"))


def log(*levels, start_ns=5 * 10**9):
    """Ten frames a second from 5 s on the source's clock."""
    for index, level in enumerate(levels):
        state = WarningState(level, 1, "ttc") if level else WarningState(NONE)
        yield FrameResult(index, start_ns + index * 10**8, (), (), None, state, None)


def test_an_event_is_hit_by_its_level_within_it_and_missed_otherwise():
    levels = [NONE] * 10 + [CAUTION] * 5 + [WARNING] * 5 + [NONE] * 10
    events = [
        Event(1.4, 1.6),
        Event(1.0, 1.4),
        Event(1.0, 1.4, CAUTION),
        Event(2.5, 2.9),
    ]
    found = compare_with_events(log(*levels), events)
    assert found.hits == (events[0], events[2])
    assert found.missed == (events[1], events[3])
    assert found.false_alarms == ()


def test_a_run_of_warnings_that_touches_no_event_is_one_false_alarm():
    levels = [WARNING] * 3 + [NONE] * 2 + [WARNING] * 3 + [CAUTION] * 2
    found = compare_with_events(log(*levels), [Event(0.0, 0.1)])
    assert [(run.start_s, run.end_s, run.highest) for run in found.false_alarms] == [(0.5, 0.7, WARNING)]


def test_levels_below_those_labelled_do_not_count():
    levels = [CAUTION] * 3 + [NONE] + [ADVISORY] * 3
    assert compare_with_events(log(*levels), [Event(9, 9)]).false_alarms == ()
    by_caution = compare_with_events(log(*levels), [Event(9, 9, CAUTION)]).false_alarms
    assert [(run.start_s, run.highest) for run in by_caution] == [(0.0, CAUTION)]


def test_a_stretch_known_to_be_a_false_alarm_is_no_event():
    found = compare_with_events(log(WARNING, WARNING), [Event(0.0, 1.0, justified=False)])
    assert (len(found.hits), len(found.missed), len(found.false_alarms)) == (0, 0, 1)


def test_an_empty_log_misses_everything():
    event = Event(0, 1)
    assert compare_with_events(log(), [event]).missed == (event,)


def test_csv_and_json_say_the_same(tmp_path):
    (tmp_path / "events.csv").write_text(
        "start_s, end_s, level, verdict\n1, 2.5, caution,\n3, 4, , false\n5, 6, advisory, justified\n"
    )
    (tmp_path / "events.json").write_text(
        json.dumps(
            [
                {"start_s": 1, "end_s": 2.5, "level": "caution"},
                {"start_s": 3, "end_s": 4, "verdict": "false"},
                {"start_s": 5, "end_s": 6, "level": "advisory", "note": "a truck"},
            ]
        )
    )
    expected = (Event(1, 2.5, CAUTION), Event(3, 4, justified=False), Event(5, 6, ADVISORY))
    assert read_events(tmp_path / "events.csv") == read_events(tmp_path / "events.json") == expected


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("e.csv", "start_s,end_s\n1,2\n3,x\n", "event 2: end_s is 'x', expected seconds"),
        ("e.csv", "start_s\n1\n", "event 1: end_s is None, expected seconds"),
        ("e.csv", "start_s,end_s\n3,2\n", "event 1: end_s 2 is before start_s 3"),
        ("e.csv", "start_s,end_s,level\n1,2,loud\n", "event 1: level is 'loud'; expected CSV"),
        ("e.csv", "start_s,end_s,verdict\n1,2,maybe\n", "event 1: verdict is 'maybe'; expected CSV"),
        ("e.json", "{", "no JSON"),
        ("e.json", "{}", "no list of objects"),
        ("e.json", '[{"start_s": true, "end_s": NaN}]', "event 1: end_s is nan, expected seconds"),
    ],
)
def test_a_wrong_file_is_named_with_event_and_value(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(UserError, match=re.escape(message)) as caught:
        read_events(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_says_what_was_expected(tmp_path):
    with pytest.raises(
        UserError, match=r"cannot read the events .*; expected CSV with the columns start_s, end_s"
    ):
        read_events(tmp_path / "none.csv")
