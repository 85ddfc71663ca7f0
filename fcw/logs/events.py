"""The moments of a drive that deserve a look, found from its series alone.

An event is an unbroken period with one vehicle in which a caution or warning about it was shown, an advisory
was shown, or it was close and nothing was shown: a near miss. Near misses are defined by two measures of
traffic conflicts: a time to collision of at most 1.5 s (Hayward 1972; van der Horst 1990; the default of
FHWA's Surrogate Safety Assessment Model), or a required deceleration above 3.4 m/s^2, which AASHTO's Green
Book assumes most drivers to stay below (and above which Archer 2005 speaks of a conflict).
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fcw.logs.records import CUT, NOTHING_SEEN, POOR_SIGHT
from fcw.logs.series import NO_TRACK, DriveSeries
from fcw.tracking.lead import ONCOMING_MARGIN_MPS
from fcw.units import KMH_PER_MPS
from fcw.warning.driver import HARDEST_BRAKING_MPS2
from fcw.warning.types import WarningLevel, WarningState

EventKind = Literal[
    "warning", "caution", "advisory", "near miss", "mount moved", "nothing seen", "cut", "poor sight"
]
_KINDS_BY_NOTE: dict[str, EventKind] = {NOTHING_SEEN: "nothing seen", CUT: "cut"}

NEAR_MISS_TTC_S = 1.5
NEAR_MISS_DECELERATION_MPS2 = 3.4
SLOWEST_NEAR_MISS_MPS = 10 / KMH_PER_MPS
"""Least closing speed and own speed for a near miss, as cars in a queue creep together with short TTCs."""
SHORTEST_NEAR_MISS_S = 0.3
"""Shorter periods are noise of a box."""
WARNED_WITHIN_S = 2.0
"""A vehicle was not missed if it was warned of within this time before or after."""
BLIND_AFTER_S = 1.0
"""Longest interval between two pictures without an event; drivers take about as long to react."""

_Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class DriveEvent:
    """One event. Times are from the drive's first frame.

    Attributes:
        kind: kind of the event; for a period with caution and warning, the higher level.
        start_s: time of its first frame; for a period without pictures, of the last frame before.
        end_s: time of its last frame; for a period without pictures, of the first frame after.
        peak_s: time at which it was most severe or, if the gap never closed, the vehicle was nearest.
        track_id: the vehicle; None for `mount moved`, `nothing seen`, `cut` and `poor sight`.
        rule: the rule behind the level at the peak; empty if there is none.
        min_ttc_s: smallest TTC; None if the gap never closed.
        min_distance_m: smallest distance; None if it was never measured.
        max_required_deceleration_mps2: hardest braking needed; None if none was.
        severity: how bad it nearly was: the maximum of the braking needed, as a fraction of the hardest that
            a car can do (8 m/s^2), times the probability of the collision; 0 if the gap never closed.
        note: the note on a moved mount, poor or no sight, or a cut.
    """

    kind: EventKind
    start_s: float
    end_s: float
    peak_s: float
    track_id: int | None
    rule: str
    min_ttc_s: float | None
    min_distance_m: float | None
    max_required_deceleration_mps2: float | None
    severity: float
    note: str = ""


@dataclass(slots=True)
class WarningCounter:
    """Counts a drive's events of kind `warning` while it runs, as `find_events` will find them.

    Attributes:
        count: number of events so far.
    """

    count: int = 0
    _vehicle: int | None = None
    _alarmed: bool = False
    _counted: bool = False

    def add(self, warning: WarningState) -> None:
        """Add the next frame's warning."""
        alarmed = warning.level >= WarningLevel.CAUTION
        if not (alarmed and self._alarmed and warning.track_id == self._vehicle):
            self._counted = False
        self._alarmed, self._vehicle = alarmed, warning.track_id
        if warning.level == WarningLevel.WARNING and not self._counted:
            self.count, self._counted = self.count + 1, True


def find_events(series: DriveSeries) -> tuple[DriveEvent, ...]:
    """All events of a drive, in the order in which they start."""
    alarmed = series.level >= WarningLevel.CAUTION
    events = [
        _event(series, rows, "warning" if series.level[rows].max() == WarningLevel.WARNING else "caution")
        for rows in _runs(alarmed, series.warned_id)
    ]
    near = [rows for rows in _runs(_is_near(series) & ~alarmed, series.lead_id) if _is_missed(series, rows)]
    events += [_event(series, rows, "near miss") for rows in near]
    advised = series.level == WarningLevel.ADVISORY
    events += [_event(series, rows, "advisory") for rows in _runs(advised, series.warned_id)]
    for start_ns, end_ns, note in zip(series.note_ns, series.note_end_ns, series.notes, strict=True):
        start_s, end_s = _seconds(series, int(start_ns)), _seconds(series, int(end_ns))
        kind = "poor sight" if note.startswith(POOR_SIGHT) else _KINDS_BY_NOTE.get(note, "mount moved")
        events.append(DriveEvent(kind, start_s, end_s, start_s, None, "", None, None, None, 0.0, note))
    events += _unseen(series)
    return tuple(sorted(events, key=lambda event: event.start_s))


def seen_s(duration_s: float, events: Iterable[DriveEvent]) -> float:
    """Time of a drive in which something could be seen, so that a warning was possible.

    Args:
        duration_s: time from its first frame to its last.
        events: its events, in the order in which they start.
    """
    seen_s, until_s = 0.0, 0.0
    for event in events:
        if event.kind == "nothing seen":  # a covered lens and a time without pictures may overlap
            seen_s += max(event.start_s - until_s, 0.0)
            until_s = max(until_s, event.end_s)
    return seen_s + max(duration_s - until_s, 0.0)


def _unseen(series: DriveSeries) -> Iterator[DriveEvent]:
    """Periods in which no picture was examined; consecutive long intervals are one period."""
    long = np.diff(series.time_ns) / 1e9 > BLIND_AFTER_S
    for steps in _runs(long, np.zeros(len(long), np.int64)):
        start_s, end_s = (_seconds(series, int(series.time_ns[row])) for row in (steps.start, steps.stop))
        note = (
            f"pictures are more than {BLIND_AFTER_S:g} s apart for {end_s - start_s:.1f} s: nothing was "
            "examined between them, so no warning was possible"
        )
        yield DriveEvent("nothing seen", start_s, end_s, start_s, None, "", None, None, None, 0.0, note)


def _runs(mask: _Mask, vehicle: NDArray[np.int64]) -> list[slice]:
    """Unbroken runs of rows in which a mask is true for one vehicle."""
    if not len(mask):
        return []
    changes = np.flatnonzero((mask[1:] != mask[:-1]) | (vehicle[1:] != vehicle[:-1])) + 1
    return [slice(a, b) for a, b in pairwise([0, *changes.tolist(), len(mask)]) if mask[a]]


def _is_near(series: DriveSeries) -> _Mask:
    """Rows in which the lead was dangerously close; NaN compares as False."""
    closing_mps, own_mps = series.closing_speed_mps, series.ego_speed_mps
    by_ttc = (series.ttc_s <= NEAR_MISS_TTC_S) & (closing_mps >= SLOWEST_NEAR_MISS_MPS)
    by_braking = series.required_deceleration_mps2 > NEAR_MISS_DECELERATION_MPS2
    creeps = own_mps < SLOWEST_NEAR_MISS_MPS
    oncoming = closing_mps > own_mps + ONCOMING_MARGIN_MPS
    return (series.lead_id != NO_TRACK) & (by_ttc | by_braking) & ~creeps & ~oncoming


def _is_missed(series: DriveSeries, rows: slice) -> bool:
    """Whether a close period lasted long enough, and had no warning of that vehicle around it."""
    start_ns, end_ns = series.time_ns[rows.start], series.time_ns[rows.stop - 1]
    around_ns = round(WARNED_WITHIN_S * 1e9)
    around = slice(*np.searchsorted(series.time_ns, (start_ns - around_ns, end_ns + around_ns + 1)))
    warned = (series.level[around] >= WarningLevel.CAUTION) & (
        series.warned_id[around] == series.lead_id[rows.start]
    )
    return bool((end_ns - start_ns) / 1e9 >= SHORTEST_NEAR_MISS_S) and not warned.any()


def _event(series: DriveSeries, rows: slice, kind: EventKind) -> DriveEvent:
    near_miss = kind == "near miss"
    vehicle = int((series.lead_id if near_miss else series.warned_id)[rows.start])
    prefix = "" if near_miss else "warned_"
    at = np.arange(rows.start, rows.stop)
    if not near_miss:
        # After it was lost, its figures are extrapolated, which is no measurement.
        at = at[series.extrapolated[rows] == 0]
    braking_mps2, distance_m, ttc_s = (
        getattr(series, prefix + name)[at] for name in ("required_deceleration_mps2", "distance_m", "ttc_s")
    )
    danger = np.minimum(braking_mps2 / HARDEST_BRAKING_MPS2, 1.0)
    if not near_miss:
        # An advisory is about what might happen, so the probability counts. Old logs have none.
        danger = danger * np.where(
            np.isnan(series.warned_probability[at]), 1.0, series.warned_probability[at]
        )
    severity = _extreme(danger, np.max)
    if severity is not None:
        # If several moments have the largest severity, take the one with the hardest braking needed.
        worst = np.where(danger >= severity, braking_mps2, np.float32(-1))
        peak = int(at[np.argmax(worst)])
    else:
        peak = int(at[np.nanargmin(distance_m)]) if np.isfinite(distance_m).any() else rows.start
    return DriveEvent(
        kind=kind,
        start_s=_seconds(series, int(series.time_ns[rows.start])),
        end_s=_seconds(series, int(series.time_ns[rows.stop - 1])),
        peak_s=_seconds(series, int(series.time_ns[peak])),
        track_id=None if vehicle == NO_TRACK else vehicle,
        rule=series.rules[series.rule[peak]],
        min_ttc_s=_extreme(ttc_s, np.min),
        min_distance_m=_extreme(distance_m[np.isfinite(distance_m)], np.min),
        max_required_deceleration_mps2=_extreme(braking_mps2, np.max),
        severity=severity or 0.0,
    )


def _extreme(column: NDArray[np.float32], pick: Callable[[NDArray[np.float32]], np.float32]) -> float | None:
    known = column[~np.isnan(column)]
    return float(pick(known)) if len(known) else None


def _seconds(series: DriveSeries, time_ns: int) -> float:
    return (time_ns - int(series.time_ns[0])) / 1e9
