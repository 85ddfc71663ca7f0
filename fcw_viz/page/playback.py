"""Playback in real time, which skips pictures rather than showing them late."""

import logging
import threading
from collections.abc import Callable

from fcw.clock import Clock
from fcw.errors import UserError
from fcw.frame import Frame
from fcw.units import NS_PER_S
from fcw_viz.page.pictures import Pictures

LARGEST_LAG_S = 0.4
"""At least one picture is shown in this time; if skipping pictures is not enough, playback slows down."""
STOP_CHECK_S = 0.02
"""How often the player checks, while it waits for the thread that shows, whether that wants it to stop."""
KEY_ECHO_S = 0.3
"""The space key also presses the button that was clicked last; within this time both count once."""
LONGEST_GAP_S = 2.0
"""Longest gap of a drive that is waited for: its times may have a gap of hours."""

_log = logging.getLogger(__name__)


class PlayingThread:
    """A thread that plays something; a subclass defines it in `_play`.

    The thread starts with `play`.
    """

    def __init__(self, on_end: Callable[[str], None], clock: Clock | None = None) -> None:
        """Make the player; nothing plays yet.

        Args:
            on_end: called in its thread when playing has ended for any reason, with a message if it could not
                go on, else with an empty text.
            clock: for tests.
        """
        self._on_end = on_end
        self._clock = clock or Clock()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def playing(self) -> bool:
        """Whether it is playing."""
        return self._thread is not None and not self._stop.is_set()

    def play(self, start_index: int, speed: float = 1.0) -> None:
        """Play from a picture on, instead of what is playing now.

        Args:
            start_index: number of the first picture.
            speed: seconds of the drive per second.
        """
        with self._lock:
            self._end()
            self._stop = threading.Event()
            self._thread = threading.Thread(
                target=self._run, args=(start_index, speed, self._stop), name="playback", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Stop; after this returns, no further picture is shown (unless it is called while one is shown)."""
        with self._lock:
            self._end()

    def _play(self, start_index: int, speed: float, stop: threading.Event) -> None:
        """Play until the end, or until `stop` is set.

        Raises:
            UserError: it cannot go on.
        """
        raise NotImplementedError

    def _end(self) -> None:
        self._stop.set()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join()

    def _run(self, start_index: int, speed: float, stop: threading.Event) -> None:
        message = ""
        try:
            self._play(start_index, speed, stop)
        except UserError as error:
            message = str(error)
        except Exception:
            _log.exception("playback failed")
            message = "playback failed; the server's log says why"
        stop.set()
        self._on_end(message)


class Playback(PlayingThread):
    """Plays the pictures of one tab, decoding them one after another."""

    def __init__(
        self,
        pictures: Pictures,
        show: Callable[[Frame], None],
        on_end: Callable[[str], None],
        clock: Clock | None = None,
    ) -> None:
        """Make the player; the thread starts with `play`.

        Args:
            pictures: pictures of the drive.
            show: shows a frame; called in the thread of the player. It may take its time, but must return
                soon after playing was stopped.
            on_end: called in that thread when playing has ended for any reason, with a message if pictures
                could no longer be read, else with an empty text.
            clock: for tests.
        """
        super().__init__(on_end, clock)
        self._pictures = pictures
        self._show = show

    def _play(self, start_index: int, speed: float, stop: threading.Event) -> None:
        clock, period_s = self._clock, 1 / self._pictures.frame_rate_hz / speed
        longest_s = LONGEST_GAP_S / speed
        started_s = shown_s = clock.now_s()
        first_ns: int | None = None
        left_out: Frame | None = None
        for frame in self._pictures.play(start_index):
            if first_ns is None:
                first_ns = frame.time_ns
                started_s = shown_s = clock.now_s()  # opening the file takes none of the drive's time
            due_s = started_s + (frame.time_ns - first_ns) / NS_PER_S / speed
            if (skipped_s := due_s - clock.now_s() - longest_s) > 0:
                started_s, due_s = started_s - skipped_s, due_s - skipped_s
            clock.wait_s(max(0.0, due_s - clock.now_s()), stop)
            if stop.is_set():
                return
            now_s = clock.now_s()
            late_s = now_s - due_s
            if late_s > period_s and now_s - shown_s < LARGEST_LAG_S:
                left_out = frame
                continue
            if late_s > LARGEST_LAG_S:
                started_s += late_s
            self._show(frame)
            left_out, shown_s = None, clock.now_s()
        if left_out is not None:
            self._show(left_out)  # the drive ends on its last picture
