"""Labelled events against the warnings in a drive's log.

An event is a stretch of the drive in which a warning had to be shown. It is a hit when a warning of its level
or a higher one is shown within it, else missed. A false alarm is an unbroken run of warnings that touches no
event; levels below the lowest one labelled do not count. A label can also say that its stretch is none: a
false alarm somebody has looked at.

Where labels say only what somebody has judged (a review in which not every warning has its verdict), a false
alarm is a stretch labelled as none in which a warning of its level or a higher one is shown, and other runs
of warnings are unjudged: neither good nor bad.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

from fcw.bounded.files import MalformedError, read_text
from fcw.bounded.formats import csv_rows, json_value
from fcw.errors import UserError
from fcw.logs.records import FrameResult
from fcw.warning.types import WarningLevel

LEVELS = {level.name.lower(): level for level in WarningLevel if level > WarningLevel.NONE}
MOST_EVENTS = 100_000
"""Of a drive: one a second for a day."""
VERDICTS = {"justified": True, "false": False}
"""Whether the stretch is an event."""
EXPECTED = (
    "expected CSV with the columns start_s, end_s and level, or a JSON list of such objects; level is one of "
    f"{', '.join(LEVELS)} (warning where there is none), verdict, if there is one, {' or '.join(VERDICTS)}"
)


@dataclass(frozen=True, slots=True)
class Event:
    """A labelled stretch.

    Attributes:
        start_s: from the drive's first frame.
        end_s: the same, not before `start_s`.
        level: the warning that had to be shown.
        justified: False for a stretch known to need none.
    """

    start_s: float
    end_s: float
    level: WarningLevel = WarningLevel.WARNING
    justified: bool = True


@dataclass(frozen=True, slots=True)
class Shown:
    """An unbroken run of warnings in a log.

    Attributes:
        start_s: from the drive's first frame.
        end_s: of its last frame.
        highest: the highest level in it.
    """

    start_s: float
    end_s: float
    highest: WarningLevel


@dataclass(frozen=True, slots=True)
class EventComparison:
    """What a log is worth by the labels.

    Attributes:
        hits: the events that were warned of.
        missed: the events that were not.
        false_alarms: the runs of warnings that belong to no event, or, where labels say only what was judged,
            what is shown within the stretches labelled as none.
        unjudged: the runs of warnings that no label says anything of, where labels say only what was judged.
    """

    hits: tuple[Event, ...]
    missed: tuple[Event, ...]
    false_alarms: tuple[Shown, ...]
    unjudged: tuple[Shown, ...] = ()


def read_events(path: Path) -> tuple[Event, ...]:
    """Read labelled events from a CSV or JSON file.

    Raises:
        UserError: the file cannot be read, or an entry is not as expected.
    """
    try:
        text = read_text(path)
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot read the events ({error}); {EXPECTED}") from None
    if path.suffix.lower() == ".json":
        try:
            entries: Any = json_value(text)
        except MalformedError as error:
            raise UserError(f"{path}: no JSON ({error}); {EXPECTED}") from None
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise UserError(f"{path}: no list of objects; {EXPECTED}")
    else:
        try:
            header, *rows = (row for _, row in csv_rows(text))
        except MalformedError as error:
            raise UserError(f"{path}, {error}; {EXPECTED}") from None
        except ValueError:  # not even a header
            return ()
        entries = [dict(zip(header, row, strict=False)) for row in rows]
    if len(entries) > MOST_EVENTS:
        raise UserError(f"{path}: {len(entries)} events; expected those of one drive, at most {MOST_EVENTS}")
    return tuple(_event(entry, f"{path}, event {number}") for number, entry in enumerate(entries, 1))


def _event(entry: Mapping[str, Any], where: str) -> Event:
    start_s, end_s = (_seconds(entry, name, where) for name in ("start_s", "end_s"))
    if end_s < start_s:
        raise UserError(f"{where}: end_s {end_s:g} is before start_s {start_s:g}")
    level, verdict = str(entry.get("level") or "warning"), str(entry.get("verdict") or "justified")
    if level not in LEVELS:
        raise UserError(f"{where}: level is {level!r}; {EXPECTED}")
    if verdict not in VERDICTS:
        raise UserError(f"{where}: verdict is {verdict!r}; {EXPECTED}")
    return Event(start_s, end_s, LEVELS[level], VERDICTS[verdict])


def _seconds(entry: Mapping[str, Any], name: str, where: str) -> float:
    try:
        value = float(entry[name])
    except (KeyError, TypeError, ValueError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"{where}: {name} is {entry.get(name)!r}, expected seconds; {EXPECTED}")
    return value


def compare_with_events(
    results: Iterable[FrameResult], events: Sequence[Event], complete: bool = True
) -> EventComparison:
    """Compare the warnings of a log with labelled events.

    Args:
        results: of every frame, in order.
        events: the labels.
        complete: whether they name every event of the drive, or only what somebody has judged.
    """
    due = [event for event in events if event.justified]
    relevant = due if complete else events
    lowest = min((event.level for event in relevant), default=WarningLevel.WARNING)
    frames = [(result.time_ns, result.warning.level) for result in results]
    shown = [((time_ns - frames[0][0]) / 1e9, level) for time_ns, level in frames]
    hits, missed, without_label = [], [], []
    for event in due:
        (hits if _shown_within(shown, event) else missed).append(event)
    for is_shown, frames_of_run in groupby(shown, lambda frame: frame[1] >= lowest):
        run = list(frames_of_run)
        start_s, end_s = run[0][0], run[-1][0]
        if is_shown and not any(event.start_s <= end_s and start_s <= event.end_s for event in relevant):
            without_label.append(Shown(start_s, end_s, max(level for _, level in run)))
    if complete:
        return EventComparison(tuple(hits), tuple(missed), tuple(without_label))
    judged_false = (_shown_within(shown, event) for event in events if not event.justified)
    false_alarms = tuple(run for run in judged_false if run is not None)
    return EventComparison(tuple(hits), tuple(missed), false_alarms, tuple(without_label))


def _shown_within(shown: Sequence[tuple[float, WarningLevel]], event: Event) -> Shown | None:
    """What is shown within an event's stretch of its level or a higher one; `shown` is in order of time."""
    first = bisect_left(shown, event.start_s, key=itemgetter(0))
    end = bisect_right(shown, event.end_s, key=itemgetter(0))
    within = [(time_s, level) for time_s, level in shown[first:end] if level >= event.level]
    if not within:
        return None
    return Shown(within[0][0], within[-1][0], max(level for _, level in within))
