"""Verdicts as labelled events, by which the warnings of this log, or of another run, are measured.

What people judged right, too early or too late is an event: a warning was due there. What they judged false
is none, and what they added as missed is one. Warnings that nobody judged, or that people judge differently,
are no labels.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fcw.annotation.records import Judgement, MissedEvent
from fcw.annotation.review import JudgedEvent, Review, judged_events
from fcw.evaluation.warning.events import Event
from fcw.logs.events import DriveEvent
from fcw.warning.types import WarningLevel

LEVEL_OF_KIND = {level.name.lower(): level for level in WarningLevel if level}
"""The kinds of events that are warnings; of the others (near misses, a moved mount) a verdict is no label."""


@dataclass(frozen=True, slots=True)
class WarningLabels:
    """What a review says of a drive's warnings.

    Attributes:
        events: the labels, by their start.
        judgements: how many warnings are judged each way by all who judged them.
        disagreements: the warnings that people judge differently.
        lost: how many verdicts are on warnings that are not found in the log any more.
    """

    events: tuple[Event, ...]
    judgements: Mapping[Judgement, int]
    disagreements: tuple[JudgedEvent, ...]
    lost: int


def warning_labels(review: Review, events: Sequence[DriveEvent]) -> WarningLabels:
    """The labels that a review of a drive gives.

    Args:
        review: what people say.
        events: of the reviewed log, from `find_events`.
    """
    judged, lost = judged_events(review, events)
    warnings = [one for one in judged if one.event.kind in LEVEL_OF_KIND]
    labels = [
        Event(
            one.event.start_s,
            one.event.end_s,
            LEVEL_OF_KIND[one.event.kind],
            one.judgement is not Judgement.FALSE,
        )
        for one in warnings
        if one.judgement is not None
    ]
    labels += _united([entry.said for entry in review.missed])
    return WarningLabels(
        tuple(sorted(labels, key=lambda label: (label.start_s, label.end_s, label.level))),
        Counter(one.judgement for one in warnings if one.judgement is not None),
        tuple(one for one in warnings if one.disagreement),
        len(lost),
    )


def _united(missed: Sequence[MissedEvent]) -> list[Event]:
    """Missed events, those that share time as one: two people saw the same."""
    united: list[Event] = []
    for one in sorted(missed, key=lambda one: one.start_s):
        if united and one.start_s <= united[-1].end_s:
            last = united.pop()
            united.append(Event(last.start_s, max(last.end_s, one.end_s), max(last.level, one.level)))
        else:
            united.append(Event(one.start_s, one.end_s, one.level))
    return united
