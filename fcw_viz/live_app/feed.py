"""From the running pipeline to the tabs: the latest result with its picture, and nothing that could wait."""

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
    """A frame's result as it became known.

    Attributes:
        result: of the frame.
        image: its picture, (height, width, 3) BGR; not to be changed.
        captured_s: when the picture came to the program, on the source's clock.
        found_s: when its result was there.
    """

    result: FrameResult
    image: NDArray[np.uint8]
    captured_s: float
    found_s: float


class LiveFeed:
    """A sink that keeps the latest moment for whoever asks, and the results of the last seconds.

    `write` stores and wakes who waits; drawing and sending is the tabs' business, in their own threads.
    """

    def __init__(self, source: LiveSource) -> None:
        """Nothing is known before the first frame."""
        self._source = source
        self._changed = threading.Condition()
        self._latest: Moment | None = None
        self._history: deque[FrameResult] = deque()
        self._header: DriveHeader | None = None
        self._first_ns = 0
        self._ended = False

    # What the pipeline tells

    def open(self, header: DriveHeader) -> None:
        """The drive begins."""
        with self._changed:
            self._header = header
            self._changed.notify_all()

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """A frame has its result."""
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
        """The drive has ended."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    # What the tabs ask

    @property
    def header(self) -> DriveHeader | None:
        """Of the drive; None before it begins."""
        return self._header

    @property
    def ended(self) -> bool:
        """Whether no frame will come any more."""
        return self._ended

    @property
    def first_ns(self) -> int:
        """Time of the first frame."""
        return self._first_ns

    @property
    def dropped(self) -> int:
        """How many pictures were left out to keep up."""
        return self._source.dropped

    @property
    def trouble(self) -> str:
        """Why no picture comes at present, or any more; empty while they come."""
        return self._source.trouble

    def now_s(self) -> float:
        """The present moment on the clock of the moments."""
        return self._source.now_s()

    def newer_than(self, frame_index: int, wait_s: float) -> Moment | None:
        """The latest moment, if it is newer than a frame; waits for one.

        Args:
            frame_index: the last one known; -1 for none.
            wait_s: at most.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._is_newer(frame_index), wait_s)
            return self._latest if self._is_newer(frame_index) else None

    def history(self, last_index: int) -> DriveSeries:
        """The results of the last `HISTORY_S` up to a frame as columns; none where that is longer ago."""
        with self._changed:
            results = tuple(self._history)
        builder = SeriesBuilder()
        for result in results:
            if result.index <= last_index:
                builder.add(result, ())
        return builder.build()

    def _is_newer(self, frame_index: int) -> bool:
        return self._latest is not None and self._latest.result.index > frame_index
