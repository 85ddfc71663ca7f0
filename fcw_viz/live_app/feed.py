"""From the running pipeline to the tabs: always the latest result with its picture."""

import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.frame import VideoPacket
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.series import DriveSeries, SeriesBuilder
from fcw.sources.live import LiveSource
from fcw.units import NS_PER_S

HISTORY_S = 30.0
"""How far back the plots reach."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """The result of a frame with its picture.

    Attributes:
        result: result of the frame.
        image: its picture, (height, width, 3) BGR; not to be changed.
        captured_s: when the picture came to the program, on the clock of the source.
        found_s: when its result was ready.
    """

    result: FrameResult
    image: NDArray[np.uint8]
    captured_s: float
    found_s: float


class LiveFeed:
    """A sink that keeps the latest moment and the results of the last seconds.

    `write` only stores them and wakes those who wait; the tabs draw and send in their own threads.
    """

    def __init__(self, source: LiveSource) -> None:
        """Make an empty feed."""
        self._source = source
        self._changed = threading.Condition()
        self._latest: Moment | None = None
        self._history: deque[FrameResult] = deque()
        self._header: DriveHeader | None = None
        self._first_ns = 0
        self._ended = False

    # What the pipeline tells

    def open(self, header: DriveHeader) -> None:
        """Begin the drive."""
        with self._changed:
            self._header = header
            self._changed.notify_all()

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Take the result of a frame."""
        capture = self._source.capture(result.index)
        found_s = self._source.now_s()
        with self._changed:
            if not self._history:
                self._first_ns = result.time_ns
            self._history.append(result)
            while result.time_ns - self._history[0].time_ns > HISTORY_S * NS_PER_S:
                self._history.popleft()
            if capture is not None:
                self._latest = Moment(result, capture.image, capture.captured_s, found_s)
            self._changed.notify_all()

    def close(self) -> None:
        """End the drive."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    # What the tabs ask

    @property
    def header(self) -> DriveHeader | None:
        """Header of the drive; None before it begins."""
        return self._header

    @property
    def ended(self) -> bool:
        """Whether the drive has ended, so that no frame will come."""
        return self._ended

    @property
    def first_ns(self) -> int:
        """Time of the first frame."""
        return self._first_ns

    @property
    def dropped(self) -> int:
        """How many pictures were skipped to keep up."""
        return self._source.dropped

    @property
    def trouble(self) -> str:
        """Why no picture comes now, or will come any more; empty while pictures come."""
        return self._source.trouble

    def now_s(self) -> float:
        """The current time on the clock of the moments."""
        return self._source.now_s()

    def newer_than(self, frame_index: int, wait_s: float) -> Moment | None:
        """Wait for a moment that is newer than a frame, and return the latest one; None if none comes.

        Args:
            frame_index: index of the last known frame; -1 for none.
            wait_s: longest wait.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._is_newer(frame_index), wait_s)
            return self._latest if self._is_newer(frame_index) else None

    def history(self, last_index: int) -> DriveSeries:
        """The results of the last `HISTORY_S` up to a frame, as columns; empty if the frame is older."""
        with self._changed:
            results = tuple(self._history)
        builder = SeriesBuilder()
        for result in results:
            if result.index <= last_index:
                builder.add(result, ())
        return builder.build()

    def _is_newer(self, frame_index: int) -> bool:
        return self._latest is not None and self._latest.result.index > frame_index
