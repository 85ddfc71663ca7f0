"""Verdicts of a tab: given, changed, taken back and given again."""

import time

import pytest
from review_drives import ADVISORY_S, CAUTION_S, WARNING_S

from fcw.annotation.records import Judgement, Reason, Verdict
from fcw.annotation.review import reference_to
from fcw.annotation.store import ReviewStore
from fcw.errors import UserError
from fcw.warning.types import WarningLevel
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


@pytest.mark.parametrize("keys", ["411", "411144", "4R4", "2344"])
def test_a_verdict_that_is_cleared_brings_no_earlier_one_back(
    place: Place, annotating: Annotating, keys: str
):
    judgements = dict(zip("1234", Judgement, strict=True))
    for key in keys:
        if key == "R":
            annotating.give_reason(Reason.CURVE)
        else:
            annotating.judge(judgements[key])
    assert verdicts(place) == []
    assert place.review.events[0].verdicts == ()


def test_clearing_a_verdict_is_one_step_to_undo_and_to_redo(place: Place, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.judge(Judgement.RIGHT)
    annotating.judge(Judgement.RIGHT)
    annotating.undo()
    assert verdicts(place) == [(Judgement.RIGHT, None, "")]
    annotating.redo()
    assert verdicts(place) == []
    for judgement in (Judgement.RIGHT, Judgement.FALSE):
        annotating.undo()
        assert verdicts(place) == [(judgement, None, "")]
    annotating.undo()
    assert verdicts(place) == []


def test_clearing_takes_back_what_another_tab_said_of_the_event_and_nothing_else(
    place: Place, annotating: Annotating
):
    other_tab = Annotating(place, lambda title, text: None)
    place.selected = 1
    annotating.judge(Judgement.TOO_LATE)
    place.selected = 0
    annotating.judge(Judgement.FALSE)
    store = ReviewStore(place.opened.log)
    store.add("bert", Verdict(reference_to(place.opened.events[0]), Judgement.TOO_EARLY))
    store.close()
    place.session.start()  # it sees what other programs write
    while len(place.review.events[0].verdicts) < 2:
        time.sleep(0.01)
    other_tab.judge(Judgement.RIGHT)
    other_tab.judge(Judgement.RIGHT)
    said = [(judged.verdicts[0].person, judged.judgement) for judged in place.review.events[:2]]
    assert said == [("bert", Judgement.TOO_EARLY), ("anna", Judgement.TOO_LATE)]
    annotating.undo()  # what the other tab has cleared is no step any more
    assert place.review.events[1].verdicts == ()


def test_a_verdict_that_another_tab_has_changed_since_is_no_step_to_undo(
    place: Place, annotating: Annotating
):
    other_tab = Annotating(place, lambda title, text: None)
    annotating.add_note("fog")
    annotating.judge(Judgement.FALSE)
    other_tab.judge(Judgement.RIGHT)
    annotating.undo()  # the step before it counts
    assert place.review.review.notes == ()
    with pytest.raises(UserError, match="nothing to undo: only what this tab did"):
        annotating.undo()
    assert verdicts(place) == [(Judgement.RIGHT, None, "")]
    other_tab.undo()  # nobody has taken back what was said first
    assert verdicts(place) == [(Judgement.FALSE, None, "")]


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
    with pytest.raises(UserError, match="nothing to redo"):
        annotating.redo()
    annotating.undo()
    assert verdicts(place) == states[-2]


def test_a_tab_that_can_undo_nothing_says_how_a_verdict_of_before_is_cleared(
    place: Place, annotating: Annotating
):
    annotating.judge(Judgement.FALSE)
    loaded_anew = Annotating(place, lambda title, text: None)
    with pytest.raises(UserError, match=r"To clear a verdict, press its key \(1 to 4\) again") as told:
        loaded_anew.undo()
    assert "list of notes" not in str(told.value)  # verdicts are not in it
    loaded_anew.judge(Judgement.FALSE)
    assert verdicts(place) == []


def test_something_new_said_ends_what_could_be_said_again(place: Place, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.undo()
    annotating.add_note("fog")
    with pytest.raises(UserError, match="nothing to redo"):
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


def missed(place: Place) -> list[tuple[float, float, str, WarningLevel]]:
    said = [entry.said for entry in place.review.review.missed]
    return [(one.start_s, one.end_s, one.text, one.level) for one in said]


def test_no_warning_is_missed_while_one_is_shown(place: Place, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    place.row = place.opened.row_at(WARNING_S)
    with pytest.raises(UserError, match="a warning is shown at this moment, so none was missed: judge"):
        annotating.add_missed()
    # Just before it there is none yet; what is missed ends where it begins.
    place.row = place.opened.row_at(CAUTION_S - 0.4)
    annotating.add_missed()
    assert missed(place) == [(CAUTION_S - 1.4, CAUTION_S, "", WarningLevel.WARNING)]
    # A warning is more than the advisory that is shown.
    place.row = place.opened.row_at(ADVISORY_S + 0.2)
    annotating.add_missed()
    assert len(missed(place)) == 2


def test_a_missed_event_is_changed_in_steps_that_are_taken_back_one_by_one(
    place: Place, annotating: Annotating
):
    place.row = place.opened.row_at(4.0)
    annotating.add_missed()

    def entry_id() -> str:
        return place.review.review.missed[-1].entry_id

    states = [missed(place)]
    place.row = place.opened.row_at(2.0)
    annotating.messages["missedstart"](entry_id())
    states.append(missed(place))
    annotating.messages["missedlevel"](f"{entry_id()} CAUTION")
    states.append(missed(place))
    annotating.messages["missedtext"](f"{entry_id()}: cyclist: from the right ")
    states.append(missed(place))
    assert states[-1] == [(2.0, 5.0, "cyclist: from the right", WarningLevel.CAUTION)]
    place.row = place.opened.row_at(1.0)
    with pytest.raises(UserError, match=r"cannot start at 2.00 s and end at 1.00 s"):
        annotating.messages["missedend"](entry_id())
    for state in reversed(states[:-1]):
        annotating.undo()
        assert missed(place) == state
    for state in states[1:]:
        annotating.redo()
        assert missed(place) == state
    annotating.undo()
    assert missed(place) == states[-2]


def test_what_is_marked_is_what_was_missed(place: Place, annotating: Annotating):
    place.mark(start_s=2.0)
    place.mark(end_s=6.5)
    annotating.add_missed()
    assert missed(place) == [(2.0, 6.5, "", WarningLevel.WARNING)]
    place.mark(end_s=4.0)
    annotating.messages["missedrange"](place.review.review.missed[-1].entry_id)
    assert missed(place) == [(2.0, 4.0, "", WarningLevel.WARNING)]
