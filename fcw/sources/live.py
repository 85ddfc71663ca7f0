"""Any source as it happens: played at its own rate, the latest picture only, as a live pipeline needs it."""

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
"""A source that gives nothing for so long is taken to be gone; a camera gives up sooner, with its reason."""
LONGEST_WAIT_S = 2.0
"""A recording's next picture is shown after so long at most: its stamps may have a gap of hours."""
CAPTURES_KEPT = 32
"""Pictures remembered for who shows results; more than a pipeline has under way."""
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
    """Frames of another source as they are due: a thread of its own reads on, and the latest one wins.

    A recording is played at its own rate, but for gaps of more than `LONGEST_WAIT_S`. Frames that nobody was
    ready for are dropped, not shown late; the packets of a relayed video are all handed on, those of dropped
    frames marked as not shown, so that a log's video still decodes. Frames are numbered anew, without gaps.

    Attributes:
        dropped: how many frames nobody was ready for.
        duration_s: from the first frame to the latest.
    """

    def __init__(
        self, source: Source, stop: threading.Event, paced: bool = True, clock: Clock | None = None
    ) -> None:
        """Nothing is read before `frames`.

        Args:
            source: what is played; its frames' times rise.
            stop: once set the frames end.
            paced: whether frames wait for their time; those of a camera come when they come.
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
        """None: how many will not be dropped is not known."""
        return None

    @property
    def relays_video(self) -> bool:
        """The source's."""
        return self._relays

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's, and how many frames were dropped."""
        notes = (*self._source.notes, *((f"{self.name}: {self._gone}",) if self._gone else ()))
        if not self.dropped:
            return notes
        pictures = f"{self.dropped} picture{'s' * (self.dropped != 1)}"
        return (*notes, f"{self.name}: {pictures} skipped to keep up")

    @property
    def trouble(self) -> str:
        """Why no picture comes at present, or any more; empty while they come, and after `stop`."""
        return "" if self._stop.is_set() else self._gone or super().trouble

    def now_s(self) -> float:
        """The present moment on the clock of `Capture.captured_s`."""
        return self._clock.now_s()

    def capture(self, index: int) -> Capture | None:
        """The picture of a frame given a moment ago; from any thread."""
        with self._changed:
            return self._captures.get(index)

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames as they happen, each the latest one at the moment it is asked for.

        Raises:
            UserError: the source cannot be read (any more).
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
        """Wait for a frame; None at the end."""
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
        """Read on by the clock until nobody asks any more; in the reader's thread."""
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
