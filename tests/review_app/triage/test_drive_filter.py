"""What is asked for is listed, and the next unjudged event is always one that nobody has judged."""

import re
from base64 import urlsafe_b64encode
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.annotation.records import Entry, Judgement, Verdict
from fcw.annotation.review import fold, judged_events, reference_to
from fcw.logs.events import DriveEvent
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.folder_list import folder_html
from fcw_viz.review_app.triage.drive_filter import (
    DISAGREED,
    UNJUDGED,
    VERDICTS,
    DriveFilter,
    Listed,
    Order,
    parse_filter,
)
from fcw_viz.review_app.triage.filter_bar import Choices, filter_html

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


filters = st.builds(
    DriveFilter,
    st.text(max_size=9),
    st.sampled_from(("", *KINDS)),
    st.sampled_from(("", *VERDICTS)),
    st.text(max_size=9),
    st.sampled_from(Order),
    st.text(max_size=9),
    st.sampled_from(("", "2026-11", "2026-11-20")),
    st.sampled_from(Listed),
)


@given(filters)
def test_what_is_asked_for_is_found_again_in_an_address(asked: DriveFilter):
    assert re.fullmatch(r"[\w-]*", asked.kept_text, re.ASCII)  # however often it is decoded
    assert parse_filter(asked.kept_text) == asked


@given(
    st.text(max_size=9)
    | st.sampled_from(("listed=all&order=&verdict=maybe", "&&==&text=", "%")).map(
        lambda query: urlsafe_b64encode(query.encode()).decode()
    )
)
def test_an_address_that_asks_for_nothing_that_there_is_leads_to_the_whole_list(text: str):
    asked = parse_filter(text)
    assert replace(asked, text="") == DriveFilter()


def test_what_was_asked_for_stands_in_its_field_also_before_the_folder_has_such_a_thing():
    asked = DriveFilter(reviewer="bert", camera="bus", listed=Listed.UNFINISHED)
    html = filter_html(asked, Choices(), False)
    for chosen in ("bert", "bus", "UNFINISHED"):
        assert f'<option value="{chosen}" selected>' in html


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


def test_how_many_match_the_filter_is_said_in_the_number_that_they_have():
    for text, words in (("bend", "1 matches the filter."), ("a", "2 match the filter."), ("x", "0 match")):
        assert f"<p>{words}" in folder_html("drives", CARDS, 0, 1000.0, DriveFilter(text))
    assert "the filter" not in folder_html("drives", CARDS, 0, 1000.0)


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


DAY_NS = 86_400 * 10**9
FLEET = tuple(
    replace(one, camera=camera, begun_utc_ns=None if day is None else 1_795_132_800 * 10**9 + day * DAY_NS)
    for one, camera, day in zip(CARDS, ("van", "bus", "van", "bus"), (0, 1, None, 12), strict=True)
)
"""The first one began on 2026-11-20."""


@pytest.mark.parametrize(
    ("asked", "names"),
    [
        (DriveFilter(camera="van"), ["Alps", "calm"]),
        (DriveFilter(date="2026-11"), ["Alps", "bend"]),
        (DriveFilter(date="2026-11-21"), ["bend"]),
        (DriveFilter(camera="bus", date="2026-12"), ["dusk"]),
    ],
)
def test_drives_are_listed_by_their_camera_and_date(asked: DriveFilter, names: list[str]):
    assert [one.name for one in asked.drives(FLEET)] == names


@pytest.mark.parametrize(
    ("asked", "moments"),
    [
        (DriveFilter(), [("Alps", 1), ("dusk", 0), ("bend", 0), ("Alps", 0), ("dusk", 1)]),
        (DriveFilter(kind="warning"), [("dusk", 0), ("Alps", 0), ("dusk", 1)]),
        (DriveFilter(camera="bus"), [("dusk", 0), ("bend", 0), ("dusk", 1)]),
        (
            DriveFilter(order=Order.UNJUDGED),
            [("Alps", 1), ("dusk", 1), ("dusk", 0), ("bend", 0), ("Alps", 0)],
        ),
        (DriveFilter(order=Order.NAME, date="2026-11"), [("Alps", 0), ("Alps", 1), ("bend", 0)]),
    ],
)
def test_moments_are_ranked_across_the_drives(asked: DriveFilter, moments: list[tuple[str, int]]):
    assert [(one.name, number) for one, number in asked.moments(FLEET)] == moments


def test_a_drive_whose_worst_event_is_a_caution_names_its_worst_warning_too():
    drive = card("bend", [("warning", 0.2), ("caution", 0.9), ("warning", 0.3)], {})

    def headlines(asked: DriveFilter) -> list[tuple[str, str]]:
        html = folder_html("drives", [drive], 0, 1000.0, asked)
        return re.findall(r'class="fcw-worst" (?:data-fcw="(.*?)")?.*?<b>(.*?)</b>', html)

    html = folder_html("drives", [drive], 0, 1000.0)
    assert "2 × warning, 1 × caution" in html
    assert 'data-fcw="open:bend#1"' in html.partition("fcw-worst")[0]
    assert headlines(DriveFilter()) == [("", "Caution at 10.0 s"), ("open:bend#2", "Warning at 20.0 s")]
    assert headlines(DriveFilter(kind="caution")) == [("", "Caution at 10.0 s")]
    assert headlines(DriveFilter(kind="warning")) == [("", "Warning at 20.0 s")]


def test_the_next_unjudged_moment_is_the_next_worst_one_of_any_drive():
    asked = DriveFilter(listed=Listed.MOMENTS)
    worst_first = [("Alps", 0.3, 0.9), ("dusk", 0.8, 0.2)]
    cards = [card(name, [("warning", one) for one in severities], {}) for name, *severities in worst_first]
    visited = [("dusk", 1)]  # the last one
    for _ in range(4):
        found = asked.next_unjudged(cards, *visited[-1])
        assert found is not None
        visited.append(found)
    assert visited[1:] == [("Alps", 1), ("dusk", 0), ("Alps", 0), ("dusk", 1)]


def test_months_stand_before_their_days_and_the_latest_first():
    choices = Choices.of(FLEET, ())
    assert choices.dates == ("2026-12", "2026-12-02", "2026-11", "2026-11-21", "2026-11-20")
    assert choices.cameras == ("bus", "van")
