"""Playing a recorded drive by the clock: the frame that is due is shown, what cannot be is left out."""

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fcw.clock import Clock
from fcw.units import NS_PER_S
from fcw_viz.page.playback import LONGEST_GAP_S, PlayingThread

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Seconds of the drive for each second."""

REST_S = 0.3
"""What is played again and again stands so long at its end: that it begins anew is seen."""


class Player(PlayingThread):
    """Plays the rows of one drive after the other's clock, whatever showing one takes.

    Where a frame takes longer to show than it lasts, the next one shown is the one that is due by then: what
    is seen is never behind by more than one frame's own showing.
    """

    def __init__(
        self,
        ready: Callable[[threading.Event], None],
        show: Callable[[int], None],
        on_end: Callable[[str], None],
        clock: Clock | None = None,
    ) -> None:
        """Nothing is played before `load` and `play`.

        Args:
            ready: returns once another frame can be shown, or the event is set; in the player's thread.
            show: shows a row; called in that thread, and may take its time.
            on_end: called there when playing has ended, by whatever; with a message where it failed.
            clock: for tests.
        """
        super().__init__(on_end, clock)
        self._ready = ready
        self._show = show
        self._times_ns: NDArray[np.int64] = np.zeros(0, np.int64)
        self._last_row: int | None = None
        self._again_row: int | None = None

    def load(self, times_ns: NDArray[np.int64]) -> None:
        """Play another drive from now on: the times of its frames, ascending."""
        self.stop()
        self._times_ns, self._last_row, self._again_row = times_ns, None, None

    def play_to(
        self, start_row: int, last_row: int | None, speed: float, again_row: int | None = None
    ) -> None:
        """Play from a row to another, which is shown last.

        Args:
            start_row: the first one.
            last_row: None for the drive's end.
            speed: seconds of the drive for each second.
            again_row: from which it is played again and again; None to play it once.
        """
        self.stop()
        self._last_row, self._again_row = last_row, again_row
        self.play(start_row, speed)

    def _play(self, start_index: int, speed: float, stop: threading.Event) -> None:
        clock, times_ns = self._clock, self._times_ns
        last = len(times_ns) - 1 if self._last_row is None else min(self._last_row, len(times_ns) - 1)
        row = min(start_index, last)
        started_s, first_ns = clock.now_s(), int(times_ns[row])
        while row < last:
            next_due_s = started_s + (int(times_ns[row + 1]) - first_ns) / NS_PER_S / speed
            if (skipped_s := next_due_s - clock.now_s() - LONGEST_GAP_S / speed) > 0:
                started_s, next_due_s = started_s - skipped_s, next_due_s - skipped_s
            clock.wait_s(max(next_due_s - clock.now_s(), 0.0), stop)
            self._ready(stop)
            if stop.is_set():
                return
            due_ns = first_ns + (clock.now_s() - started_s) * speed * NS_PER_S
            # The clock may wait a trifle less than it was told to.
            due = int(np.searchsorted(times_ns, due_ns, side="right")) - 1
            row = min(max(due, row + 1), last)
            self._show(row)
            if row >= last and self._again_row is not None and self._again_row < last:
                clock.wait_s(REST_S, stop)
                if stop.is_set():
                    return
                row = self._again_row
                self._show(row)
                started_s, first_ns = clock.now_s(), int(times_ns[row])
