"""The desk of one person in a session: what they see, and everything that they do.

All of it happens in one thread, that of the picture, in the order in which it is clicked, typed and shown.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from fcw.errors import UserError
from fcw_viz.calibrate_app.document.besides.plates import AddPlatePlace
from fcw_viz.calibrate_app.document.besides.rectangles import AddCorner
from fcw_viz.calibrate_app.document.document import Mark
from fcw_viz.calibrate_app.document.edits import AddMark, DeleteMark, Edit, EnableMark, MoveMark
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.ways import clicks_corners, clicks_plates
from fcw_viz.calibrate_app.drawing.overlay import PictureOverlay
from fcw_viz.calibrate_app.fields import NumberFields
from fcw_viz.calibrate_app.proposals.drive_look import DriveLooks
from fcw_viz.calibrate_app.session import CalibrationSession, Person
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.channel import PageChannel
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.script import expect_no_typing, expect_typing
from fcw_viz.page.tab import PageTab

PLATE_PICTURE_PX, ZOOMED_PICTURE_PX = 900.0, 1280.0
"""Widths in CSS pixels. In a picture narrower than the first, the ends of a plate are too close together for
clicks. In one as wide as the second, those of a car 16 m ahead are 30 apart, and its tyre is in the window of
a phone."""


def mark_handle(mark_id: int) -> str:
    """The name of the handle of a mark in the view."""
    return f"mark_{mark_id}"


class Display(Protocol):
    """What displays a desk."""

    def show(self) -> None:
        """Show the present state of the desk."""
        ...

    def ask_distance(self, mark_id: int) -> None:
        """Put the cursor into the field for the distance of a mark."""
        ...


class Desk:
    """The desk of one tab, which the panels, the keys and the handles use, and a display shows.

    Attributes:
        client: the side of the browser.
        source: path of the source of the pictures.
        session: what all tabs share.
        pictures: pictures of the source.
        looks: measurements of the whole drive.
        channel: messages from the page's own HTML.
        view: the picture of this tab.
        run: runs something in the thread of this tab, after everything that came before.
        notify: shows a message to the user.
        overlay: what is drawn over the picture.
        fields: the fields for numbers.
        person: the person at this desk, from `sit_down` on.
        state: the state that is shown.
        selected: id of the selected mark.
        tool: what a click does.
        tool_words: what to do with the tool; empty for the points.
        frame_index: number of the picture that is shown.
    """

    person: Person

    def __init__(
        self,
        tab: PageTab,
        session: CalibrationSession,
        pictures: Pictures,
        source: Path,
        display: Display,
        looks: DriveLooks,
    ) -> None:
        self.client, self.view = tab.client, tab.view
        self.run, self.notify, self._refuse = tab.run, tab.notify, tab.refuse
        self.source = source
        self.session = session
        self.pictures = pictures
        self.looks = looks
        self.channel = PageChannel(tab.client, tab.run)
        self.selected: int | None = None
        self.tool = Tool.POINTS
        self.tool_words = ""
        self.frame_index = 0
        self.state: SessionState = session.state
        self.overlay = PictureOverlay(tab.view, tab.client)
        self.fields = NumberFields(tab.run)
        self._display = display
        self._newest = self.state
        self._refresh_waits = True  # what is heard while joining is shown once it is known who this is
        self._asks = False, ""
        self._wanted_frame: int | None = None
        self._zoomed_on_plate = False
        self._tool_click: Callable[[float, float], None] = self._add_mark

    def sit_down(self) -> None:
        """Join the session and show it, after the display is ready."""
        self.channel.open()
        self._forget_looks = [look.listen(lambda: self.run(self.refresh)) for look in self.looks]
        self.view.on_click(self._clicked)
        self.person = self.session.join(self._hear)
        self.run(self.refresh)
        frames = [mark.frame for mark in self.state.document.marks if mark.frame is not None]
        self.go_to(frames[0] if frames else 0)

    def leave(self) -> None:
        """Store what was being typed, and leave the session, after the tab was closed."""
        for forget in self._forget_looks:
            forget()
        self.fields.flush()
        self.session.leave(self.person)

    def offer(self, *edits: Edit) -> None:
        """Apply one step for a field, which itself shows why it was refused.

        Raises:
            UserError: it was refused.
        """
        self.session.apply(self.person, *edits)

    def apply(self, *edits: Edit) -> bool:
        """Apply one step; if it is refused, show why and return False."""
        return self._try(lambda: self.session.apply(self.person, *edits))

    def preview(self, edit: Edit | None) -> None:
        """Show what an edit would do, while dragging; None ends the preview."""
        self._try(lambda: self.session.preview(self.person, edit))

    def undo(self) -> None:
        """Undo the last step, by whoever it was."""
        self._try(lambda: self.session.undo(self.person))

    def redo(self) -> None:
        """Redo the last undone step."""
        self._try(lambda: self.session.redo(self.person))

    def save(self) -> None:
        """Write the calibration file, and show that it was saved."""
        self.session.look_at_file()
        already = self.session.state.saved
        if self._try(self.session.save):
            name = self.session.state.save_path.name
            self.notify(f"{name} is already saved" if already else f"Saved {name}")

    def start_anew(self) -> None:
        """Clear everything; undo brings it back."""
        self._try(lambda: self.session.start_anew(self.person))

    def select(self, mark_id: int | None) -> None:
        """Select a mark, or none."""
        if mark_id != self.selected:
            self.fields.flush()
            self.selected = mark_id
            self.refresh()

    def click_mark(self, mark_id: int) -> None:
        """Select a mark on the picture without asking for its distance."""
        self.select(mark_id)
        expect_no_typing(self.client)

    def use(
        self, tool: Tool, on_click: Callable[[float, float], None] | None = None, words: str = ""
    ) -> None:
        """Take another tool; clicks on the picture go to `on_click` until the next tool is taken."""
        self.tool = tool
        self.tool_words = words
        self._tool_click = on_click or self._add_mark
        self.refresh()

    def escape(self) -> None:
        """Put the tool away, and unselect."""
        self.selected = None
        self.view.magnify(None)
        self.use(Tool.POINTS)

    def go_to(self, frame_index: int) -> None:
        """Show another picture; of several requests at once, only the last one is read."""
        self._wanted_frame = min(max(frame_index, 0), self.pictures.count - 1)
        self.run(self._load_frame)

    def step(self, pictures: int) -> None:
        """Go forward or back by so many pictures from the one requested last."""
        self.go_to((self.frame_index if self._wanted_frame is None else self._wanted_frame) + pictures)

    def zoom(self, factor: float) -> None:
        """Zoom at the selected mark, or at the middle."""
        mark = self._selected_mark()
        self.view.zoom(factor, None if mark is None else (mark.column_px, mark.row_px))

    def nudge(self, columns_px: float, rows_px: float) -> None:
        """Move the selected mark a little."""
        mark = self._told_mark()
        self.apply(MoveMark(mark.id, mark.column_px + columns_px, mark.row_px + rows_px))
        self.view.magnify(mark_handle(mark.id))

    def switch_selected(self) -> None:
        """Switch the selected mark on or off."""
        mark = self._told_mark()
        self.apply(EnableMark(mark.id, not mark.enabled))

    def delete_selected(self) -> None:
        """Delete the selected mark."""
        self.apply(DeleteMark(self._told_mark().id))

    def go_to_selected(self) -> None:
        """Show the picture in which the selected mark was clicked."""
        mark = self._told_mark()
        if mark.frame is None:
            raise UserError(
                f"{mark.name} comes from a file that does not say which picture it was clicked in"
            )
        self.go_to(mark.frame)

    def type_distance(self) -> None:
        """Put the cursor into the field of the selected mark."""
        self._display.ask_distance(self._told_mark().id)

    def refresh(self) -> None:
        """Show the latest state, with the selection, tool and picture of this desk."""
        self._refresh_waits = False
        self.state = self._newest
        if self._selected_mark() is None:
            self.selected = None
        # What is typed right after a click on the picture, or after D, is the distance that it asks for.
        document = self.state.document
        planned = document.next_planned_m is not None
        other = clicks_corners(document) or clicks_plates(document)
        asks = self.tool is Tool.POINTS and not (planned or other), "" if self.selected is None else "d"
        if asks != self._asks:
            self._asks = asks
            expect_typing(self.client, *asks)
        self._display.show()

    def _hear(self, state: SessionState) -> None:
        """The listener of the session; of several states at once, only the last one is drawn."""
        self._newest = state
        if not self._refresh_waits:
            self._refresh_waits = True
            self.run(self.refresh)

    def _clicked(self, column_px: float, row_px: float) -> None:
        self.fields.flush()
        self._tool_click(column_px, row_px)

    def _add_mark(self, column_px: float, row_px: float) -> None:
        if clicks_corners(self.session.state.document):
            self.apply(AddCorner(column_px, row_px))
            return
        if clicks_plates(self.session.state.document):
            self._click_plate(column_px, row_px)
            return
        if not self.apply(AddMark(column_px, row_px, self.frame_index)):
            expect_no_typing(self.client)
            return
        marks = self.session.state.document.marks
        added = next((m for m in reversed(marks) if (m.column_px, m.row_px) == (column_px, row_px)), None)
        if added is not None:
            self.selected = added.id
            self.refresh()
            if added.distance_m is None:
                self._display.ask_distance(added.id)

    def _click_plate(self, column_px: float, row_px: float) -> None:
        """Add a place of a plate; if the picture is too small, the first click only zooms in on the plate."""
        left_px, _, right_px, _ = self.view.window_px
        shown_px = self.view.plane.size.width / self.view.pixels_per_screen_pixel
        if shown_px < PLATE_PICTURE_PX:
            self._zoomed_on_plate = True
            self.view.zoom_to(column_px, row_px, (right_px - left_px) * shown_px / ZOOMED_PICTURE_PX)
        elif self.apply(AddPlatePlace(column_px, row_px)):
            document = self.session.state.document
            if self._zoomed_on_plate and document.plates == document.whole_plates:
                self._zoomed_on_plate = False
                self.view.fit()

    def _load_frame(self) -> None:
        index = self._wanted_frame
        if index is not None:
            self._wanted_frame = None
            try:
                image = self.pictures.read(index).image
                self.frame_index = index
                self.view.show(image)
            finally:
                self.refresh()  # what cannot be read leaves the one before

    def _selected_mark(self) -> Mark | None:
        return next((mark for mark in self._newest.document.marks if mark.id == self.selected), None)

    def _told_mark(self) -> Mark:
        """The selected mark, for commands that need one."""
        mark = self._selected_mark()
        if mark is None:
            raise UserError("select a point first: click it, or press its number")
        return mark

    def _try(self, work: Callable[[], object]) -> bool:
        self.fields.flush()
        try:
            work()
        except UserError as error:
            self._refuse(error)
            return False
        return True
