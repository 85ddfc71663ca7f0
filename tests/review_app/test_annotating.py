"""Verdicts of a tab: given, changed, taken back and given again."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from fcw.annotation.records import Judgement, Reason
from fcw.errors import UserError
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.session import ReviewSession


@dataclass
class FakeTab:
    """A tab without a browser."""

    session: ReviewSession
    opened: Drive
    selected: int | None = 0
    time_s: float = 9.0
    told: list[str] = field(default_factory=list)

    @property
    def review(self) -> Any:
        return self.session.review(self.opened.name)

    @property
    def judged(self) -> Any:
        return None if self.selected is None else self.review.events[self.selected]

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        self.told.append(title)


@pytest.fixture
def tab(drive_log: Path, tmp_path: Path) -> Iterator[FakeTab]:
    session = ReviewSession({"made": Path(shutil.copy(drive_log, tmp_path))}, "anna")
    yield FakeTab(session, session.open("tab", "made"))
    session.close()


@pytest.fixture
def annotating(tab: FakeTab) -> Annotating:
    return Annotating(tab)  # pyright: ignore[reportArgumentType]


def verdicts(tab: FakeTab) -> list[tuple[Judgement, Reason | None, str]]:
    return [
        (entry.said.judgement, entry.said.reason, entry.said.text) for entry in tab.review.review.verdicts
    ]


def test_a_verdict_with_its_reason_and_words_is_one_verdict(tab: FakeTab, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.give_reason(Reason.CURVE)
    annotating.explain(" left bend ")
    assert verdicts(tab) == [(Judgement.FALSE, Reason.CURVE, "left bend")]


def test_another_verdict_takes_its_place_without_the_reason_that_was_for_the_first(
    tab: FakeTab, annotating: Annotating
):
    annotating.judge(Judgement.FALSE)
    annotating.give_reason(Reason.CURVE)
    annotating.judge(Judgement.TOO_LATE)
    assert verdicts(tab) == [(Judgement.TOO_LATE, None, "")]


def test_the_same_verdict_again_takes_it_back(tab: FakeTab, annotating: Annotating):
    annotating.judge(Judgement.RIGHT)
    annotating.judge(Judgement.RIGHT)
    assert verdicts(tab) == []


def test_undo_goes_back_word_by_word_and_redo_on_again(tab: FakeTab, annotating: Annotating):
    states = [verdicts(tab)]
    for step in (
        lambda: annotating.judge(Judgement.FALSE),
        lambda: annotating.give_reason(Reason.PARKED),
        lambda: annotating.judge(Judgement.RIGHT),
    ):
        step()
        states.append(verdicts(tab))
    for state in reversed(states[:-1]):
        annotating.undo()
        assert verdicts(tab) == state
    with pytest.raises(UserError, match="nothing to undo"):
        annotating.undo()
    for state in states[1:]:
        annotating.redo()
        assert verdicts(tab) == state
    with pytest.raises(UserError, match="nothing to do again"):
        annotating.redo()
    annotating.undo()
    assert verdicts(tab) == states[-2]


def test_something_new_said_ends_what_could_be_said_again(tab: FakeTab, annotating: Annotating):
    annotating.judge(Judgement.FALSE)
    annotating.undo()
    annotating.add_note("fog")
    with pytest.raises(UserError, match="nothing to do again"):
        annotating.redo()


def test_a_missed_event_stays_inside_the_drive(tab: FakeTab, annotating: Annotating):
    tab.time_s = 0.2
    annotating.add_missed("child on the road")
    (entry,) = tab.review.review.missed
    assert (entry.said.start_s, entry.said.end_s) == (0.0, 1.2)


@pytest.mark.parametrize("act", ["judge", "reason"])
def test_without_an_event_or_a_verdict_the_person_is_told_what_to_do_first(
    tab: FakeTab, annotating: Annotating, act: str
):
    if act == "judge":
        tab.selected = None
        with pytest.raises(UserError, match="select an event first"):
            annotating.judge(Judgement.RIGHT)
    else:
        with pytest.raises(UserError, match="give a verdict first"):
            annotating.give_reason(Reason.CURVE)
