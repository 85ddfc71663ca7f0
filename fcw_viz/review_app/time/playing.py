"""Playing in a tab: the player's frames are shown in the tab's thread, as fast as the browser draws them."""

import threading
import time
from typing import Protocol

from fcw.errors import UserError
from fcw_viz.page.controls import Run
from fcw_viz.page.playback import KEY_ECHO_S, STOP_CHECK_S
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.place import LEAD_IN_S, Place
from fcw_viz.review_app.time.player import SPEEDS, Player

DRAWN_PATIENCE_S = 0.5
"""A browser that does not say that it has drawn a picture gets the next one after this."""


class Stage(Protocol):
    """What playing asks of what shows the drive; all of it in the tab's thread."""

    def before_playing(self) -> None:
        """Frames follow each other from now on."""
        ...

    def turn_to(self, row: int, played: bool) -> None:
        """Show a frame now; a played one in less quality."""
        ...

    def speed_changed(self) -> None:
        """It plays or not, or faster than before."""
        ...

    def after_playing(self, trouble: str) -> None:
        """Playing has ended; with words where it could not go on."""
        ...


class Playing:
    """Plays the drive of one tab.

    Attributes:
        speed: seconds of the drive for each second, one of `SPEEDS`.
    """

    def __init__(self, place: Place, run: Run, stage: Stage) -> None:
        """Nothing is played yet.

        Args:
            place: where the person is; the drive there is played from there.
            run: runs work in the tab's thread.
            stage: shows it.
        """
        self._place, self._run, self._stage = place, run, stage
        self.speed = 1.0
        self._toggled_s = float("-inf")
        self._part: tuple[int | None, int | None] = None, None
        self._drawn = threading.Event()
        self._player = Player(self._wait_drawn, self._show, lambda message: run(lambda: self._ended(message)))

    @property
    def now(self) -> bool:
        """Whether it plays now."""
        return self._player.playing

    def load(self, drive: Drive) -> None:
        """Play another drive from now on."""
        self._player.load(drive.series.time_ns)

    def stop(self) -> None:
        """Stop; no further frame is shown."""
        self._player.stop()

    def toggle(self) -> None:
        """Play on from the moment that is shown, or stop; from the last frame it begins anew."""
        now_s = time.monotonic()
        if now_s - self._toggled_s < KEY_ECHO_S:
            return
        self._toggled_s = now_s
        if self.now:
            self.stop()
        else:
            self._play(0 if self._place.row >= self._place.opened.last_row else self._place.row)

    def go_on(self) -> None:
        """Play on from the moment that is shown, after the drive has changed."""
        self._play(self._place.row)

    def play_event(self) -> None:
        """Play the selected event, from a little before it to its end."""
        place = self._place
        if place.selected is None:
            raise UserError("select an event first: click one in the list, or press N")
        event = place.opened.events[place.selected]
        self._play(place.opened.row_at(event.start_s - LEAD_IN_S), place.opened.row_at(event.end_s))

    def loop(self) -> None:
        """Play the marked range, else the selected event, again and again; or stop."""
        if self.now:
            self.stop()
            return
        place = self._place
        span = place.marked
        if span is None and place.selected is not None:
            event = place.opened.events[place.selected]
            span = event.start_s - LEAD_IN_S, event.end_s
        if span is None:
            raise UserError("mark a range first, with A and S, or select an event")
        first = place.opened.row_at(span[0])
        self._play(first, place.opened.row_at(span[1]), first)

    def set_speed(self, speed: float) -> None:
        """Play so much faster."""
        if speed not in SPEEDS:
            return
        self.speed = speed
        if self.now:
            self._play(self._place.row, *self._part)
        self._stage.speed_changed()

    def change_speed(self, faster: bool) -> None:
        """The next speed up or down."""
        place = SPEEDS.index(self.speed) + (1 if faster else -1)
        self.set_speed(SPEEDS[min(max(place, 0), len(SPEEDS) - 1)])

    def sent(self) -> None:
        """A picture is on its way to the browser."""
        self._drawn.clear()

    def drawn(self) -> None:
        """The browser has drawn a picture."""
        self._drawn.set()

    def _play(self, row: int, last_row: int | None = None, again_row: int | None = None) -> None:
        self._stage.before_playing()
        self.stop()
        if row != self._place.row:
            self._stage.turn_to(row, played=True)
        self._part = last_row, again_row
        self._player.play_to(row, last_row, self.speed, again_row)
        self._stage.speed_changed()

    def _wait_drawn(self, stop: threading.Event) -> None:
        """Wait until the browser has drawn the last picture; in the player's thread."""
        end_s = time.monotonic() + DRAWN_PATIENCE_S
        while not stop.is_set() and time.monotonic() < end_s:
            if self._drawn.wait(STOP_CHECK_S):
                return

    def _show(self, row: int) -> None:
        """Have a frame of the drive that plays shown; in the player's thread, which waits for it."""
        shown = threading.Event()

        def show() -> None:
            if self.now:
                self._stage.turn_to(row, played=True)
            shown.set()

        self._run(show)
        while self.now and not shown.wait(STOP_CHECK_S):
            pass

    def _ended(self, message: str) -> None:
        if not self.now and self._place.drive is not None:
            self._stage.after_playing(message)
