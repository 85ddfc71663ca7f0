"""The line over the list of drives: what somebody asks for."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from html import escape

from fcw.batch.ledger import Record
from fcw_viz.page.channel import chooses, says, tells_typed
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.triage.drive_filter import VERDICTS, DriveFilter, Listed, Order
from fcw_viz.review_app.words import KIND_TITLES

MONTH_LETTERS = len("2026-11")


@dataclass(frozen=True, slots=True)
class Choices:
    """What there is to choose from, besides what every folder has.

    Attributes:
        reviewers: who has said something of any drive.
        cameras: of the drives; none where no batch noted them.
        dates: months and days on which drives began, the latest first.
        unfinished: whether a batch has not done some drives.
    """

    reviewers: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    dates: tuple[str, ...] = ()
    unfinished: bool = False

    @classmethod
    def of(cls, cards: Collection[DriveCard], unfinished: Collection[Record]) -> "Choices":
        """Those of a folder.

        Args:
            cards: its drives.
            unfinished: drives that a batch has not done.
        """
        days = {card.date for card in cards} - {""}
        cameras = {one.camera for one in (*cards, *unfinished)} - {""}
        return cls(
            tuple(sorted({person for card in cards for person in card.review.people})),
            tuple(sorted(cameras)),
            # A month stands before its days.
            tuple(sorted(days | {day[:MONTH_LETTERS] for day in days}, key=_latest_first)),
            bool(unfinished),
        )


def filter_html(asked: DriveFilter, choices: Choices, goes_on: bool) -> str:
    """The fields, with what is asked for now; what changes in them says so by itself."""
    unfinished = choices.unfinished or asked.listed is Listed.UNFINISHED
    lists = {one.name: one.value for one in Listed if unfinished or one is not Listed.UNFINISHED}
    kinds = {"": "all kinds"} | KIND_TITLES
    verdicts = {"": "all verdicts"} | {verdict: verdict for verdict in VERDICTS}
    people = {"": "all reviewers"} | {person: person for person in choices.reviewers}
    places = ""
    if choices.cameras or asked.camera:
        cameras = {"": "all cameras"} | {camera: camera for camera in choices.cameras}
        places += _select("filtercamera", cameras, asked.camera)
    if choices.dates or asked.date:
        places += _select("filterdate", {"": "all days"} | {one: one for one in choices.dates}, asked.date)
    orders = {order.name: order.value for order in Order}
    return (
        f'<div class="fcw-filter{" more" if places else ""}">{_select("listed", lists, asked.listed.name)}'
        f'<input type="search" {tells_typed("fcw-search", "search")} value="{escape(asked.text)}" '
        'placeholder="Search names" autocomplete="off">'
        f"{_select('filterkind', kinds, asked.kind)}{_select('filterverdict', verdicts, asked.verdict)}"
        f"{_select('filterby', people, asked.reviewer)}{places}"
        f"{_select('sortdrives', orders, asked.order.name)}"
        f'<button {says("unjudged:")} title="Next unjudged event (U)">Next unjudged</button>'
        f"{goes_on_html(goes_on)}</div>"
    )


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
        "filtercamera": lambda about: ask(replace(asked(), camera=about)),
        "filterdate": lambda about: ask(replace(asked(), date=about)),
        "listed": lambda about: ask(replace(asked(), listed=Listed[about])),
        "filterby": lambda about: ask(replace(asked(), reviewer=about)),
        "sortdrives": lambda about: ask(replace(asked(), order=Order[about])),
    }


def _latest_first(date: str) -> tuple[int, ...]:
    return tuple(-int(part) for part in date.split("-"))


def _select(name: str, choices: Mapping[str, str], chosen: str) -> str:
    """A list to choose from; what was chosen stands in it though there is no such choice any more, or yet."""
    choices = {**choices, chosen: choices.get(chosen, chosen)}
    options = "".join(
        f'<option value="{escape(value)}"{" selected" * (value == chosen)}>{escape(words)}</option>'
        for value, words in choices.items()
    )
    return f"<select {chooses(name)}>{options}</select>"
