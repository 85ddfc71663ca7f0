"""Which of the drives and events somebody wants to see, and in which order."""

from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from itertools import chain
from urllib.parse import parse_qs, urlencode

from fcw.annotation.records import Judgement
from fcw.annotation.review import JudgedEvent
from fcw.batch.ledger import Record
from fcw_viz.review_app.drive import by_severity
from fcw_viz.review_app.drive_card import DriveCard, list_key

UNJUDGED, DISAGREED = "unjudged", "judged differently"
VERDICTS = (UNJUDGED, *(one.value for one in Judgement), DISAGREED)
"""What can be asked of an event's verdicts."""


class Listed(Enum):
    """What the list is of; the value is for a person."""

    DRIVES = "drives"
    MOMENTS = "moments"
    UNFINISHED = "drives not done"


class Order(Enum):
    """Of the drives, or of the moments; the value is for a person."""

    WORST = "worst first"
    UNJUDGED = "most unjudged first"
    NAME = "by name"
    LONGEST = "longest first"


@dataclass(frozen=True, slots=True)
class DriveFilter:
    """What is asked for; an empty text asks for nothing.

    Attributes:
        text: in the drive's name, whatever its case.
        kind: of an event.
        verdict: of `VERDICTS`, on that event.
        reviewer: who judged that event.
        order: of the drives.
        camera: of the drive.
        date: the day on which the drive began, or the month: 2026-11.
        listed: what the list is of.
    """

    text: str = ""
    kind: str = ""
    verdict: str = ""
    reviewer: str = ""
    order: Order = Order.WORST
    camera: str = ""
    date: str = ""
    listed: Listed = Listed.DRIVES

    @property
    def kept_text(self) -> str:
        """By which `parse_filter` finds it again; empty where nothing is asked for.

        Of letters that mean nothing in an address: viser decodes the page's own when it starts.
        """
        said = {
            one.name: getattr(self, one.name)
            for one in fields(self)
            if getattr(self, one.name) != one.default
        }
        names = {name: one.name if isinstance(one, Enum) else one for name, one in said.items()}
        return urlsafe_b64encode(urlencode(names, errors="replace").encode()).decode().rstrip("=")

    def passes(self, judged: JudgedEvent) -> bool:
        """Whether an event is asked for."""
        if self.kind and judged.event.kind != self.kind:
            return False
        if self.reviewer and self.reviewer not in {entry.person for entry in judged.verdicts}:
            return False
        if self.verdict == UNJUDGED:
            return not judged.verdicts
        if self.verdict == DISAGREED:
            return judged.disagreement
        return not self.verdict or (judged.judgement is not None and judged.judgement.value == self.verdict)

    def numbers(self, card: DriveCard) -> list[int]:
        """Numbers of the events of a drive that are asked for, the worst first."""
        return [number for number in by_severity(card.events) if self.passes(card.judged[number])]

    def drives(self, cards: Sequence[DriveCard]) -> list[DriveCard]:
        """The drives that are asked for: where something is asked of events, those that have such a one."""
        about_events = bool(self.kind or self.verdict or self.reviewer)
        found = [
            card
            for card in cards
            if self._has_drive(card.name, card.camera)
            and card.date.startswith(self.date)
            and (not about_events or any(map(self.passes, card.judged)))
        ]
        keys = {
            Order.WORST: list_key,
            Order.UNJUDGED: lambda card: (-sum(not one.verdicts for one in card.judged), list_key(card)),
            Order.NAME: lambda card: card.name.casefold(),
            Order.LONGEST: lambda card: -card.duration_s,
        }
        return sorted(found, key=keys[self.order])

    def moments(self, cards: Sequence[DriveCard]) -> list[tuple[DriveCard, int]]:
        """Events of all drives that are asked for, with their drives; the most severe first, or in another
        order."""
        found = [
            (card, number)
            for card in self.drives(cards)
            for number, one in enumerate(card.judged)
            if self.passes(one)
        ]
        if self.order is Order.WORST:
            return sorted(found, key=_by_severity)
        if self.order is Order.UNJUDGED:
            return sorted(found, key=lambda one: (bool(one[0].judged[one[1]].verdicts), _by_severity(one)))
        if self.order is Order.LONGEST:
            return sorted(found, key=lambda one: -_duration_s(one))
        return found

    def unfinished(self, records: Sequence[Record]) -> list[Record]:
        """Drives that a batch has not done, of those that are asked for."""
        return [record for record in records if self._has_drive(record.name, record.camera)]

    def next_unjudged(
        self, cards: Sequence[DriveCard], name: str | None, after: int | None
    ) -> tuple[str, int] | None:
        """The next event that nobody has judged: in this drive, else in the next one of the list, around it;
        in the list of moments the next one of that.

        Args:
            cards: all drives.
            name: of the drive somebody is in; None for none.
            after: the event they are at, which comes last.
        """
        if self.listed is Listed.MOMENTS:
            moments = self.moments(cards)
            at = next((k for k, (card, n) in enumerate(moments, 1) if (card.name, n) == (name, after)), 0)
            return _first_unjudged(chain(moments[at:], moments[:at]))
        drives = [card for card in self.drives(cards) if card.read and not card.trouble]
        here = next((k for k, card in enumerate(drives) if card.name == name), None)
        first: list[int] = []
        at = 0
        if here is not None:
            first = self.numbers(drives[here])
            # Its verdict may have taken the event out of what is asked for: go on with this drive.
            at = first.index(after) + 1 if after in first else 0
        others = drives if here is None else drives[here + 1 :] + drives[:here]
        # Most of a long list is never looked at.
        return _first_unjudged(
            chain(
                ((drives[here or 0], number) for number in first[at:]),
                ((card, number) for card in others for number in self.numbers(card)),
                ((drives[here or 0], number) for number in first[:at]),
            )
        )

    def _has_drive(self, name: str, camera: str) -> bool:
        return self.text.casefold() in name.casefold() and self.camera in ("", camera)


def parse_filter(text: str) -> DriveFilter:
    """What a text asks for; what it says that nobody can ask for is left out."""
    try:
        query = urlsafe_b64decode(text + "==").decode()
    except ValueError:  # somebody has written into the address
        query = ""
    said = defaultdict(str, {name: values[-1] for name, values in parse_qs(query).items()})
    return DriveFilter(
        said["text"],
        said["kind"],
        said["verdict"] if said["verdict"] in VERDICTS else "",
        said["reviewer"],
        Order.__members__.get(said["order"], Order.WORST),
        said["camera"],
        said["date"],
        Listed.__members__.get(said["listed"], Listed.DRIVES),
    )


def _first_unjudged(places: Iterable[tuple[DriveCard, int]]) -> tuple[str, int] | None:
    return next(((card.name, number) for card, number in places if not card.judged[number].verdicts), None)


def _by_severity(place: tuple[DriveCard, int]) -> tuple[float, str, int]:
    card, number = place
    return -card.events[number].severity, card.name, number


def _duration_s(place: tuple[DriveCard, int]) -> float:
    event = place[0].events[place[1]]
    return event.end_s - event.start_s
