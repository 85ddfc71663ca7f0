"""Correcting the boxes of a frame on the picture: dragged at their corners, drawn, deleted, confirmed."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from fcw.annotation.records import BoxEdit, FrameConfirmed, LabelledBox, new_box_id, track_box_id
from fcw.box import Box
from fcw.errors import UserError
from fcw.logs.overlay import OTHER_TRACK_COLOR, Rgb
from fcw.logs.records import FrameResult
from fcw_viz.page.picture.handle import Handle, Phase
from fcw_viz.page.picture.label_layout import Point
from fcw_viz.page.picture.lines import LabelledLine, LineOverlay, box_line
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.place import Place

LOG_COLOR: Rgb = OTHER_TRACK_COLOR
EDITED_COLOR: Rgb = (70, 200, 110)
SELECTED_COLOR: Rgb = (255, 255, 255)
HANDLE_COLOR: Rgb = (255, 215, 40)
SMALLEST_PX = 3.0
"""A box that is drawn smaller is a slip of the hand."""
CORNERS = ("top left", "top right", "bottom right", "bottom left")
RIGHT, LOW = (False, True, True, False), (False, False, True, True)
"""Of the corners: which are at the right, which at the bottom."""


class BoxEditor:
    """The boxes of the frame that is shown, while they are corrected; in the tab's thread.

    The log's boxes are those of its tracks. An edit of somebody else stands in the place of the log's box,
    as one's own does: the last one counts.

    Attributes:
        active: whether boxes are corrected now.
        selected: id of the box whose corners can be dragged; None for none.
    """

    def __init__(
        self, tab: PageTab, place: Place, annotating: Annotating, show_panels: Callable[[], None]
    ) -> None:
        """Nothing is corrected before `start`.

        Args:
            tab: on whose picture.
            place: where the person is.
            annotating: keeps what is corrected.
            show_panels: brings the panels to the boxes.
        """
        self._view, self._client = tab.view, tab.client
        self._place, self._annotating = place, annotating
        self._show_panels = show_panels
        self._result: FrameResult | None = None
        self._lines = LineOverlay(tab.view, tab.client, "boxes")
        self._handles: list[Handle] = []
        self._dragged: tuple[str, LabelledBox] | None = None
        self._grips_px: tuple[Point, ...] | None = None
        self._labels: dict[str, LabelledBox] = {}
        self.active = False
        self.selected: str | None = None

    # What a person does

    def start(self) -> None:
        """Take the tool; the frame is shown to it next."""
        self.active = True
        self._view.on_box(self.draw)

    def stop(self) -> None:
        """Put the tool away."""
        self.active, self.selected = False, None
        self._dragged = self._grips_px = None
        self._view.on_box(None)
        self.redraw()

    def click(self, column_px: float, row_px: float) -> None:
        """Select the box that was clicked, the smallest where they overlap."""
        if not self.active:
            return
        hit = [
            (label.box.w * label.box.h, box_id)
            for box_id, label in self._labels.items()
            if label.box.x <= column_px <= label.box.right and label.box.y <= row_px <= label.box.bottom
        ]
        self.selected = min(hit)[1] if hit else None
        self.redraw()
        self._show_panels()

    def draw(self, left_px: float, top_px: float, right_px: float, bottom_px: float) -> None:
        """Add a box that was drawn."""
        if right_px - left_px < SMALLEST_PX or bottom_px - top_px < SMALLEST_PX:
            raise UserError(f"this box is smaller than {SMALLEST_PX:g} pixels; draw it larger, or zoom in")
        box_id = new_box_id()
        self.selected = box_id
        self._say(box_id, LabelledBox(self._inside(left_px, top_px, right_px, bottom_px)))

    def delete(self) -> None:
        """Say that there should be no box where the selected one is."""
        box_id = self._told()
        self.selected = None
        self._say(box_id, None)

    def switch_ignored(self) -> None:
        """Say that the selected box is neither to be found nor to be taken for background, or that it is."""
        box_id = self._told()
        label = self._labels[box_id]
        self._say(box_id, replace(label, ignore=not label.ignore))

    def confirm(self) -> None:
        """Say that all boxes of the frame are right as they stand."""
        if not self.active:
            raise UserError("correct boxes first: press E")
        self._annotating.say(FrameConfirmed(self._frame_index))

    # What is shown

    def show(self, result: FrameResult) -> None:
        """Show the boxes of another frame: what the log says of it."""
        self._result = result
        self.redraw()

    def review_changed(self) -> None:
        """Somebody has said something: show it, unless a box is being dragged."""
        if self.active and self._dragged is None:
            self.redraw()

    def redraw(self) -> None:
        """Show the boxes of the frame, the selected one with its corners."""
        if not self.active or self._place.drive is None:
            if self._handles or self._labels:
                self._labels = {}
                self._lines.show(())
                self._show_handles(None)
            return
        self._labels = self._present_labels()
        if self._dragged is not None:
            self._labels[self._dragged[0]] = self._dragged[1]
        if self.selected not in self._labels:
            self.selected = None
        # At once: a handle that has no place yet could be taken hold of anywhere.
        with self._client.atomic():
            self._lines.show([self._line(box_id, label) for box_id, label in self._labels.items()])
            self._show_handles(self._labels[self.selected] if self.selected else None)

    @property
    def confirmed_by(self) -> tuple[str, ...]:
        """Who said that the frame's boxes are right."""
        frame = self._place.review.review.frames.get(self._frame_index)
        return tuple(entry.person for entry in frame.confirmed) if frame else ()

    @property
    def box_count(self) -> tuple[int, int]:
        """How many boxes there are, and how many of them are not the log's."""
        return len(self._labels), len(self._edited())

    @property
    def _frame_index(self) -> int:
        return self._place.opened.frame_index(self._place.row)

    def _edited(self) -> dict[str, LabelledBox | None]:
        frame = self._place.review.review.frames.get(self._frame_index)
        return frame.labels if frame else {}

    def _present_labels(self) -> dict[str, LabelledBox]:
        """The boxes as they stand: of the log's tracks, and edited."""
        result = self._result
        labels: dict[str, LabelledBox | None] = {
            track_box_id(track.track_id): LabelledBox(track.box, track.track_id)
            for track in (result.tracks if result else ())
        }
        labels |= self._edited()
        return {box_id: label for box_id, label in labels.items() if label is not None}

    def _line(self, box_id: str, label: LabelledBox) -> LabelledLine:
        edited = box_id in self._edited()
        color = SELECTED_COLOR if box_id == self.selected else EDITED_COLOR if edited else LOG_COLOR
        words = f"#{label.track_id}" if label.track_id is not None else "added"
        if edited and label.track_id is not None:
            words += "  corrected"
        if label.ignore:
            words += "  ignored"
        return box_line(label.box, color, words)

    def _show_handles(self, label: LabelledBox | None) -> None:
        if label is None:
            for handle in self._handles:
                handle.remove()
            self._handles = []
            return
        corners = self._grips_px or _corners(label.box)
        if not self._handles:
            self._handles = [
                self._view.add_handle(
                    f"corner {name}",
                    *corners[number],
                    HANDLE_COLOR,
                    partial(self._drag, number),
                    lambda: None,
                )
                for number, name in enumerate(CORNERS)
            ]
        for handle, corner in zip(self._handles, corners, strict=True):
            if handle.position_px != corner:
                handle.move(*corner)

    def _drag(self, corner: int, phase: Phase, column_px: float, row_px: float) -> None:
        """A corner is dragged; the opposite one stays."""
        if self.selected is None or self.selected not in self._labels:
            return
        if phase == "start":
            self._dragged = self.selected, self._labels[self.selected]
            return
        if self._dragged is None:
            return
        box_id, label = self._dragged
        fixed_px = _corners(self._grabbed(box_id).box)[(corner + 2) % 4]
        columns, rows = sorted((fixed_px[0], column_px)), sorted((fixed_px[1], row_px))
        # Dragged over the opposite corner, the box turns over and the corners stay in the hand.
        self._grips_px = tuple(
            (
                column_px if at_right == RIGHT[corner] else fixed_px[0],
                row_px if low == LOW[corner] else fixed_px[1],
            )
            for at_right, low in zip(RIGHT, LOW, strict=True)
        )
        dragged = replace(label, box=self._inside(columns[0], rows[0], columns[1], rows[1]))
        self._dragged = box_id, dragged
        if phase == "end":
            self._dragged = self._grips_px = None
            if dragged.box.w < SMALLEST_PX or dragged.box.h < SMALLEST_PX:
                self.redraw()
                raise UserError(f"a box has to be at least {SMALLEST_PX:g} pixels wide and high")
            self._say(box_id, dragged)
        else:
            self.redraw()

    def _grabbed(self, box_id: str) -> LabelledBox:
        """The box as it was before it was dragged."""
        return self._present_labels().get(box_id, self._labels[box_id])

    def _inside(self, left_px: float, top_px: float, right_px: float, bottom_px: float) -> Box:
        """A box cut at the picture's edges."""
        size = self._view.plane.size
        left_px, right_px = (min(max(x, -0.5), size.width - 0.5) for x in (left_px, right_px))
        top_px, bottom_px = (min(max(y, -0.5), size.height - 0.5) for y in (top_px, bottom_px))
        return Box(left_px, top_px, max(right_px - left_px, 1e-3), max(bottom_px - top_px, 1e-3))

    def _say(self, box_id: str, label: LabelledBox | None) -> None:
        self._annotating.say(BoxEdit(self._frame_index, box_id, label))
        self.redraw()
        self._show_panels()

    def _told(self) -> str:
        if not self.active or self.selected is None:
            raise UserError("select a box first: press E, then click the box")
        return self.selected


def _corners(box: Box) -> tuple[tuple[float, float], ...]:
    """Column and row of the corners, in the order of `CORNERS`."""
    return (box.x, box.y), (box.right, box.y), (box.right, box.bottom), (box.x, box.bottom)
