"""What counts of what people say: in any order, taken back, of several, after events are found anew."""

import json
from dataclasses import replace

import pytest
from annotation_helpers import WARNED, histories, labels, sayings
from hypothesis import given
from hypothesis import strategies as st

from fcw.annotation.records import (
    SAID_TYPES,
    BoxEdit,
    Entry,
    FrameConfirmed,
    Judgement,
    LabelledBox,
    MissedEvent,
    Note,
    Reason,
    TakenBack,
    Verdict,
)
from fcw.annotation.review import find_event, fold, judged_events, reference_to
from fcw.box import Box
from fcw.errors import UserError
from fcw.json_form import tagged_from_json, tagged_to_json
from fcw.logs.events import DriveEvent
from fcw.warning.types import WarningLevel

RIGHT, FALSE = Verdict(WARNED, Judgement.RIGHT), Verdict(WARNED, Judgement.FALSE, Reason.ONCOMING)


def event(kind, track_id, start_s, end_s):
    return DriveEvent(kind, start_s, end_s, start_s, track_id, "ttc", 2.0, 15.0, 3.0, 0.4)


def entry(second, person, said):
    return Entry(f"{person}{second}", f"2026-11-20T10:00:{second:02}.000000Z", person, said)


def said(entries):
    return [entry.said for entry in entries]


@given(histories(), st.randoms(use_true_random=False))
def test_neither_the_order_of_the_files_nor_a_copied_file_matters(entries, random):
    mixed = entries + random.choices(entries, k=len(entries)) if entries else []
    random.shuffle(mixed)
    assert fold(mixed) == fold(entries)


@given(histories())
def test_an_entry_counts_unless_its_person_took_it_back_later_and_that_counts(entries):
    def counts(number):
        return not any(
            later.said == TakenBack(entries[number].entry_id)
            and later.person == entries[number].person
            and counts(number + 1 + after)
            for after, later in enumerate(entries[number + 1 :])
        )

    assert fold(entries).entries == tuple(e for number, e in enumerate(entries) if counts(number))


@given(sayings | st.builds(TakenBack, st.text(max_size=5)))
def test_all_that_can_be_said_survives_its_form_on_the_disk(what):
    assert tagged_from_json(SAID_TYPES, json.loads(json.dumps(tagged_to_json(what, "said"))), "said") == what


def test_of_one_person_the_last_verdict_on_an_event_counts():
    review = fold([entry(1, "Ann", RIGHT), entry(2, "Ann", FALSE)])
    assert said(review.verdicts) == [FALSE]


def test_two_peoples_different_verdicts_stand_as_a_disagreement_until_they_agree():
    warned = event("warning", 7, 1.0, 1.9)
    entries = [entry(1, "Ann", RIGHT), entry(2, "Bo", FALSE)]
    (judged,), lost = judged_events(fold(entries), [warned])
    assert (judged.event, said(judged.verdicts), lost) == (warned, [RIGHT, FALSE], ())
    assert judged.disagreement
    assert judged.judgement is None
    (judged,), _ = judged_events(fold([*entries, entry(3, "Bo", RIGHT)]), [warned])
    assert not judged.disagreement
    assert judged.judgement is Judgement.RIGHT


def test_a_verdict_taken_back_gives_way_to_the_one_before_and_comes_back_when_that_is_taken_back():
    entries = [entry(1, "Ann", RIGHT), entry(2, "Ann", FALSE), entry(3, "Ann", TakenBack("Ann2"))]
    assert said(fold(entries).verdicts) == [RIGHT]
    assert said(fold([*entries, entry(4, "Ann", TakenBack("Ann3"))]).verdicts) == [FALSE]


def test_nobody_takes_back_what_another_said():
    assert said(fold([entry(1, "Ann", RIGHT), entry(2, "Bo", TakenBack("Ann1"))]).verdicts) == [RIGHT]


def test_the_latest_edit_of_a_box_counts_and_all_peoples_are_kept():
    first, second = (LabelledBox(Box(x, 20, 30, 40), 1) for x in (10, 12))
    review = fold(
        [
            entry(1, "Ann", BoxEdit(5, "track 1", first)),
            entry(2, "Ann", BoxEdit(5, "track 2", None)),
            entry(3, "Bo", BoxEdit(5, "track 1", second)),
            entry(4, "Bo", FrameConfirmed(5)),
        ]
    )
    assert review.frames[5].labels == {"track 1": second, "track 2": None}
    assert [(e.person, e.said.label) for e in review.frames[5].edits["track 1"]] == [
        ("Ann", first),
        ("Bo", second),
    ]
    assert [e.person for e in review.frames[5].confirmed] == ["Bo"]
    assert review.people == ("Ann", "Bo")


# Finding an event again


def test_an_event_is_found_by_kind_track_and_start():
    events = [
        event("caution", 7, 1.0, 1.9),
        event("warning", 8, 1.0, 1.9),
        event("warning", 7, 1.0, 1.5),
        event("warning", 7, 1.5, 1.9),
    ]
    assert find_event(WARNED, events) == 2


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ([event("warning", 7, 0.8, 1.9)], 0),  # begins earlier by a refined rule
        ([event("warning", 7, 0.0, 9.0)], 0),  # merged with its neighbours
        ([event("warning", 7, 1.0, 1.1), event("warning", 7, 1.3, 1.9)], 0),  # split: the one with its start
        ([event("warning", 7, 0.9, 1.1), event("warning", 7, 1.3, 1.9)], 1),  # split: the longer part
        ([event("warning", 8, 1.0, 1.9)], 0),  # the track's id is told otherwise
        ([event("warning", 8, 1.0, 1.9), event("warning", 7, 1.8, 2.5)], 1),  # the same track before another
        ([event("warning", 7, 2.5, 3.0)], 0),  # the same track a moment later
        ([event("warning", 8, 2.5, 3.0)], None),  # another track without a shared moment
        ([event("warning", 7, 9.0, 9.5)], None),
        ([event("caution", 7, 1.0, 1.9)], None),
        ([], None),
    ],
)
def test_it_is_found_again_when_events_are_found_otherwise(events, expected):
    assert find_event(WARNED, events) == expected


@given(st.lists(st.tuples(st.sampled_from(["warning", "caution"]), st.integers(1, 3)), max_size=6), st.data())
def test_as_long_as_events_are_found_as_they_were_each_is_found_again(kinds, data):
    """Stretches of one kind and track do not overlap, but may touch."""
    clock: dict = {}
    events = []
    for kind, track_id in kinds:
        start_s = clock.get((kind, track_id), 0.0) + data.draw(st.floats(0, 5))
        clock[kind, track_id] = end_s = start_s + data.draw(st.floats(0.1, 5))
        events.append(event(kind, track_id, start_s, end_s))
    for index, one in enumerate(events):
        assert find_event(reference_to(one), events) == index


def test_a_verdict_whose_event_is_gone_is_given_back_and_not_dropped():
    review = fold([entry(1, "Ann", RIGHT)])
    (judged,), lost = judged_events(review, [event("warning", 7, 50, 51)])
    assert (judged.verdicts, said(lost)) == ((), [RIGHT])


# What cannot be said


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: MissedEvent(3, 2, "cut in"), "event from 3 s to 2 s: expected an end not before the start"),
        (lambda: MissedEvent(0, float("nan"), ""), "expected an end not before the start"),
        (lambda: MissedEvent(0, 1, "", WarningLevel.NONE), "expected the level of the warning that was due"),
        (lambda: replace(RIGHT, reason=Reason.ONCOMING), "'oncoming vehicle' is no reason for it"),
        (lambda: replace(FALSE, reason=Reason.FOUND_LATE), "verdict 'false': 'vehicle was found late'"),
        (lambda: Note(1, " "), "note: it is empty"),
        (lambda: MissedEvent(0, 1e308, ""), "expected an end not before the start, in the drive"),
        (lambda: Note(float("inf"), "a"), "expected a moment of the drive"),
        (lambda: Note(1e308, "a"), "expected a moment of the drive"),
        (lambda: LabelledBox(Box(-1e308, 0, 1e308, 1)), "with an area, within 100000 pixels"),
        (lambda: LabelledBox(Box(0, 0, 1, 1), rear_box=Box(0, 0, 1, 1e308)), "within 100000 pixels"),
        (lambda: LabelledBox(Box(1, 2, 0, 3)), "box 1, 2, 0 x 3: expected one with an area"),
        (lambda: LabelledBox(Box(1, float("nan"), 1, 3)), "expected one with an area"),
    ],
)
def test_what_makes_no_sense_is_refused_with_the_value(make, message):
    with pytest.raises(UserError) as error:
        make()
    assert message in str(error.value)


@given(labels)
def test_any_box_with_an_area_can_be_said(label):
    assert label.box.w > 0
