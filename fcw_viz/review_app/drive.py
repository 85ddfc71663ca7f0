"""Reads a drive log for the page: columns and events at once, pictures and results when needed."""

import logging
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path

import numpy as np

from fcw.bounded.gpx import GpxTrack
from fcw.errors import UserError
from fcw.logs.events import DriveEvent, find_events
from fcw.logs.mcap.following import LogWatch
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.pictures import LogPictures
from fcw.logs.records import DriveHeader
from fcw.logs.run_notes import notes_of_run
from fcw.logs.series import DriveSeries
from fcw.units import NS_PER_S

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Drive:
    """An open drive; thread-safe.

    Attributes:
        name: its name on the page.
        log: its log.
        watch: checks whether the file of the log is still the same.
        series: the columns of the log, with at least one row.
        events: its events by time.
        origin: an object that stays the same while the drive grows.
    """

    name: str
    log: DriveLog
    watch: LogWatch
    series: DriveSeries
    events: tuple[DriveEvent, ...]
    origin: object

    @classmethod
    def open(cls, name: str, path: Path) -> "Drive":
        """Open a drive, and read its columns and events.

        Raises:
            UserError: the file is not a drive log, is damaged, or contains no frame.
        """
        return cls._of(name, DriveLog(path), object())

    def grown(self) -> "Drive":
        """The drive with the present content of its log; only what is new is read.

        Raises:
            UserError: the log can no longer be read.
        """
        return self._of(self.name, self.log.grown(), self.origin)

    @classmethod
    def _of(cls, name: str, log: DriveLog, origin: object) -> "Drive":
        watch = LogWatch(log)
        series = log.series()
        if not len(series):
            raise UserError(f"{log.path}: the log holds no frame; there is nothing to review")
        events = sorted(find_events(series), key=lambda event: (event.start_s, event.end_s))
        return cls(name, log, watch, series, tuple(events), origin)

    @property
    def header(self) -> DriveHeader:
        """The header of the log."""
        return self.log.header

    @property
    def complete(self) -> bool:
        """False if the program that wrote the log was killed."""
        return self.log.complete

    @property
    def first_ns(self) -> int:
        """Time of the first frame, from which seconds count."""
        return int(self.series.time_ns[0])

    @property
    def zero_utc_ns(self) -> int | None:
        """Time of the first frame in UTC, in nanoseconds since 1970; None if it is not known."""
        return self.header.begun_utc_ns(self.first_ns)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes about the drive from the run that wrote the log."""
        return notes_of_run(self.log.path)

    @cached_property
    def track(self) -> GpxTrack | None:
        """Where the car went; None if the own speed did not come from a GPX track."""
        try:
            return self.log.track()
        except UserError as error:
            LOGGER.warning("%s", error)
            return None

    @property
    def duration_s(self) -> float:
        """From the first frame to the last."""
        return self.series.duration_s

    @property
    def last_row(self) -> int:
        """Row of the last frame."""
        return len(self.series) - 1

    def time_s(self, row: int) -> float:
        """Seconds from the first frame."""
        return (int(self.series.time_ns[row]) - self.first_ns) / NS_PER_S

    def row_at(self, time_s: float) -> int:
        """Row of the frame at a time; the first or the last one beyond the ends."""
        if not math.isfinite(time_s):
            return 0
        return self.series.row_at(self.first_ns + round(time_s * NS_PER_S))

    def rows_between(self, start_s: float, end_s: float) -> slice:
        """Rows of a time range, plus one before and one after, so that lines reach its edges."""
        times_ns = self.series.time_ns
        start, end = (self.first_ns + round(time_s * NS_PER_S) for time_s in (start_s, end_s))
        first = int(np.searchsorted(times_ns, start)) - 1
        last = int(np.searchsorted(times_ns, end, side="right")) + 1
        return slice(max(first, 0), min(last, len(times_ns)))

    def frame_index(self, row: int) -> int:
        """`FrameResult.index` of a row."""
        return int(self.series.frame_index[row])

    def pictures(self) -> LogPictures:
        """A reader of its pictures, for one thread."""
        return LogPictures(self.log)

    def worst_event(self) -> int | None:
        """Number of the most severe event; None if there is none."""
        ranked = by_severity(self.events)
        return ranked[0] if ranked else None


def by_severity(events: tuple[DriveEvent, ...]) -> list[int]:
    """Numbers of events, the most severe first, then the earlier one."""
    return sorted(range(len(events)), key=lambda number: (-events[number].severity, events[number].start_s))


def time_text(time_s: float, decimals: int = 1) -> str:
    """A moment of a drive: 7.5 s, 1:07.5, 1:02:07.5."""
    rounded = round(max(time_s, 0.0), decimals)
    minutes, seconds = divmod(rounded, 60)
    hours, minutes = divmod(int(minutes), 60)
    if rounded < 60:
        return f"{seconds:.{decimals}f} s"
    width = 3 + decimals if decimals else 2
    tail = f"{seconds:0{width}.{decimals}f}"
    return f"{hours}:{minutes:02d}:{tail}" if hours else f"{minutes}:{tail}"


def utc_text(utc_ns: int, date: bool) -> str:
    """A moment by the clock: 2021-06-01 06:52:07 UTC, or without the date."""
    moment = datetime.fromtimestamp(utc_ns // NS_PER_S, UTC)
    return moment.strftime("%Y-%m-%d %H:%M:%S UTC" if date else "%H:%M:%S UTC")


def duration_text(duration_s: float) -> str:
    """A duration in words: 40 s, 12 min, 1.5 h."""
    if duration_s < 100:
        return f"{duration_s:.0f} s"
    if duration_s < 5400:
        return f"{duration_s / 60:.0f} min"
    return f"{duration_s / 3600:.1f} h"
