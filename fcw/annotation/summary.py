"""Summary of the reviews of many drives: warnings per hour, how many were judged false, and why."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from scipy.special import ndtri

from fcw.annotation.records import Judgement, Reason
from fcw.annotation.review import JudgedEvent, judged_events
from fcw.annotation.store import read_review
from fcw.annotation.warning_labels import LEVEL_OF_KIND
from fcw.errors import UserError
from fcw.logs.events import find_events, seen_s
from fcw.logs.mcap.reader import DriveLog
from fcw.warning.types import WarningLevel

CONFIDENCE = 0.95
QUANTILE = float(ndtri(0.5 + CONFIDENCE / 2))
"""Of the standard normal, so that this share lies within as many sigmas of zero."""

Reasons = Mapping[tuple[Judgement, Reason | None], int]
"""Number of warnings by wrong judgement and reason; the reason is None if nobody gave one."""


@dataclass(frozen=True, slots=True)
class Tally:
    """The warnings of one level in one or several drives.

    Attributes:
        hours: how long something could be seen, so that a warning could be given.
        warnings: number of warnings that were shown.
        judgements: numbers of warnings that all judged alike, by the judgement.
        disagreements: number of warnings that people judged differently.
        missed: number of missed warnings that people added.
        reasons: why warnings were judged wrong.
    """

    hours: float
    warnings: int
    judgements: Mapping[Judgement, int]
    disagreements: int
    missed: int
    reasons: Reasons

    @property
    def per_hour(self) -> float | None:
        """Warnings per hour; None if nothing could be seen."""
        return self.warnings / self.hours if self.hours > 0 else None

    @property
    def judged(self) -> int:
        """How many warnings are judged, and not differently by different people."""
        return sum(self.judgements.values())

    @property
    def unjudged(self) -> int:
        """How many warnings nobody judged."""
        return self.warnings - self.judged - self.disagreements

    @property
    def judged_false(self) -> int:
        """How many of them are judged false."""
        return self.judgements.get(Judgement.FALSE, 0)

    @property
    def share_false(self) -> float | None:
        """Part of the judged ones that is judged false; None where none is judged."""
        return self.judged_false / self.judged if self.judged else None

    @property
    def share_false_interval(self) -> tuple[float, float] | None:
        """Wilson's 95 % interval of that part (Wilson 1927), were the judged ones drawn at random."""
        if not self.judged:
            return None
        share, weight = self.judged_false / self.judged, QUANTILE**2 / self.judged
        middle = (share + weight / 2) / (1 + weight)
        half = math.sqrt(weight * (share * (1 - share) + weight / 4)) / (1 + weight)
        return max(middle - half, 0.0), min(middle + half, 1.0)


@dataclass(frozen=True, slots=True)
class DriveReview:
    """What the review of a drive comes to.

    Attributes:
        name: what to call it.
        path: its log.
        tallies: by level.
        people: who reviewed it.
        lost_verdicts: how many are on warnings that are not found in the log any more.
        troubles: what a person should be told of the files.
    """

    name: str
    path: Path
    tallies: Mapping[WarningLevel, Tally]
    people: tuple[str, ...]
    lost_verdicts: int
    troubles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReviewSummary:
    """What the reviews of many drives come to.

    Attributes:
        drives: in the order in which they were given.
        all: of all of them together, by level.
        left_out: what was wrong with the drives that could not be read.
    """

    drives: tuple[DriveReview, ...]
    all: Mapping[WarningLevel, Tally]
    left_out: tuple[str, ...]


def summarise(drives: Mapping[str, Path], on_drive: Callable[[], None] = lambda: None) -> ReviewSummary:
    """Sum up the reviews beside drive logs.

    Args:
        drives: the logs by the names to call them.
        on_drive: called after each.

    Raises:
        UserError: none of them can be read.
    """
    reviews, errors = [], []
    for name, path in drives.items():
        try:
            reviews.append(_drive_review(name, path))
        except UserError as error:
            errors.append(error)
        on_drive()
    if errors and not reviews:
        raise errors[0]
    return ReviewSummary(
        tuple(reviews),
        {level: _together(review.tallies[level] for review in reviews) for level in LEVEL_OF_KIND.values()},
        tuple(map(str, errors)),
    )


def _drive_review(name: str, path: Path) -> DriveReview:
    log = DriveLog(path)
    review, troubles = read_review(log)
    series = log.series()
    events = find_events(series)
    judged, lost = judged_events(review, events)
    time_s = seen_s(series.duration_s, events)
    missed = Counter(entry.said.level for entry in review.missed)
    tallies = {
        level: _tally([one for one in judged if one.event.kind == kind], time_s, missed[level])
        for kind, level in LEVEL_OF_KIND.items()
    }
    return DriveReview(name, path, tallies, review.people, len(lost), troubles)


def _tally(warnings: list[JudgedEvent], time_s: float, missed: int) -> Tally:
    return Tally(
        hours=time_s / 3600,
        warnings=len(warnings),
        judgements=Counter(one.judgement for one in warnings if one.judgement is not None),
        disagreements=sum(one.disagreement for one in warnings),
        missed=missed,
        reasons=Counter(
            (one.judgement, _reason(one)) for one in warnings if one.judgement not in (None, Judgement.RIGHT)
        ),
    )


def _reason(warning: JudgedEvent) -> Reason | None:
    """The last one that somebody gave."""
    given = [entry.said.reason for entry in warning.verdicts if entry.said.reason is not None]
    return given[-1] if given else None


def _together(tallies: Iterable[Tally]) -> Tally:
    tallies = list(tallies)
    return Tally(
        sum(tally.hours for tally in tallies),
        sum(tally.warnings for tally in tallies),
        sum((Counter(tally.judgements) for tally in tallies), Counter()),
        sum(tally.disagreements for tally in tallies),
        sum(tally.missed for tally in tallies),
        sum((Counter(tally.reasons) for tally in tallies), Counter()),
    )
