"""The line over the list of drives: what somebody asks for."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from html import escape

from fcw_viz.page.channel import chooses, says, tells_typed
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.triage.drive_filter import VERDICTS, DriveFilter, Order
from fcw_viz.review_app.words import KIND_TITLES


def filter_html(asked: DriveFilter, people: Iterable[str], goes_on: bool) -> str:
    """The fields, with what is asked for now; what changes in them says so by itself."""
    kinds = {"": "all kinds"} | KIND_TITLES
    verdicts = {"": "all verdicts"} | {verdict: verdict for verdict in VERDICTS}
    reviewers = {"": "all reviewers"} | {person: person for person in people}
    orders = {order.name: order.value for order in Order}
    return (
        '<div class="fcw-filter">'
        f'<input type="search" {tells_typed("fcw-search", "search")} value="{escape(asked.text)}" '
        'placeholder="Search names" autocomplete="off">'
        f"{_select('filterkind', kinds, asked.kind)}{_select('filterverdict', verdicts, asked.verdict)}"
        f"{_select('filterby', reviewers, asked.reviewer)}{_select('sortdrives', orders, asked.order.name)}"
        f'<button {says("unjudged:")} title="Next unjudged event (U)">Next unjudged</button>'
        f"{goes_on_html(goes_on)}</div>"
    )


def reviewers(cards: Iterable[DriveCard]) -> tuple[str, ...]:
    """Who has said something of any drive, by name."""
    return tuple(sorted({person for card in cards for person in card.review.people}))


def goes_on_html(goes_on: bool) -> str:
    """The switch by which a verdict leads to the next unjudged event."""
    state = "on" if goes_on else ""
    title = "Go to the next event after each verdict (G)"
    return f'<button class="{state}" {says("goeson:")} title="{title}">Auto-next</button>'


def filter_messages(
    asked: Callable[[], DriveFilter], ask: Callable[[DriveFilter], object]
) -> Mapping[str, Callable[[str], object]]:
    """What the fields say, and what is asked for then.

    Args:
        asked: what is asked for now.
        ask: takes what is asked for instead.
    """
    return {
        "search": lambda about: ask(replace(asked(), text=about)),
        "filterkind": lambda about: ask(replace(asked(), kind=about)),
        "filterverdict": lambda about: ask(replace(asked(), verdict=about)),
        "filterby": lambda about: ask(replace(asked(), reviewer=about)),
        "sortdrives": lambda about: ask(replace(asked(), order=Order[about])),
    }


def _select(name: str, choices: Mapping[str, str], chosen: str) -> str:
    options = "".join(
        f'<option value="{escape(value)}"{" selected" * (value == chosen)}>{escape(words)}</option>'
        for value, words in choices.items()
    )
    return f"<select {chooses(name)}>{options}</select>"
