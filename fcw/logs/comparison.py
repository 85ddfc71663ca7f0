"""Where two runs over one source differ: two detectors, two policies, two calibrations.

What differs is found in the two runs' columns: a warning that only one of them shows, or shows sooner, a lead
that only one of them has, or another one, and a distance that is another by more than either of them allows
for.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fcw.logs.events import find_events
from fcw.logs.series import NO_TRACK, DriveSeries
from fcw.warning.types import WarningLevel

SHORTEST_S = 0.2
"""What is gone sooner is noise of a box."""
JOINED_S = 0.5
"""Differences of one kind so near to each other are one."""
SAME_WARNING_S = 0.5
"""A warning that the other run gives so soon before or after begins at the same time."""
LEAST_OVERLAP = 0.3
"""Intersection over union of two runs' boxes of one vehicle: detectors draw them differently."""

_LEVELS = {
    "warning": WarningLevel.WARNING,
    "caution": WarningLevel.CAUTION,
    "advisory": WarningLevel.ADVISORY,
}


class DifferenceKind(StrEnum):
    """What differs."""

    WARNING = "warning"
    """One of them showed a warning, the other one none as urgent, or not yet."""
    LEAD = "lead"
    """One of them has a lead, the other one none, or another vehicle."""
    DISTANCE = "distance"
    """Both have the same lead, at distances whose intervals do not touch."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One stretch of time in which two runs differ; times from the first run's first frame.

    Attributes:
        kind: what differs.
        start_s: its first frame.
        end_s: its last frame.
        peak_s: where it differs most.
        first_has: whether the first run shows the warning, or has the lead; None where both have one.
        first_level: the highest level that the first run shows in that time.
        second_level: the same of the second run.
        first_m: the lead's distance in the first run where it differs most; None where it has none.
        second_m: the same of the second run.
    """

    kind: DifferenceKind
    start_s: float
    end_s: float
    peak_s: float
    first_has: bool | None
    first_level: WarningLevel
    second_level: WarningLevel
    first_m: float | None = None
    second_m: float | None = None


SameVehicle = Callable[[int, int], bool]
"""Whether the leads of a row of the first run and of one of the second are one vehicle."""


def matching_rows(first: DriveSeries, second: DriveSeries) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of two runs that are of the same moment of the source, to half a frame.

    Returns:
        Rows of the first and of the second, equally many; none where the runs share no time.
    """
    if not (len(first) and len(second)):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    periods = np.diff(first.time_ns)
    within_ns = int(np.median(periods)) // 2 if len(periods) else 0
    right = np.clip(np.searchsorted(second.time_ns, first.time_ns), 1, max(len(second) - 1, 1))
    left = right - 1
    right = np.minimum(right, len(second) - 1)
    nearer = np.abs(second.time_ns[left] - first.time_ns) <= np.abs(second.time_ns[right] - first.time_ns)
    nearest = np.where(nearer, left, right)
    rows = np.flatnonzero(np.abs(second.time_ns[nearest] - first.time_ns) <= within_ns)
    return rows, nearest[rows]


def find_differences(
    first: DriveSeries, second: DriveSeries, same_vehicle: SameVehicle
) -> tuple[Difference, ...]:
    """Where two runs differ, in the order of time.

    Args:
        first: the run whose seconds are used.
        second: the other one, over the same source.
        same_vehicle: asked once for each stretch in which the leads' distances differ.

    Returns:
        None where the runs share no time.
    """
    rows, others = matching_rows(first, second)
    if not len(rows):
        return ()
    pair = _Pair(first, second, rows, others)
    found = [*_warnings(pair, True), *_warnings(pair, False), *_leads(pair), *_distances(pair, same_vehicle)]
    return tuple(sorted(found, key=lambda one: (one.start_s, one.kind)))


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two runs with their matching rows."""

    first: DriveSeries
    second: DriveSeries
    rows: NDArray[np.intp]
    others: NDArray[np.intp]

    def time_s(self, place: int) -> float:
        return float(self.first.time_ns[self.rows[place]] - self.first.time_ns[0]) / 1e9

    def difference(self, kind: DifferenceKind, span: slice, peak: int, first_has: bool | None) -> Difference:
        """A stretch of matching rows that differs."""
        rows, others = self.rows[span], self.others[span]
        distances = (
            float(series.distance_m[row])
            for series, row in ((self.first, self.rows[peak]), (self.second, self.others[peak]))
        )
        first_m, second_m = (value if np.isfinite(value) else None for value in distances)
        return Difference(
            kind,
            self.time_s(span.start),
            self.time_s(span.stop - 1),
            self.time_s(peak),
            first_has,
            WarningLevel(int(self.first.level[rows].max())),
            WarningLevel(int(self.second.level[others].max())),
            first_m,
            second_m,
        )

    def stretches(self, mask: NDArray[np.bool_], begin: int = 0) -> Iterator[slice]:
        """Stretches of matching rows in which something holds, near ones joined, short ones left out.

        Args:
            mask: over the matching rows from `begin` on.
            begin: the first of them.
        """
        edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0)) + begin
        spans = [[int(start), int(end)] for start, end in zip(edges[::2], edges[1::2], strict=True)]
        joined: list[list[int]] = []
        for span in spans:
            if joined and self.time_s(span[0]) - self.time_s(joined[-1][1] - 1) <= JOINED_S:
                joined[-1][1] = span[1]
            else:
                joined.append(span)
        for start, end in joined:
            if self.time_s(end - 1) - self.time_s(start) >= SHORTEST_S:
                yield slice(start, end)


def _warnings(pair: _Pair, of_first: bool) -> Iterator[Difference]:
    """Warnings of one run for which the other one shows nothing as urgent, until it does."""
    own, other = (pair.first, pair.second) if of_first else (pair.second, pair.first)
    own_rows, other_rows = (pair.rows, pair.others) if of_first else (pair.others, pair.rows)
    times_ns = own.time_ns[own_rows]
    for event in find_events(own):
        level = _LEVELS.get(event.kind)
        if level is None:
            continue
        start_ns, end_ns, peak_ns = (
            int(own.time_ns[0]) + round(time_s * 1e9) for time_s in (event.start_s, event.end_s, event.peak_s)
        )
        near_ns = round(SAME_WARNING_S * 1e9)
        near = slice(*map(int, np.searchsorted(times_ns, (start_ns - near_ns, end_ns + near_ns + 1))))
        span = slice(*map(int, np.searchsorted(times_ns, (start_ns, end_ns + 1))))
        if span.start == span.stop:
            continue
        theirs = near.start + np.flatnonzero(other.level[other_rows[near]] >= level)
        if len(theirs):  # both warn: does this run begin sooner?
            began = span.start + int(np.argmax(own.level[own_rows[span]] >= level))
            if times_ns[theirs[0]] - times_ns[began] <= near_ns:
                continue
            span = slice(began, min(int(theirs[0]), span.stop))
        peak = min(max(int(np.searchsorted(times_ns, peak_ns)), span.start), span.stop - 1)
        yield pair.difference(DifferenceKind.WARNING, span, peak, of_first)


def _leads(pair: _Pair) -> Iterator[Difference]:
    """Stretches in which only one of the two has a lead."""
    first = pair.first.lead_id[pair.rows] != NO_TRACK
    second = pair.second.lead_id[pair.others] != NO_TRACK
    for of_first, mask in ((True, first & ~second), (False, second & ~first)):
        distance_m = pair.first.distance_m[pair.rows] if of_first else pair.second.distance_m[pair.others]
        for span in pair.stretches(mask):
            nearest = np.where(mask[span], distance_m[span], np.inf)
            yield pair.difference(DifferenceKind.LEAD, span, span.start + int(nearest.argmin()), of_first)


def _distances(pair: _Pair, same_vehicle: SameVehicle) -> Iterator[Difference]:
    """Stretches in which the leads' intervals of distance do not touch: of one vehicle, or of two."""
    first, second = (
        (series.distance_m[rows], series.distance_low_m[rows], series.distance_high_m[rows])
        for series, rows in ((pair.first, pair.rows), (pair.second, pair.others))
    )
    apart = (first[1] > second[2]) | (second[1] > first[2])  # NaN compares as False
    ratio = np.abs(np.log(np.maximum(first[0], 0.1) / np.maximum(second[0], 0.1)))
    ratio = np.where(apart, ratio, -1.0)
    # A change of either lead begins another stretch: it may be another vehicle.
    ids = np.stack([pair.first.lead_id[pair.rows], pair.second.lead_id[pair.others]])
    changes = np.flatnonzero((ids[:, 1:] != ids[:, :-1]).any(axis=0)) + 1
    for start, end in pairwise([0, *changes.tolist(), len(apart)]):
        for span in pair.stretches(apart[start:end], start):
            peak = span.start + int(ratio[span].argmax())
            same = same_vehicle(int(pair.rows[peak]), int(pair.others[peak]))
            kind = DifferenceKind.DISTANCE if same else DifferenceKind.LEAD
            yield pair.difference(kind, span, peak, None)
