"""What is asked for is listed, and the next unjudged event is always one that nobody has judged."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.annotation.records import Entry, Judgement, Verdict
from fcw.annotation.review import fold, judged_events, reference_to
from fcw.logs.events import DriveEvent
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.triage.drive_filter import DISAGREED, UNJUDGED, DriveFilter, Order

KINDS = ("warning", "caution", "near miss")


def event(number: int, kind: str, severity: float) -> DriveEvent:
    start_s = 10.0 * number
    return DriveEvent(kind, start_s, start_s + 2, start_s + 1, number, "", None, None, None, severity)  # type: ignore[arg-type]


def card(name: str, events: Sequence[tuple[str, float]], said: dict[tuple[int, str], Judgement]) -> DriveCard:
    """A drive with events, and who judged which of them how."""
    made = tuple(event(number, kind, severity) for number, (kind, severity) in enumerate(events))
    entries = [
        Entry(
            f"{number} {person}",
            "2026-11-20T10:00:00.000000Z",
            person,
            Verdict(reference_to(made[number]), one),
        )
        for (number, person), one in said.items()
    ]
    review = fold(entries)
    judged = judged_events(review, made)[0]
    return DriveCard(name, Path(name), 40.0, made, review=review, judged=judged)


CARDS = (
    card("Alps", [("warning", 0.3), ("caution", 0.9)], {(0, "anna"): Judgement.FALSE}),
    card("bend", [("near miss", 0.5)], {(0, "anna"): Judgement.RIGHT, (0, "bert"): Judgement.FALSE}),
    card("calm", [], {}),
    card("dusk", [("warning", 0.8), ("warning", 0.2)], {(0, "bert"): Judgement.RIGHT}),
)


@pytest.mark.parametrize(
    ("asked", "names"),
    [
        (DriveFilter(), ["Alps", "dusk", "bend", "calm"]),
        (DriveFilter(order=Order.NAME), ["Alps", "bend", "calm", "dusk"]),
        (DriveFilter(text="AL"), ["Alps", "calm"]),
        (DriveFilter(kind="warning"), ["Alps", "dusk"]),
        (DriveFilter(verdict="false"), ["Alps"]),
        (DriveFilter(verdict=DISAGREED), ["bend"]),
        (DriveFilter(verdict=UNJUDGED), ["Alps", "dusk"]),
        (DriveFilter(reviewer="bert"), ["dusk", "bend"]),
        (DriveFilter(kind="warning", verdict="right", reviewer="bert"), ["dusk"]),
        (DriveFilter(kind="caution", verdict="false"), []),
    ],
)
def test_drives_are_listed_that_have_an_event_as_asked_for(asked: DriveFilter, names: list[str]):
    assert [one.name for one in asked.drives(CARDS)] == names


def test_the_next_unjudged_event_comes_from_this_drive_first_then_from_the_next():
    asked = DriveFilter()
    assert asked.next_unjudged(CARDS, None, None) == ("Alps", 1)
    assert asked.next_unjudged(CARDS, "Alps", 1) == ("dusk", 1)
    assert asked.next_unjudged(CARDS, "dusk", 0) == ("dusk", 1)
    assert asked.next_unjudged(CARDS, "dusk", 1) == ("Alps", 1)
    assert DriveFilter(kind="near miss").next_unjudged(CARDS, "bend", 0) is None


JUDGED = st.dictionaries(
    st.tuples(st.integers(0, 4), st.sampled_from(["anna", "bert"])), st.sampled_from(Judgement), max_size=6
)
DRIVES = st.lists(
    st.tuples(st.lists(st.tuples(st.sampled_from(KINDS), st.floats(0, 1)), min_size=5, max_size=5), JUDGED),
    max_size=4,
)


@given(drives=DRIVES, kind=st.sampled_from(["", *KINDS]), data=st.data())
def test_judging_one_after_the_other_comes_to_every_event_once(drives, kind: str, data: st.DataObject):
    said = [dict(judged) for _, judged in drives]
    asked = DriveFilter(kind=kind, verdict=data.draw(st.sampled_from(["", UNJUDGED])))

    def cards() -> list[DriveCard]:
        return [card(str(k), events, said[k]) for k, (events, _) in enumerate(drives)]

    open_ones = {
        (one.name, number)
        for one in cards()
        for number, judged in enumerate(one.judged)
        if not judged.verdicts and kind in ("", judged.event.kind)
    }
    visited: list[tuple[str, int]] = []
    place = asked.next_unjudged(cards(), None, None)
    while place is not None:
        visited.append(place)
        said[int(place[0])][(place[1], "anna")] = Judgement.RIGHT
        place = asked.next_unjudged(cards(), *place)
    assert len(visited) == len(set(visited))
    assert set(visited) == open_ones
