"""The state of a drive's review, computed from the entries of all people, in whatever order they come."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fcw.annotation.records import (
    BoxEdit,
    Entry,
    EventReference,
    FrameConfirmed,
    Judgement,
    LabelledBox,
    MissedEvent,
    Note,
    Said,
    SaidT_co,
    TakenBack,
    Verdict,
)
from fcw.logs.events import DriveEvent

FOUND_AGAIN_WITHIN_S = 1.0
"""How far an event of the same vehicle may be from the one that was judged; refined rules move it less."""


@dataclass(frozen=True, slots=True)
class FrameReview:
    """What was said about the boxes of one frame.

    Attributes:
        edits: by box id, the last edit of each person, oldest first.
        confirmed: who said that all boxes are right.
    """

    edits: Mapping[str, tuple[Entry[BoxEdit], ...]]
    confirmed: tuple[Entry[FrameConfirmed], ...]

    @property
    def labels(self) -> dict[str, LabelledBox | None]:
        """Each edited box as the last person left it; None if it was deleted."""
        return {box_id: edits[-1].said.label for box_id, edits in self.edits.items()}


@dataclass(frozen=True, slots=True)
class Review:
    """What counts of everything that was said; each tuple is sorted by time, oldest first.

    Attributes:
        entries: everything that was not taken back.
        verdicts: the last one of each person on each event; those of two people are both kept.
        missed: the missed events.
        notes: the notes.
        frames: the frames about which somebody said something, by index.
    """

    entries: tuple[Entry[Said], ...] = ()
    verdicts: tuple[Entry[Verdict], ...] = ()
    missed: tuple[Entry[MissedEvent], ...] = ()
    notes: tuple[Entry[Note], ...] = ()
    frames: Mapping[int, FrameReview] = field(default_factory=dict)

    @property
    def people(self) -> tuple[str, ...]:
        """Who said something that counts, by name."""
        return tuple(sorted({entry.person for entry in self.entries}))


@dataclass(frozen=True, slots=True)
class JudgedEvent:
    """An event of the log and the verdicts on it.

    Attributes:
        event: the event.
        verdicts: one of each person who judged it, oldest first.
    """

    event: DriveEvent
    verdicts: tuple[Entry[Verdict], ...]

    @property
    def disagreement(self) -> bool:
        """Whether people judge it differently."""
        return len({entry.said.judgement for entry in self.verdicts}) > 1

    @property
    def judgement(self) -> Judgement | None:
        """The common judgement of all who judged it; None if nobody did, or they disagree."""
        return self.verdicts[-1].said.judgement if self.verdicts and not self.disagreement else None


def fold(entries: Iterable[Entry[Said]]) -> Review:
    """Compute the review from entries; neither their order nor repetitions change it."""
    in_order = sorted({entry.entry_id: entry for entry in entries}.values(), key=_moment)
    counting = _not_taken_back(in_order)
    verdicts: dict[Any, Entry[Verdict]] = {}
    frames: dict[int, tuple[dict[str, dict[str, Entry[BoxEdit]]], dict[str, Entry[FrameConfirmed]]]] = {}
    for entry in _of_kind(counting, Verdict):
        _put_last(verdicts, (entry.person, entry.said.event), entry)
    for entry in _of_kind(counting, BoxEdit):
        boxes, _ = frames.setdefault(entry.said.frame_index, ({}, {}))
        _put_last(boxes.setdefault(entry.said.box_id, {}), entry.person, entry)
    for entry in _of_kind(counting, FrameConfirmed):
        _, confirmed = frames.setdefault(entry.said.frame_index, ({}, {}))
        _put_last(confirmed, entry.person, entry)
    return Review(
        tuple(counting),
        tuple(verdicts.values()),
        _of_kind(counting, MissedEvent),
        _of_kind(counting, Note),
        {
            index: FrameReview(
                {box_id: tuple(edits.values()) for box_id, edits in sorted(boxes.items())},
                tuple(confirmed.values()),
            )
            for index, (boxes, confirmed) in sorted(frames.items())
        },
    )


def judged_events(
    review: Review, events: Sequence[DriveEvent]
) -> tuple[tuple[JudgedEvent, ...], tuple[Entry[Verdict], ...]]:
    """Every event with its verdicts, and the verdicts whose event is not found any more."""
    found: list[dict[str, Entry[Verdict]]] = [{} for _ in events]
    lost = []
    for entry in review.verdicts:
        index = find_event(entry.said.event, events)
        if index is None:
            lost.append(entry)
        else:
            _put_last(found[index], entry.person, entry)
    judged = (
        JudgedEvent(event, tuple(verdicts.values())) for event, verdicts in zip(events, found, strict=True)
    )
    return tuple(judged), tuple(lost)


def verdicts_of(
    person: str, event: int, review: Review, events: Sequence[DriveEvent]
) -> list[Entry[Verdict]]:
    """All verdicts of a person on an event that were not taken back, oldest first.

    Only the last one counts; if it is taken back, the one before counts again.
    """
    return [
        entry
        for entry in _of_kind(review.entries, Verdict)
        if entry.person == person and find_event(entry.said.event, events) == event
    ]


def find_event(reference: EventReference, events: Sequence[DriveEvent]) -> int | None:
    """The index of the event that a verdict was about; None if it is not found.

    It is the event of the same kind and track with the same start. If there is none, because the rules for
    events have changed, it is the one that shares most time with it, preferably of the same track. An event
    of another track must share some time with it; one of the same track may be up to a second away.
    """
    best, best_rank = None, None
    for index, event in enumerate(events):
        if event.kind != reference.kind:
            continue
        same_track = event.track_id == reference.track_id
        shared_s = min(event.end_s, reference.end_s) - max(event.start_s, reference.start_s)
        if shared_s < (-FOUND_AGAIN_WITHIN_S if same_track else 0.0):
            continue
        rank = (same_track, same_track and event.start_s == reference.start_s, shared_s)
        if best_rank is None or rank > best_rank:
            best, best_rank = index, rank
    return best


def reference_to(event: DriveEvent) -> EventReference:
    """The reference to an event that a verdict stores."""
    return EventReference(event.kind, event.track_id, event.start_s, event.end_s)


def _not_taken_back(in_order: Sequence[Entry[Said]]) -> list[Entry[Said]]:
    """The entries that count, read from the last to the first.

    So it is known whether a `TakenBack` counts before the entry that it takes back is reached.
    """
    taken_back: set[tuple[str, str]] = set()
    counting = []
    for entry in reversed(in_order):
        if (entry.person, entry.entry_id) in taken_back:
            continue
        counting.append(entry)
        if isinstance(entry.said, TakenBack):
            taken_back.add((entry.person, entry.said.entry_id))
    return counting[::-1]


def _of_kind(entries: Sequence[Entry[Said]], kind: type[SaidT_co]) -> tuple[Entry[SaidT_co], ...]:
    return tuple(entry for entry in entries if isinstance(entry.said, kind))  # pyright: ignore[reportReturnType]


def _put_last(into: dict[Any, Entry[SaidT_co]], key: object, entry: Entry[SaidT_co]) -> None:
    """Replace an earlier entry, and move it behind all others."""
    into.pop(key, None)
    into[key] = entry


def _moment(entry: Entry[Said]) -> tuple[str, str]:
    return entry.time, entry.entry_id
