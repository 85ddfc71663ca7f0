"""One browser tab: the drive and the moment it looks at, and what the person in it does.

All of a tab happens in one thread, its picture's: what is clicked, pressed and shown, in the order it came.
"""

import json
import threading
import time
from collections.abc import Callable

import viser

from fcw.annotation.review import JudgedEvent
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.page.channel import PageChannel
from fcw_viz.page.keys import add_keys
from fcw_viz.page.picture.view import PictureView
from fcw_viz.page.script import focus_element, install, run_script
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.keys import all_keys
from fcw_viz.review_app.panels.event_list import list_order
from fcw_viz.review_app.panels.layout import NOTE_ID, Panels
from fcw_viz.review_app.picture.birds_eye_view import BirdsEye
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.screen import STILL_QUALITY, Screen
from fcw_viz.review_app.session import DriveReview, ReviewSession
from fcw_viz.review_app.time.playing import DRAWN_PATIENCE_S, LEAD_IN_S, Playing

NOTIFICATION_S = 6.0
FIRST_SIZE = ImageSize(1280, 720)
"""Of the picture before a drive is opened."""
PANELS_S = 0.4
"""While the drive plays the panel at the right follows in such steps."""


class Tab:
    """One tab on a session.

    Attributes:
        client: the browser's side.
        session: what all tabs share.
        folder: what all drives together are called.
        view: the picture of this tab.
        drive: that is open; None where the list of drives is seen.
        row: the frame that is shown.
        selected: number of the event that is judged; None for none.
        by_time: the order of the event list.
        screen: what is shown of the drive.
        birds_eye: the same from above.
        playing: plays it.
        annotating: what is said here of it.
        boxes: corrects the boxes of a frame.
        panels: at the right.
    """

    def __init__(self, client: viser.ClientHandle, session: ReviewSession, folder: str, dark: bool) -> None:
        self.client = client
        self.session = session
        self.folder = folder
        self.drive: Drive | None = None
        self.row = 0
        self.selected: int | None = None
        self.by_time = False
        self._wanted_row: int | None = None
        self._refresh_waits = self._rest_waits = self._closed = False
        self._panels_s = float("-inf")

        install(client, f"{folder} · fcw review")
        self.view = PictureView(client, FIRST_SIZE)
        self.birds_eye = BirdsEye(client, self.view)
        self.playing = Playing(self)
        self.annotating = Annotating(self)
        self.boxes = BoxEditor(self)
        self.panels = Panels(client.gui, self, dark)
        self.screen = Screen(self)
        add_keys(client.gui, self, all_keys(), self.run)
        self.view.on_click(self.boxes.click)
        self.view.on_view_change(self.boxes.redraw)
        session.join(self, self._hear)
        self._open_channel()
        self.view.tell_drawn()

    def close(self) -> None:
        """The tab is gone."""
        self._closed = True
        self.playing.stop()
        self.session.leave(self)
        self.view.close()

    def _open_channel(self) -> None:
        channel = PageChannel(self.client, self.run)
        for name, callback in {
            "ready": self._arrive,
            "size": self._resized,
            "drawn": lambda _: self._drawn(),
            "open": self.open_at,
            "list": lambda _: self.show_list(),
            "seek": lambda about: self.go_to_time(float(about)),
            "goto": lambda about: self.go_to_time(float(about)),
            "step": lambda about: self.step(int(about)),
            "play": lambda _: self.playing.toggle(),
            "speed": lambda about: self.playing.set_speed(float(about)),
            "window": self.screen.set_window,
            "event": self._event_clicked,
            "sort": lambda about: self.sort(about == "time"),
            "playevent": lambda _: self.playing.play_event(),
            "birdseye": lambda _: self.screen.switch_birds_eye(),
            **self.annotating.messages,
        }.items():
            channel.on(name, callback)
        channel.open()

    # What the parts are built with

    def run(self, work: Callable[[], object]) -> None:
        """Do something in this tab's thread, after everything that came before."""
        self.view.run_in_order(self._run, work)

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        """Tell the person of this tab something."""
        self.client.add_notification(
            title, text, auto_close_seconds=NOTIFICATION_S, color="orange" if trouble else "green"
        )

    @property
    def review(self) -> DriveReview:
        """What is said of the open drive by now."""
        return self.session.review(self.opened.name)

    @property
    def opened(self) -> Drive:
        """The drive that is open.

        Raises:
            UserError: none is.
        """
        if self.drive is None:
            raise UserError("open a drive first: click one of the list")
        return self.drive

    @property
    def judged(self) -> JudgedEvent | None:
        """The selected event with its verdicts."""
        return None if self.drive is None or self.selected is None else self.review.events[self.selected]

    @property
    def time_s(self) -> float:
        """The moment that is shown."""
        return self.opened.time_s(self.row)

    # Drives

    def show_list(self) -> None:
        """Back to the list of the folder's drives."""
        if len(self.session.drives) < 2:
            return
        self._leave_drive()
        self.session.release(self)
        self._mark_place("")
        self.refresh()

    def open_at(self, place: str) -> None:
        """Open a drive at its worst moment, or at what follows its name: `#<event>` or `@<seconds>`."""
        name, event, moment_s = parse_place(place)
        if len(self.session.drives) == 1:
            name = next(iter(self.session.drives))  # whatever it was called when the place was noted
        drive = self.session.open(self, name)
        self._leave_drive()
        self.drive = drive
        self.playing.load(drive)
        if not drive.complete:
            self.notify("This log was never finished", "It is shown as far as it goes.", trouble=True)
        for trouble in self.review.troubles:
            self.notify("Of the reviews of this drive", trouble, trouble=True)
        if event is None and moment_s is None:
            event = drive.worst_event()
        if event is not None and event < len(drive.events):
            self.selected, moment_s = event, drive.events[event].peak_s
        self.row = drive.row_at(moment_s or 0.0)
        self._follow_event()
        self.screen.open(drive)
        self.refresh()

    def _leave_drive(self) -> None:
        self.playing.stop()
        self.boxes.stop()
        self.screen.close()
        self.drive, self.selected, self._wanted_row = None, None, None

    # Moments

    def go_to_time(self, time_s: float) -> None:
        """Show the frame of a moment."""
        self.go_to(self.opened.row_at(time_s))

    def go_to(self, row: int) -> None:
        """Show a frame; of several asked for at once only the last one is read."""
        self.playing.stop()
        waits = self._wanted_row is not None
        self._wanted_row = min(max(row, 0), self.opened.last_row)
        if not waits:
            self.run(self._load_wanted)

    def step(self, frames: int) -> None:
        """Go on or back by so many frames, from the one asked for last."""
        self.go_to((self.row if self._wanted_row is None else self._wanted_row) + frames)

    def skip(self, seconds: float) -> None:
        """Go on or back by so much time."""
        self.go_to_time(self.time_s + seconds)

    def sort(self, by_time: bool) -> None:
        """List the events in another order."""
        self.by_time = by_time
        self.refresh()

    def select_event(self, number: int) -> None:
        """Show an event at its worst moment; it is the one that is judged."""
        self.selected = number
        self.go_to_time(self.opened.events[number].peak_s)

    def next_event(self, forward: bool) -> None:
        """The next event by time, or the one before."""
        starts_s = [event.peak_s for event in self.opened.events]
        order = sorted(range(len(starts_s)), key=lambda number: starts_s[number])
        if not order:
            raise UserError("there is no event in this drive")
        if self.selected is not None and self._near_selected():
            place = order.index(self.selected) + (1 if forward else -1)
        elif forward:
            place = sum(starts_s[number] <= self.time_s for number in order)
        else:
            place = sum(starts_s[number] < self.time_s for number in order) - 1
        self.select_event(order[min(max(place, 0), len(order) - 1)])

    def next_listed(self, forward: bool) -> None:
        """The next event of the list as it is sorted, or the one before."""
        order = list_order(self.review.events, self.by_time)
        if not order:
            raise UserError("there is no event in this drive")
        if self.selected not in order:
            self.select_event(order[0])
            return
        place = order.index(self.selected) + (1 if forward else -1)
        self.select_event(order[min(max(place, 0), len(order) - 1)])

    def type_note(self) -> None:
        """Put the cursor in the field of a note."""
        self.opened  # noqa: B018 - raises where no drive is open
        focus_element(self.client, NOTE_ID)

    def escape(self) -> None:
        """Put the tool away, and stop."""
        self.playing.stop()
        if self.boxes.active:
            self.boxes.toggle()
        elif self.birds_eye.active:
            self.screen.switch_birds_eye()

    # Showing

    def refresh(self) -> None:
        """Show everything but the picture anew."""
        self._refresh_waits = False
        with self.client.atomic():
            # The ground's size and colours come with the panels: they are first.
            self.panels.show()
            if self.drive is not None:
                self.screen.show_strip()
                self.screen.show_bar()
                self._mark_moment()

    def turn_to(self, row: int, quality: int = STILL_QUALITY) -> None:
        """Show a frame now, and what follows from it."""
        self.row = row
        followed = self._follow_event()
        self.screen.turn(quality)
        now_s = time.monotonic()
        if not self.playing.now:
            # The eye is on the picture: the browser does nothing else before it is drawn.
            self._rest_waits = True
            patience = threading.Timer(DRAWN_PATIENCE_S, self.run, [self._show_rest])
            patience.daemon = True
            patience.start()
        elif followed or now_s - self._panels_s > PANELS_S:
            self._panels_s = now_s
            self.screen.follow()
            self.panels.show()
        else:
            self.screen.follow()

    def _show_rest(self) -> None:
        """What follows from the frame that is shown: plots, and the panel at the right."""
        if self._rest_waits and self.drive is not None:
            self._rest_waits = False
            with self.client.atomic():
                self.screen.follow()
                self.panels.show()

    def _drawn(self) -> None:
        """The browser has drawn a picture."""
        self.playing.drawn()
        self._show_rest()

    def rest(self) -> None:
        """Playing has ended."""
        if self._wanted_row is None:
            self.screen.show_picture()
        self.refresh()

    def _load_wanted(self) -> None:
        row, self._wanted_row = self._wanted_row, None
        if row is not None and self.drive is not None:
            self.turn_to(row)
            self._mark_moment()

    def _near_selected(self) -> bool:
        """Whether the moment is in the selected event, or at it."""
        if self.selected is None:
            return False
        event = self.opened.events[self.selected]
        return event.start_s - LEAD_IN_S <= self.time_s <= event.end_s + LEAD_IN_S

    def _follow_event(self) -> bool:
        """Select the event that the moment is in, the worst of several; whether that is another one."""
        if self._near_selected():
            return False
        events, time_s = self.opened.events, self.time_s
        here = [n for n, event in enumerate(events) if event.start_s <= time_s <= event.end_s]
        if not here:
            return False
        self.selected = max(here, key=lambda number: events[number].severity)
        return True

    # What the browser says

    def _arrive(self, place: str) -> None:
        """The page is there, with the place that its address names."""
        if self.drive is not None:
            return
        if place:
            try:
                self.open_at(place)
            except UserError:
                self._arrive("")
            return
        if len(self.session.drives) == 1:
            self.open_at(next(iter(self.session.drives)))
        else:
            self.refresh()

    def _resized(self, about: str) -> None:
        self.screen.resized(about)
        self.panels.resized(about)

    def _event_clicked(self, about: str) -> None:
        if about in ("next", "previous"):
            self.next_event(about == "next")
        elif about.isdigit() and int(about) < len(self.opened.events):
            self.select_event(int(about))

    def _mark_moment(self) -> None:
        self._mark_place(f"{self.opened.name}@{self.time_s:.3f}")

    def _mark_place(self, place: str) -> None:
        """Keep the place in the page's address: loaded anew, or sent to somebody, it leads there."""
        run_script(
            self.client,
            "const address = new URL(location);"
            f"address.searchParams.set('at', {json.dumps(place)});"
            "history.replaceState(null, '', address);",
        )

    def _hear(self) -> None:
        """The session's listener: of several changes at once only the last one is drawn."""
        if not self._refresh_waits:
            self._refresh_waits = True
            self.run(self._heard)

    def _heard(self) -> None:
        self.refresh()
        self.boxes.review_changed()

    def _run(self, work: Callable[[], object]) -> None:
        if self._closed:
            return
        try:
            work()
        except UserError as error:
            self.notify(str(error), trouble=True)
        except Exception:
            self.notify("That failed by a fault of the program; its terminal says which", trouble=True)
            raise


def parse_place(place: str) -> tuple[str, int | None, float | None]:
    """The drive, and the event or the moment, that a place names."""
    name, sign, rest = place.rpartition("@")
    if sign:
        try:
            return name, None, float(rest)
        except ValueError:
            pass
    name, sign, rest = place.rpartition("#")
    if sign and rest.isdigit():
        return name, int(rest), None
    return place, None, None
