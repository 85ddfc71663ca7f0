"""Plays any source in real time and gives only its latest picture, as a live pipeline needs it."""

import threading
import time
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.clock import Clock
from fcw.frame import Frame, Source
from fcw.sources.forwarding import ForwardingSource
from fcw.units import NS_PER_S

PATIENCE_S = 120.0
"""A source that gives nothing for so long counts as gone. A camera gives up sooner, with a reason."""
LONGEST_WAIT_S = 2.0
"""Longest wait for a recording's next picture: its times may have a gap of hours."""
CAPTURES_KEPT = 32
"""Number of pictures kept for those who show results; more than a pipeline has under way."""
STOP_CHECK_S = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """A picture and when it came.

    Attributes:
        image: (height, width, 3) BGR, not to be changed.
        captured_s: the moment, on the clock of its `LiveSource`.
    """

    image: NDArray[np.uint8]
    captured_s: float


class LiveSource(ForwardingSource):
    """Gives the frames of another source when they are due. A thread reads ahead, and the latest frame wins.

    A recording is played at its own rate, except for gaps longer than `LONGEST_WAIT_S`. A frame that was not
    taken in time is dropped and not shown late. All packets of a relayed video are passed on, those of
    dropped frames marked as not shown, so that the video in the log still decodes. Frames are numbered anew,
    without gaps.

    Attributes:
        dropped: how many frames were dropped.
        duration_s: from the first frame to the latest.
    """

    def __init__(
        self, source: Source, stop: threading.Event, paced: bool = True, clock: Clock | None = None
    ) -> None:
        """Prepare; nothing is read before `frames` is called.

        Args:
            source: the source to play; the times of its frames rise.
            stop: once it is set, the frames end.
            paced: whether frames wait until they are due; those of a camera need not.
            clock: for tests.
        """
        super().__init__(source)
        self._stop, self._clock = stop, clock or Clock()
        self._relays = source.relays_video
        self._paced = paced
        self._changed = threading.Condition()
        self._latest: tuple[Frame, float] | None = None
        self._error: BaseException | None = None
        self._ended = False
        self._not_due = False
        self._gone = ""
        self._captures: OrderedDict[int, Capture] = OrderedDict()
        self.dropped = 0
        self.duration_s = 0.0

    @property
    def frame_count(self) -> int | None:
        """None: how many frames will be dropped is not known."""
        return None

    @property
    def relays_video(self) -> bool:
        """The source's."""
        return self._relays

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's notes, and how many frames were dropped."""
        notes = (*self._source.notes, *((f"{self.name}: {self._gone}",) if self._gone else ()))
        if not self.dropped:
            return notes
        pictures = f"{self.dropped} picture{'s' * (self.dropped != 1)}"
        return (*notes, f"{self.name}: {pictures} skipped to keep up")

    @property
    def trouble(self) -> str:
        """Why no picture comes now, or will come any more; empty while pictures come and after `stop`."""
        return "" if self._stop.is_set() else self._gone or super().trouble

    def now_s(self) -> float:
        """The current time on the clock of `Capture.captured_s`."""
        return self._clock.now_s()

    def capture(self, index: int) -> Capture | None:
        """The picture of a recent frame; may be called from any thread."""
        with self._changed:
            return self._captures.get(index)

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames in real time, each the latest one at the moment it is asked for.

        Raises:
            UserError: the source cannot be read, or no longer.
        """
        left = threading.Event()
        with self._changed:
            self._latest, self._error, self._ended, self._gone = None, None, False, ""
            self._not_due = False
        reader = threading.Thread(target=self._read, args=(start_ns, left), name="live", daemon=True)
        reader.start()
        try:
            index = 0
            while (taken := self._take()) is not None:
                frame, captured_s = taken
                frame = replace(frame, index=index)
                with self._changed:
                    self._captures[index] = Capture(frame.image, captured_s)
                    while len(self._captures) > CAPTURES_KEPT:
                        self._captures.popitem(last=False)
                yield frame
                index += 1
        finally:
            left.set()

    def _take(self) -> tuple[Frame, float] | None:
        """Wait for the next frame; None at the end."""
        patience_s = time.monotonic() + PATIENCE_S
        with self._changed:
            while self._latest is None and not self._ended and not self._stop.is_set():
                self._changed.wait(STOP_CHECK_S)
                if self._not_due:
                    patience_s = time.monotonic() + PATIENCE_S
                elif self._latest is None and time.monotonic() > patience_s:
                    self._gone = f"no picture for {PATIENCE_S:.0f} s, so the drive ends"
                    return None
            if self._stop.is_set():
                return None
            taken, self._latest = self._latest, None
            if taken is None and self._error is not None:
                raise self._error
            return taken

    def _read(self, start_ns: int | None, left: threading.Event) -> None:
        """Read frames when they are due until `stop` or `left` is set; runs in the reader's thread."""
        try:
            started_s, first_ns = 0.0, None
            for frame in self._source.frames(start_ns):
                if first_ns is None:
                    started_s, first_ns = self._clock.now_s(), frame.time_ns
                self.duration_s = (frame.time_ns - first_ns) / NS_PER_S
                early_s = started_s + self.duration_s - self._clock.now_s()
                if self._paced and early_s > 0:
                    started_s -= max(early_s - LONGEST_WAIT_S, 0.0)
                    self._not_due = True
                    self._clock.wait_s(min(early_s, LONGEST_WAIT_S), self._stop)
                if self._stop.is_set() or left.is_set():
                    return
                self._put(frame)
        except BaseException as error:
            self._error = error  # raised where the frames are taken
        finally:
            with self._changed:
                self._ended = True
                self._changed.notify_all()

    def _put(self, frame: Frame) -> None:
        with self._changed:
            if self._latest is not None:
                self.dropped += 1
                # Its picture is not seen, but later ones cannot be decoded without it.
                unseen = (replace(packet, shown=False) for packet in self._latest[0].packets)
                frame = replace(frame, packets=(*unseen, *frame.packets))
            self._latest, self._not_due = (frame, self._clock.now_s()), False
            self._changed.notify_all()
