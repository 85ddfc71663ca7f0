"""Correcting the boxes of a frame on the picture: moved, resized, drawn, deleted, confirmed."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial

from fcw.annotation.box_motion import moved, reshaped
from fcw.annotation.records import BoxEdit, FrameConfirmed, LabelledBox, new_box_id, track_box_id
from fcw.box import Box
from fcw.errors import UserError
from fcw.logs.overlay import OTHER_TRACK_COLOR, Rgb
from fcw.logs.records import FrameResult
from fcw_viz.page.picture.handle import Handle, Phase
from fcw_viz.page.picture.label_layout import Area, Point
from fcw_viz.page.picture.lines import LabelledLine, LineOverlay, box_line
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.picture.box_limits import SMALLEST_PX, cut, inside, is_slip
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.words import box_words

LOG_COLOR: Rgb = OTHER_TRACK_COLOR
EDITED_COLOR: Rgb = (70, 200, 110)
SELECTED_COLOR: Rgb = (255, 255, 255)
HANDLE_COLOR: Rgb = (255, 215, 40)
REAR_COLOR: Rgb = (120, 200, 255)
GRIPS = {
    "corner top left": (-1, -1),
    "corner top right": (1, -1),
    "corner bottom right": (1, 1),
    "corner bottom left": (-1, 1),
    "edge top": (0, -1),
    "edge right": (1, 0),
    "edge bottom": (0, 1),
    "edge left": (-1, 0),
}
"""What can be dragged of a box, and which of its sides go along: left -1, right 1; top -1, bottom 1."""
EDGE_CSS_PX = 64.0
"""The middle of an edge has its own mark where the edge is at least so long on the screen."""

Sides = tuple[float, float, float, float]
"""Left, top, right and bottom; dragged over each other, they may have changed places."""


class BoxEditor:
    """The boxes of the frame that is shown, while they are corrected; in the tab's thread.

    The log's boxes are those of its tracks. An edit of somebody else stands in the place of the log's box,
    as one's own does: the last one counts.

    Attributes:
        active: whether boxes are corrected now.
        selected: id of the box that is worked on; None for none.
        draws: whether the next drag draws a box, also without Shift.
        draws_rear: whether the next box that is drawn is the rear face of the selected one.
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
        self._covered: Callable[[], Iterable[Area]] = tuple
        self._lines = LineOverlay(tab.view, tab.client, "boxes", lambda: self._covered())
        self._handles: dict[str, Handle] = {}
        self._area = tab.view.add_area("box", self._move)
        self._hovered: str | None = None
        self._is_drawn = False
        self._dragged: tuple[str, LabelledBox] | None = None
        self._sides: Sides | None = None
        self._taken_px: Point = (0.0, 0.0)
        self.draws = self.draws_rear = False
        self._labels: dict[str, LabelledBox] = {}
        self._last: tuple[str, LabelledBox] | None = None
        self.active = False
        self.selected: str | None = None

    # What a person does

    def start(self) -> None:
        """Take the tool; the frame is shown to it next."""
        self.active = True
        self._view.on_box(self.draw)

    def stop(self) -> None:
        """Put the tool away."""
        self.active = self.draws = self.draws_rear = False
        self.selected = None
        self._dragged = self._sides = self._hovered = None
        self._view.on_box(None)
        self.redraw()

    def click(self, column_px: float, row_px: float) -> None:
        """Select the box that was clicked, the smallest where they overlap."""
        if not self.active:
            return
        self._select(self._box_at(column_px, row_px))

    def hover(self, mouse_px: Point | None) -> None:
        """The box under the mouse can be taken hold of; it is moved and the picture stays."""
        if self.active and self._dragged is None:
            self._hovered = None if mouse_px is None else self._box_at(*mouse_px)
            self._show_area()

    def select_next(self) -> None:
        """Select the next box of the frame, from left to right."""
        self._check_active()
        order = sorted(self._labels, key=lambda box_id: self._labels[box_id].box.x)
        if order:
            place = order.index(self.selected) + 1 if self.selected in order else 0
            self._select(order[place % len(order)])

    def switch_drawing(self, rear: bool = False) -> None:
        """Have the next drag draw a box, or the selected one's rear face, and nothing else; or no longer."""
        self._check_active()
        self.draws = not self.draws or self.draws_rear != rear
        self.draws_rear = self.draws and rear
        self.redraw()
        self._show_panels()

    def draw(self, left_px: float, top_px: float, right_px: float, bottom_px: float) -> None:
        """Take a box that was drawn: the selected one's where the frame has none of it, else another one."""
        box = self._inside(left_px, top_px, right_px, bottom_px)
        if is_slip(box):
            raise UserError(f"this box is smaller than {SMALLEST_PX:g} pixels; draw it larger, or zoom in")
        self.draws = False
        if self.draws_rear:
            box_id, label = self.told()
            self.draws_rear = False
            self.say(BoxEdit(self._frame_index, box_id, replace(label, rear_box=box)))
            return
        if self._is_missing:
            self.change(reshaped(self.told()[1], box))
            return
        box_id = new_box_id()
        self.selected = box_id
        self.say(BoxEdit(self._frame_index, box_id, LabelledBox(box)))

    def delete(self) -> None:
        """Say that there should be no box where the selected one is."""
        box_id, _ = self.told()
        self.selected = None
        self.say(BoxEdit(self._frame_index, box_id, None))

    def switch_ignored(self) -> None:
        """Say that the selected box is neither to be found nor to be taken for background, or that it is."""
        _, label = self.told()
        self.change(replace(label, ignore=not label.ignore))

    def change(self, label: LabelledBox) -> None:
        """Say that the selected box is another one."""
        box_id, _ = self.told()
        self.say(BoxEdit(self._frame_index, box_id, label))

    def say(self, *edits: BoxEdit) -> None:
        """Keep edits, of any frames, as one step; the boxes are cut at the picture's edges."""
        self._annotating.say(*(cut(self._view.plane.size, edit) for edit in edits))
        self.redraw()
        self._show_panels()

    def confirm(self) -> None:
        """Say that all boxes of the frame are right as they stand."""
        self._check_active()
        self._annotating.say(FrameConfirmed(self._frame_index))

    # What is shown

    def show(self, result: FrameResult, covered: Callable[[], Iterable[Area]]) -> None:
        """Show the boxes of another frame: what the log says of it, and what its picture's words cover."""
        self._result, self._hovered, self._covered = result, None, covered
        self.redraw()

    def review_changed(self) -> None:
        """Somebody has said something: show it, unless a box is being dragged."""
        if self._dragged is None:
            self.redraw()

    def redraw(self) -> None:
        """Show the boxes of the frame, the selected one with its corners."""
        self._view.draw_boxes(self.draws)
        if not self.active or self._place.drive is None:
            self._labels = {}
            self._show_handles(None)
            self._show_area()
            self._draw(() if self._view.away or self._place.drive is None else self._edited_lines())
            return
        self._labels = self._present_labels()
        if self._dragged is not None:
            self._labels[self._dragged[0]] = self._dragged[1]
        self._keep_selected()
        # At once: a handle that has no place yet could be taken hold of anywhere.
        with self._client.atomic():
            lines = [self._lines_of(box_id, label) for box_id, label in self._labels.items()]
            self._draw([line for of_one in lines for line in of_one])
            self._show_handles(self._labels[self.selected] if self.selected and not self.draws else None)
            self._show_area()

    def _keep_selected(self) -> None:
        """Have the selected box stand where it was seen last, also in a frame that has none of it."""
        if self.selected in self._labels:
            if self._dragged is None:
                self._last = self.selected, self._labels[self.selected]
        elif self._last is not None and self._last[0] == self.selected and self._is_missing:
            self._labels[self._last[0]] = self._last[1]
        else:
            self.selected = None

    @property
    def _is_missing(self) -> bool:
        """Whether the frame has none of the selected box, and nobody said that there is none."""
        return self.selected is not None and self.selected not in (self._present_labels() | self._edited())

    def told(self) -> tuple[str, LabelledBox]:
        """The selected box and its id.

        Raises:
            UserError: none is selected.
        """
        if not self.active or self.selected is None:
            raise UserError("select a box first: press E, then click the box")
        return self.selected, self._labels[self.selected]

    @property
    def confirmed_by(self) -> tuple[str, ...]:
        """Who said that the frame's boxes are right."""
        frame = self._place.review.review.frames.get(self._frame_index)
        return tuple(entry.person for entry in frame.confirmed) if frame else ()

    @property
    def box_count(self) -> tuple[int, int]:
        """How many boxes there are, and how many of them are not the log's."""
        return len(self._present_labels()), len(self._edited())

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
        edited, selected = box_id in self._edited(), box_id == self.selected
        color = SELECTED_COLOR if selected else EDITED_COLOR if edited else LOG_COLOR
        words = box_words(label, edited, selected and self._is_missing)
        return box_line(label.box, color, words, handles=selected)

    def _edited_lines(self) -> list[LabelledLine]:
        """What people labelled, which is seen all the same; in a word, for the picture has its own."""
        said = self._edited() if self._result else {}
        return [
            box_line(label.box, EDITED_COLOR, "added" if label.track_id is None else "corrected")
            for label in said.values()
            if label is not None
        ]

    def _draw(self, lines: Sequence[LabelledLine]) -> None:
        if lines or self._is_drawn:
            self._lines.show(lines)
            self._is_drawn = bool(lines)

    def _lines_of(self, box_id: str, label: LabelledBox) -> list[LabelledLine]:
        """A box and its rear face."""
        rear = [] if label.rear_box is None else [box_line(label.rear_box, REAR_COLOR, "")]
        return [self._line(box_id, label), *rear]

    def _show_area(self) -> None:
        shown = self._hovered if self._hovered in self._labels else self.selected
        self._area.show(self._labels[shown].box if shown in self._labels and not self.draws else None)

    def _show_handles(self, label: LabelledBox | None) -> None:
        places = {} if label is None else self._grip_places(self._sides or _sides(label.box))
        for name in self._handles.keys() - places.keys():
            self._handles.pop(name).remove()
        for name, place_px in places.items():
            if name not in self._handles:
                self._handles[name] = self._view.add_handle(
                    name, *place_px, HANDLE_COLOR, partial(self._drag, name), lambda: None
                )
            elif self._handles[name].position_px != place_px:
                self._handles[name].move(*place_px)

    def _grip_places(self, sides: Sides) -> dict[str, Point]:
        """Where the marks of a box stand; those in the middle of short edges are left out."""
        left, top, right, bottom = sides
        room_px = EDGE_CSS_PX * self._view.pixels_per_screen_pixel
        places = {}
        for name, (across, down) in GRIPS.items():
            is_short = (across == 0 and abs(right - left) < room_px) or (
                down == 0 and abs(bottom - top) < room_px
            )
            if is_short and self._sides is None:
                continue
            column_px = (left, (left + right) / 2, right)[across + 1]
            places[name] = column_px, (top, (top + bottom) / 2, bottom)[down + 1]
        return places

    def _drag(self, grip: str, phase: Phase, column_px: float, row_px: float) -> None:
        """A corner or an edge is dragged; the opposite ones stay."""
        if self.selected is None or self.selected not in self._labels:
            return
        if phase == "start":
            self._dragged = self.selected, self._labels[self.selected]
            self._sides = _sides(self._labels[self.selected].box)
            return
        if self._dragged is None or self._sides is None:
            return
        across, down = GRIPS[grip]
        left, top, right, bottom = self._sides
        left, right = (column_px if across == -1 else left), (column_px if across == 1 else right)
        top, bottom = (row_px if down == -1 else top), (row_px if down == 1 else bottom)
        # Dragged over the opposite side, the box turns over and the mark stays in the hand.
        self._sides = left, top, right, bottom
        grabbed = self._grabbed(self._dragged[0])
        columns, rows = sorted((left, right)), sorted((top, bottom))
        box = self._inside(columns[0], rows[0], columns[1], rows[1])
        self._dragged_to(reshaped(grabbed, box), phase)

    def _move(self, phase: Phase, column_px: float, row_px: float) -> None:
        """A box is dragged as a whole."""
        if phase == "start":
            box_id = self._hovered if self._hovered in self._labels else self.selected
            if box_id is None or box_id not in self._labels:
                return
            self._select(box_id)
            self._dragged, self._taken_px = (box_id, self._labels[box_id]), (column_px, row_px)
            return
        if self._dragged is None:
            return
        grabbed = self._grabbed(self._dragged[0])
        self._dragged_to(moved(grabbed, column_px - self._taken_px[0], row_px - self._taken_px[1]), phase)

    def _dragged_to(self, label: LabelledBox, phase: Phase) -> None:
        assert self._dragged is not None
        box_id = self._dragged[0]
        self._dragged = box_id, label
        if phase != "end":
            self.redraw()
            return
        self._dragged = self._sides = None
        self.redraw()
        self.say(BoxEdit(self._frame_index, box_id, label))

    def _grabbed(self, box_id: str) -> LabelledBox:
        """The box as it was before it was dragged."""
        last = {} if self._last is None else dict([self._last])
        return (last | self._present_labels()).get(box_id, self._labels[box_id])

    def _box_at(self, column_px: float, row_px: float) -> str | None:
        """Id of the box there, the smallest where they overlap."""
        hit = [
            (label.box.w * label.box.h, box_id)
            for box_id, label in self._labels.items()
            if label.box.x <= column_px <= label.box.right and label.box.y <= row_px <= label.box.bottom
        ]
        return min(hit)[1] if hit else None

    def _select(self, box_id: str | None) -> None:
        self.draws = self.draws_rear = False
        self.selected = box_id
        self.redraw()
        self._show_panels()

    def _check_active(self) -> None:
        if not self.active:
            raise UserError("press E to correct boxes first")

    def _inside(self, left_px: float, top_px: float, right_px: float, bottom_px: float) -> Box:
        return inside(self._view.plane.size, left_px, top_px, right_px, bottom_px)


def _sides(box: Box) -> Sides:
    return box.x, box.y, box.right, box.bottom
