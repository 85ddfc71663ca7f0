"""Verdicts of a tab: given, changed, taken back and given again."""

import pytest

from fcw.annotation.records import Judgement, Reason
from fcw.errors import UserError
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.place import Place


@pytest.fixture
def annotating(place: Place) -> Annotating:
    return Annotating(place, lambda title, text: None)


def verdicts(place: Place) -> list[tuple[Judgement, Reason | None, str]]:
    return [
        (entry.said.judgement, entry.said.reason, entry.said.text) for entry in place.review.review.verdicts
    ]


def test_a_verdict_with_its_reason_and_words_is_one_verdict(place: Place, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.give_reason(Reason.CURVE)
    annotating.explain(" left bend ")
    assert verdicts(place) == [(Judgement.FALSE, Reason.CURVE, "left bend")]


def test_another_verdict_takes_its_place_without_the_reason_that_was_for_the_first(
    place: Place, annotating: Annotating
):
    annotating.judge(Judgement.FALSE)
    annotating.give_reason(Reason.CURVE)
    annotating.judge(Judgement.TOO_LATE)
    assert verdicts(place) == [(Judgement.TOO_LATE, None, "")]


def test_the_same_verdict_again_takes_it_back(place: Place, annotating: Annotating):
    annotating.judge(Judgement.RIGHT)
    annotating.judge(Judgement.RIGHT)
    assert verdicts(place) == []


def test_undo_goes_back_word_by_word_and_redo_on_again(place: Place, annotating: Annotating):
    states = [verdicts(place)]
    for step in (
        lambda: annotating.judge(Judgement.FALSE),
        lambda: annotating.give_reason(Reason.PARKED),
        lambda: annotating.judge(Judgement.RIGHT),
    ):
        step()
        states.append(verdicts(place))
    for state in reversed(states[:-1]):
        annotating.undo()
        assert verdicts(place) == state
    with pytest.raises(UserError, match="nothing to undo"):
        annotating.undo()
    for state in states[1:]:
        annotating.redo()
        assert verdicts(place) == state
    with pytest.raises(UserError, match="nothing to do again"):
        annotating.redo()
    annotating.undo()
    assert verdicts(place) == states[-2]


def test_something_new_said_ends_what_could_be_said_again(place: Place, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.undo()
    annotating.add_note("fog")
    with pytest.raises(UserError, match="nothing to do again"):
        annotating.redo()


def test_a_missed_event_stays_inside_the_drive(place: Place, annotating: Annotating):
    place.row = place.opened.row_at(0.2)
    annotating.add_missed("child on the road")
    (entry,) = place.review.review.missed
    assert (entry.said.start_s, entry.said.end_s) == (0.0, 1.2)


@pytest.mark.parametrize("act", ["judge", "reason"])
def test_without_an_event_or_a_verdict_the_person_is_told_what_to_do_first(
    place: Place, annotating: Annotating, act: str
):
    if act == "judge":
        place.selected = None
        with pytest.raises(UserError, match="select an event first"):
            annotating.judge(Judgement.RIGHT)
    else:
        with pytest.raises(UserError, match="give a verdict first"):
            annotating.give_reason(Reason.CURVE)
