"""What can be dragged on the picture: points, the horizon and the ends of the lane lines."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fcw.camera.calibration import Gaussian
from fcw.logs.overlay import Rgb
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import Edit, MoveMark, SetHorizon, SetLaneLine
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.drawing import FAINT_COLOR, HORIZON_COLOR, MARK_COLOR, SELECTED_COLOR
from fcw_viz.page.picture.handle import Handle, Phase

if TYPE_CHECKING:
    from fcw_viz.calibrate_app.tab import Tab

HORIZON = "horizon"
HORIZON_SIGMA_PX = 2.0
"""How well a horizon is dragged by eye."""


def mark_handle(mark_id: int) -> str:
    """The name of a mark's handle in the view."""
    return f"mark_{mark_id}"


@dataclass(frozen=True, slots=True)
class _Wish:
    """A handle that there should be: where, its colour, what a drag and a click do, whether it counts."""

    column_px: float
    row_px: float
    color: Rgb
    edit: Callable[[float, float], Edit]
    click: Callable[[], None]
    enabled: bool = True


class PictureHandles:
    """The handles of one tab, made, moved and removed as the document has it."""

    def __init__(self, tab: "Tab") -> None:
        self._tab = tab
        self._handles: dict[str, Handle] = {}
        self._wishes: dict[str, _Wish] = {}
        self._dragged = ""

    def show(self, state: SessionState) -> None:
        """Bring the handles to a moment of the session."""
        self._wishes = dict(self._wished(state))
        for name in set(self._handles) - set(self._wishes):
            self._handles.pop(name).remove()
        for name, wish in self._wishes.items():
            if name not in self._handles:
                self._handles[name] = self._new_handle(name, wish)
            elif name != self._dragged:
                self._handles[name].move(wish.column_px, wish.row_px)
            self._handles[name].set_colour(wish.color)
            self._handles[name].set_hollow(not wish.enabled)

    def _new_handle(self, name: str, wish: _Wish) -> Handle:
        def drag(phase: Phase, column_px: float, row_px: float) -> None:
            self._drag(name, phase, column_px, row_px)

        def click() -> None:
            if name in self._wishes:
                self._wishes[name].click()

        return self._tab.view.add_handle(name, wish.column_px, wish.row_px, wish.color, drag, click)

    def _drag(self, name: str, phase: Phase, column_px: float, row_px: float) -> None:
        wish = self._wishes.get(name)
        if wish is None:  # deleted in another tab, meanwhile
            return
        if phase == "start":
            self._dragged = name
            wish.click()
        elif phase == "update":
            self._tab.preview(wish.edit(column_px, row_px))
        else:
            self._dragged = ""
            self._tab.apply(wish.edit(column_px, row_px))

    def _wished(self, state: SessionState) -> "list[tuple[str, _Wish]]":
        document = state.document
        wishes = [(mark_handle(mark.id), self._mark_wish(document, mark.id)) for mark in document.marks]
        if self._tab.horizon_grip:
            wishes.append((HORIZON, self._horizon_wish(state)))
        if self._tab.lane_line_grips:
            for index, line in enumerate(document.lane_lines):
                if line is not None:
                    wishes += [
                        (f"lane_line_{index}_{end}", self._line_wish(index, line, end)) for end in (0, 1)
                    ]
        return wishes

    def _mark_wish(self, document: Document, mark_id: int) -> _Wish:
        mark, tab = document.mark(mark_id), self._tab
        elsewhere = mark.frame is not None and mark.frame != tab.frame_index
        color = SELECTED_COLOR if tab.selected == mark_id else FAINT_COLOR if elsewhere else MARK_COLOR
        return _Wish(
            mark.column_px,
            mark.row_px,
            color,
            lambda column_px, row_px: MoveMark(mark_id, column_px, row_px),
            lambda: tab.select(mark_id),
            mark.enabled,
        )

    def _horizon_wish(self, state: SessionState) -> _Wish:
        left_px, _, right_px, _ = self._tab.view.window_px
        belief = state.document.horizon

        def edit(_: float, row_px: float) -> Edit:
            sigma_px = HORIZON_SIGMA_PX if belief is None else belief.prior.sigma
            return SetHorizon(Belief(Gaussian(row_px, sigma_px)))

        column_px = (left_px + right_px) / 2
        return _Wish(column_px, self._tab.horizon_row_px, HORIZON_COLOR, edit, lambda: None)

    def _line_wish(self, index: int, line: Line, end: int) -> _Wish:
        column_px, row_px = line.end_px if end else line.start_px

        def edit(column_px: float, row_px: float) -> Edit:
            moved = (column_px, row_px)
            return SetLaneLine(index, replace(line, end_px=moved) if end else replace(line, start_px=moved))

        return _Wish(column_px, row_px, HORIZON_COLOR, edit, lambda: None)
