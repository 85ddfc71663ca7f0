"""The values of signals over rows of a drive: from the log's columns, else from its frames by blocks."""

import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.series import DriveSeries
from fcw_viz.review_app.plots.signals import (
    AHEAD,
    OWN,
    OWN_SIGNALS,
    SIGNALS,
    VEHICLE_SIGNALS,
    Chosen,
    in_series,
)

BLOCK_ROWS = 256
"""Frames that are read together: a few tenths of a second."""
BLOCKS_KEPT = 512
"""An hour and a half of a drive; some ten kilobytes each for every vehicle in them."""

LAST_FRAMES = 2
"""The last frame is seen for as long as so many."""

Column = NDArray[np.float64]


class Plotted(Protocol):
    """A drive, or what is known of one that still runs."""

    @property
    def header(self) -> DriveHeader:
        """Of the drive."""
        ...

    @property
    def series(self) -> DriveSeries:
        """Its columns."""
        ...

    @property
    def first_ns(self) -> int:
        """From when seconds count."""
        ...

    def rows_between(self, start_s: float, end_s: float) -> slice:
        """Rows of a range of time, with the one before and the one after."""
        ...


class Values(NamedTuple):
    """A signal over some rows, in SI units; NaN where it has no value.

    Attributes:
        value: (N,).
        low: (N,) lower edge of the interval; None where the signal has none.
        high: (N,) its upper edge, inf where it is unbounded.
    """

    value: Column
    low: Column | None = None
    high: Column | None = None


def series_values(series: DriveSeries, rows: slice, chosen: Chosen) -> Values:
    """What the log's own columns hold of a signal, see `in_series`."""
    signal = SIGNALS[chosen.signal]
    columns = [
        (series.about(name) if chosen.subject == AHEAD else getattr(series, name))[rows].astype(np.float64)
        for name in signal.series
    ]
    if not signal.sigma:
        return Values(*columns)
    value, sigma = columns
    sigma = np.where(sigma > 0, sigma, np.nan)  # what was given has no interval
    return Values(value, np.maximum(value - sigma, 0.0), value + sigma)


class FrameSignals:
    """What only the frames of a log hold, read by a thread where it is wanted.

    `want` says which rows; what has come is there for `values`.
    """

    def __init__(
        self, log: DriveLog, told: Callable[[], object], before: "FrameSignals | None" = None
    ) -> None:
        """Nothing is read before it is wanted.

        Args:
            log: the drive's.
            told: called in the thread when something has come.
            before: of the same drive, when it was shorter.
        """
        self._log, self._told = log, told
        self._series = log.series()
        self._blocks: OrderedDict[int, _Block] = OrderedDict()
        if before is not None:
            with before._changed:  # its thread may still be reading
                blocks = tuple(before._blocks.items())
            self._blocks.update((n, block) for n, block in blocks if block.rows == BLOCK_ROWS)
        self._wanted: list[int] = []
        self._changed = threading.Condition()
        self._closed = False
        self._thread: threading.Thread | None = None

    def want(self, rows: slice) -> None:
        """Have these rows read, and no others any more."""
        first, last = rows.start // BLOCK_ROWS, max(rows.stop - 1, rows.start) // BLOCK_ROWS
        with self._changed:
            self._wanted = [n for n in range(first, last + 1) if n not in self._blocks][:BLOCKS_KEPT]
            if self._wanted and self._thread is None and not self._closed:
                self._thread = threading.Thread(target=self._read_on, name="signals", daemon=True)
                self._thread.start()
            self._changed.notify()

    @property
    def reading(self) -> bool:
        """Whether something that is wanted has not come yet."""
        return bool(self._wanted)

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._closed, self._wanted = True, []
            self._changed.notify()

    def values(self, rows: slice, chosen: Chosen) -> Values:
        """What has come of a signal; NaN where it has not."""
        signal = SIGNALS[chosen.signal]
        names = [f"{signal.key} {k}" for k in range(len(signal.of_vehicle or signal.of_frame))]
        columns = [np.full(rows.stop - rows.start, np.nan) for _ in names]
        for number in range(rows.start // BLOCK_ROWS, max(rows.stop - 1, rows.start) // BLOCK_ROWS + 1):
            found = self._blocks.get(number)
            of_subject = None if found is None else found.columns.get(chosen.subject)
            if of_subject is None:
                continue
            start = number * BLOCK_ROWS
            low, high = max(start, rows.start), min(start + of_subject.shape[1], rows.stop)
            for name, column in zip(names, columns, strict=True):
                place = _PLACES[chosen.subject == OWN][name]
                column[low - rows.start : high - rows.start] = of_subject[place, low - start : high - start]
        return Values(*columns)

    def _read_on(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._wanted or self._closed)
                if self._closed:
                    return
                number = self._wanted[0]
            block = self._read(number)
            with self._changed:
                self._blocks[number] = block
                while len(self._blocks) > BLOCKS_KEPT:
                    self._blocks.popitem(last=False)
                if number in self._wanted:
                    self._wanted.remove(number)
                closed = self._closed
            if not closed:
                self._told()

    def _read(self, number: int) -> "_Block":
        times_ns = self._series.time_ns[number * BLOCK_ROWS : (number + 1) * BLOCK_ROWS]
        block = _Block(len(times_ns), {})
        # A damaged log says so where its pictures are asked for; what can be read is drawn.
        with suppress(UserError):
            for result in self._log.results(int(times_ns[0]), int(times_ns[-1]) + 1):
                row = int(np.searchsorted(times_ns, result.time_ns))
                if row < len(times_ns):
                    block.add(row, result)
        return block


@dataclass(frozen=True, slots=True)
class _Block:
    """Some rows of all signals.

    Attributes:
        rows: how many.
        columns: by the subject, (S, rows) float32.
    """

    rows: int
    columns: dict[str, NDArray[np.float32]]

    def add(self, row: int, result: FrameResult) -> None:
        """Take in a frame."""
        self._of(OWN)[:, row] = [
            np.nan if value is None else value
            for value in (read(result) for signal in OWN_SIGNALS for read in signal.of_frame)
        ]
        ahead = result.warned or result.lead
        for track in result.tracks:
            values = [
                np.nan if value is None else value
                for value in (read(result, track) for signal in VEHICLE_SIGNALS for read in signal.of_vehicle)
            ]
            self._of(str(track.track_id))[:, row] = values
            if track is ahead:
                self._of(AHEAD)[:, row] = values

    def _of(self, subject: str) -> NDArray[np.float32]:
        column = self.columns.get(subject)
        if column is None:
            shape = len(_PLACES[subject == OWN]), self.rows
            column = self.columns[subject] = np.full(shape, np.nan, np.float32)
        return column


def _places(names: list[str]) -> dict[str, int]:
    return {name: place for place, name in enumerate(names)}


_PLACES = (
    _places([f"{signal.key} {k}" for signal in VEHICLE_SIGNALS for k in range(len(signal.of_vehicle))]),
    _places([f"{signal.key} {k}" for signal in OWN_SIGNALS for k in range(len(signal.of_frame))]),
)
"""Rows of a block's columns by signal: of a vehicle, and of the drive."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A drive's part that is drawn.

    Attributes:
        name: which run it is; empty where there is only one.
        series: its columns.
        rows: the part.
        times_s: of those rows, on the plots' axis.
        frames: what its frames hold; None where nothing of it is wanted.
    """

    name: str
    series: DriveSeries
    rows: slice
    times_s: Column
    frames: FrameSignals | None = None

    @classmethod
    def of(
        cls,
        drive: Plotted,
        start_s: float,
        end_s: float,
        frames: FrameSignals | None = None,
        name: str = "",
        first_ns: int | None = None,
    ) -> "Run":
        """The part of a drive between two moments of the axis.

        Args:
            drive: the drive.
            start_s: of the axis.
            end_s: of the axis.
            frames: see `Run.frames`.
            name: see `Run.name`.
            first_ns: where the axis begins; None for the drive's own first frame.
        """
        zero_ns = drive.first_ns if first_ns is None else first_ns
        later_s = (drive.first_ns - zero_ns) / 1e9
        rows = drive.rows_between(start_s - later_s, end_s - later_s)
        times_s = (drive.series.time_ns[rows] - zero_ns) / 1e9
        return cls(name, drive.series, rows, times_s, frames)

    @property
    def end_s(self) -> float:
        """Until when there is a value: two frames after the drive's last one; of a single frame for ever."""
        times_ns = self.series.time_ns
        if self.rows.stop < len(times_ns) or len(times_ns) < 2:
            return math.inf
        return float(self.times_s[-1]) + LAST_FRAMES * int(times_ns[-1] - times_ns[-2]) / 1e9

    def values(self, chosen: Chosen) -> Values:
        """A signal over the part."""
        if in_series(chosen):
            return series_values(self.series, self.rows, chosen)
        if self.frames is None:
            return Values(np.full(len(self.times_s), np.nan))
        return self.frames.values(self.rows, chosen)
