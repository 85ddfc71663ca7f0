"""The desk of one reviewer: playing, boxes, entries and the screen, and the commands that use them."""

import json
from collections.abc import Callable

from fcw.annotation.records import Judgement
from fcw.errors import UserError
from fcw_viz.page.script import empty_element, focus_element, note_in_address, run_script
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.picture.box_commands import BoxCommands
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.place import Place, moment_text, parse_place, place_text
from fcw_viz.review_app.runs.comparing import Comparing
from fcw_viz.review_app.screen import Screen
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.time.playing import Playing
from fcw_viz.review_app.triage.ahead import Ahead
from fcw_viz.review_app.triage.drive_filter import DriveFilter, Listed

NOTE_ID = "fcw-note"
"""Id of the field for a note."""


class Desk:
    """The desk of one tab; used only in the thread of the tab.

    Attributes:
        view: the picture.
        place: drive, frame and event that are shown.
        playing: plays the drive.
        annotating: stores what the reviewer says.
        boxes: corrects the boxes of a frame.
        box_commands: commands for the selected box.
        runs: another run that the drive is compared with.
        screen: what is shown of the drive.
        ahead: reads the picture of the next unjudged event in advance.
    """

    def __init__(self, tab: PageTab, session: ReviewSession, show_panels: Callable[[], None]) -> None:
        """Begin without an open drive.

        Args:
            tab: the tab of the desk.
            session: what all tabs share.
            show_panels: updates the panels.
        """
        self._client, self._run, self._notify = tab.client, tab.run, tab.notify
        self._session = session
        self._wanted_row: int | None = None
        self.view = tab.view
        self.place = Place(session)
        self.playing = Playing(self.place, tab.run, self)
        self.annotating = Annotating(self.place, tab.notify)
        self.boxes = BoxEditor(tab, self.place, self.annotating, show_panels)
        self.box_commands = BoxCommands(self.place, self.boxes, self.go_to, tab.notify)
        self.runs = Comparing(self.place, tab.run, self.go_to_time, self.refresh)
        self.screen = Screen(tab, self.place, self.playing, self.boxes, self.runs, show_panels)
        self.ahead = Ahead(self.place)
        self.view.on_click(self.boxes.click)
        self.view.on_view_change(self.boxes.redraw)

    # Drives

    def show_list(self) -> None:
        """Go back to the list of drives."""
        if self._session.folder.several:
            self._close_drive()

    def _close_drive(self) -> None:
        if self.place.drive is not None:
            self._focus_left(self.place.drive.name)
        self._leave_drive()
        self._session.release(self.place)
        self._note_address("")
        self.refresh()

    def open_at(self, text: str) -> None:
        """Open a drive at its worst moment, or at the place after its name: `#<event>` or `@<seconds>`.

        Raises:
            UserError: there is no such drive, or it is damaged; it is not left half open.
        """
        name, event, moment_s = parse_place(text)
        if not self._session.folder.several:
            name = next(iter(self._session.drives))  # whatever it was called when the place was noted
        drive = self._session.open(self.place, name)
        self._leave_drive()
        self.place.enter(drive, event, moment_s)
        self.playing.load(drive)
        if not drive.complete:
            self._notify("This log is not finished", "It is shown up to its last frame.", trouble=True)
        try:
            self.screen.open(drive, self.ahead.take(drive))
            self.refresh()
        except UserError:
            self._close_drive()
            raise

    def follow(self) -> None:
        """Update the open drive, and the run that it is compared with, from their logs."""
        if self.place.drive is not None:
            self._follow_drive(self.place.drive)
            self.runs.follow()

    def _follow_drive(self, before: Drive) -> None:
        """Update the open drive if its log has grown or was replaced."""
        place, drive = self.place, self._session.current(before.name)
        if drive is before:
            return
        goes_on = drive.origin is before.origin
        if not goes_on:
            self._notify("This drive was run again", "The page now shows the new log.", trouble=True)
        plays, at_end = self.playing.now, place.row == before.last_row
        self.playing.stop()
        place.turn_to(drive)
        self.playing.load(drive)
        self.screen.turn_to_drive(drive, goes_on)
        if plays:
            self.playing.go_on()
        elif at_end and goes_on:
            self.go_to(drive.last_row)  # who looks at the end keeps looking at the end

    def _focus_left(self, name: str) -> None:
        """Put the focus of the list on the drive, or the moment, that is left."""
        row = f"{name}#{self.place.selected}" if self.place.asked.listed is Listed.MOMENTS else name
        run_script(self._client, f"window.fcwChannel.row = {json.dumps(row)};")

    def _leave_drive(self) -> None:
        self.playing.stop()
        self.screen.leave_boxes()
        self.screen.close()
        self.runs.leave()
        self.place.leave()
        self._wanted_row = None

    # Moments

    def go_to_time(self, time_s: float) -> None:
        """Show the frame at a time."""
        self.go_to(self.place.opened.row_at(time_s))

    def go_to(self, row: int) -> None:
        """Show a frame; of several requests at once, only the last one is read."""
        self.playing.stop()
        waits = self._wanted_row is not None
        self._wanted_row = min(max(row, 0), self.place.opened.last_row)
        if not waits:
            self._run(self._load_wanted)

    def step(self, frames: int) -> None:
        """Go forward or back by so many frames from the one requested last."""
        self.go_to((self.place.row if self._wanted_row is None else self._wanted_row) + frames)

    def skip(self, seconds: float) -> None:
        """Go forward or back by so much time."""
        self.go_to_time(self.place.time_s + seconds)

    def select_event(self, number: int) -> None:
        """Select an event, and show its worst moment."""
        self.place.selected = number
        self.go_to_time(self.place.opened.events[number].peak_s)

    def next_event(self, forward: bool) -> None:
        """Select the next event by time, or the one before."""
        self.select_event(self.place.next_event(forward))

    def next_listed(self, forward: bool) -> None:
        """Select the next event of the sorted list, or the one before."""
        self.select_event(self.place.next_listed(forward))

    def sort(self, by_time: bool) -> None:
        """Change the order of the event list."""
        self.place.by_time = by_time
        self.refresh()

    # A range of the drive

    def mark_start(self, time_s: float | None = None) -> None:
        """Start the marked range at a time, by default at the one that is shown."""
        self.place.mark(start_s=self.place.time_s if time_s is None else time_s)
        self.refresh()

    def mark_end(self, time_s: float | None = None) -> None:
        """End the marked range at a time, by default at the one that is shown."""
        self.place.mark(end_s=self.place.time_s if time_s is None else time_s)
        self.refresh()

    # From one unjudged event to the next

    def ask(self, asked: DriveFilter) -> None:
        """Change the filter of drives and events."""
        self.place.asked = asked
        note_in_address(self._client, "asked", asked.kept_text)
        self.refresh()

    def next_unjudged(self) -> None:
        """Show the next filtered event that nobody has judged, in this drive or another one.

        Raises:
            UserError: there is none.
        """
        place = self.place
        name = None if place.drive is None else place.drive.name
        found = place.asked.next_unjudged(self._session.cards, name, place.selected)
        if found is None:
            unread = self._session.unread
            more = f"; {unread} drives are still being read" if unread else ""
            raise UserError(f"every event that matches the filter is judged{more}")
        if found[0] == name:
            self.select_event(found[1])
        else:
            self.open_at(f"{found[0]}#{found[1]}")

    def switch_goes_on(self) -> None:
        """Switch whether a verdict leads to the next unjudged event."""
        self.place.goes_on = not self.place.goes_on
        self.refresh()

    def judge(self, judgement: Judgement) -> None:
        """Give a verdict on the selected event, and go on to the next one if that is switched on."""
        self.annotating.judge(judgement)
        if self.place.goes_on and self.annotating.own_verdict is not None:
            self.next_unjudged()

    def undo(self) -> None:
        """Undo the last step of this tab, in the drive that it belongs to."""
        name = self.annotating.last_drive
        if name is not None and self.place.drive is not None and name != self.place.drive.name:
            self.open_at(place_text(name))
        self.annotating.undo()

    # Words

    def keep_note(self, text: str) -> None:
        """Store a note on the moment, and then clear its field."""
        self.annotating.add_note(text)
        empty_element(self._client, NOTE_ID, text)

    def type_note(self) -> None:
        """Put the cursor into the field for a note, for the command palette; the browser handles the key."""
        self.place.opened  # noqa: B018 - raises where no drive is open
        focus_element(self._client, NOTE_ID)

    def escape(self) -> None:
        """Put the tool away, and stop playing."""
        self.playing.stop()
        if self.boxes.active:
            self.screen.switch_boxes()
        elif self.screen.birds_eye.active:
            self.screen.switch_birds_eye()
        elif self.place.marked is not None:
            self.place.marked = None
            self.refresh()

    def refresh(self) -> None:
        """Update everything except the picture."""
        with self._client.atomic():
            self.screen.refresh()
            if self.place.drive is not None:
                self._note_moment()
        self.ahead.look()

    # What playing asks for

    def before_playing(self) -> None:
        """Prepare for playing: boxes are not corrected while frames follow each other."""
        self.screen.leave_boxes()

    def turn_to(self, row: int, played: bool) -> None:
        """Show a frame, and update everything that depends on it."""
        self.screen.turn_to(row, played)

    def speed_changed(self) -> None:
        """Update the page after playing started, stopped or changed its speed."""
        self.screen.show_bar()

    def after_playing(self, trouble: str) -> None:
        """Show the present picture again in full quality after playing has ended."""
        if trouble:
            self._notify(trouble, trouble=True)
        if self._wanted_row is None:
            self.screen.show_picture()
        self.refresh()

    def _load_wanted(self) -> None:
        row, self._wanted_row = self._wanted_row, None
        if row is not None and self.place.drive is not None:
            self.screen.turn_to(row)
            self._note_moment()

    def _note_moment(self) -> None:
        self._note_address(moment_text(self.place.opened.name, self.place.time_s))

    def _note_address(self, text: str) -> None:
        """Write the place into the address of the page."""
        note_in_address(self._client, "at", text)
