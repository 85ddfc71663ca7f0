"""What can be dragged on the picture: points, the horizon, the camera's turn, the ends of the lane lines."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.joint.plates import PLACES
from fcw.camera.prior_sigmas import HORIZON_ROW_SIGMA_PX
from fcw.logs.overlay import ROW_COLOR, Rgb
from fcw_viz.calibrate_app.desk import Desk, mark_handle
from fcw_viz.calibrate_app.document.besides.knowledge import (
    SEEN_ROLL_SIGMA_RAD,
    SEEN_YAW_SIGMA_RAD,
    SetRoll,
    SetYaw,
)
from fcw_viz.calibrate_app.document.besides.plates import MovePlatePlace
from fcw_viz.calibrate_app.document.besides.rectangles import MoveCorner
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import Edit, MoveMark, SetHorizon, SetLaneLine
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.drawing import FAINT_COLOR, HORIZON_COLOR, MARK_COLOR, SELECTED_COLOR
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.picture.handle import Handle, Phase

HORIZON, ROLL, YAW = "horizon", "roll", "yaw"
ROLL_GRIP_PART = 0.8
"""Of the window's width: where the horizon is tilted by its end."""
YAW_GRIP_PART = 0.5
"""Of the way from the horizon down to the window's edge: where the path is turned by its middle."""


@dataclass(frozen=True, slots=True)
class _Wish:
    """A handle that there should be: where, its colour, what a drag and a click do, whether it counts, and
    whether a click on it is one on the picture."""

    column_px: float
    row_px: float
    color: Rgb
    edit: Callable[[float, float], Edit]
    click: Callable[[], None]
    enabled: bool = True
    lets_click_through: bool = False


class PictureHandles:
    """The handles of one tab, made, moved and removed as the document has it."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._handles: dict[str, Handle] = {}
        self._wishes: dict[str, _Wish] = {}
        self._dragged = ""

    def horizon_grip(self, document: Document) -> bool:
        """Whether the horizon can be dragged."""
        return self._desk.tool is Tool.HORIZON or document.horizon is not None

    def show(self, state: SessionState) -> None:
        """Bring the handles to a moment of the session."""
        self._wishes = dict(self._wished(state))
        gone = set(self._handles) - set(self._wishes)
        for name in gone:
            self._handles.pop(name).remove()
        for name, wish in self._wishes.items():
            if name not in self._handles:
                self._handles[name] = self._new_handle(name, wish)
            elif name != self._dragged:
                self._handles[name].move(wish.column_px, wish.row_px)
            self._handles[name].set_colour(wish.color)
            self._handles[name].set_hollow(not wish.enabled)
            self._handles[name].lets_click_through = wish.lets_click_through
        if self._dragged in gone:  # deleted in another tab: nothing else ends this drag
            self._dragged = ""
            self._desk.preview(None)

    def _new_handle(self, name: str, wish: _Wish) -> Handle:
        def drag(phase: Phase, column_px: float, row_px: float) -> None:
            self._drag(name, phase, column_px, row_px)

        def click() -> None:
            if name in self._wishes:
                self._wishes[name].click()

        return self._desk.view.add_handle(name, wish.column_px, wish.row_px, wish.color, drag, click)

    def _drag(self, name: str, phase: Phase, column_px: float, row_px: float) -> None:
        wish = self._wishes.get(name)
        if wish is None:  # deleted in another tab, meanwhile
            return
        if phase == "start":
            self._dragged = name
            wish.click()
        elif phase == "update":
            self._desk.preview(wish.edit(column_px, row_px))
        else:
            self._dragged = ""
            self._desk.apply(wish.edit(column_px, row_px))

    def _wished(self, state: SessionState) -> list[tuple[str, _Wish]]:
        document = state.document
        wishes = [(mark_handle(mark.id), self._mark_wish(document, mark.id)) for mark in document.marks]
        if self.horizon_grip(document):
            wishes.append((HORIZON, self._horizon_wish(state)))
        if self._desk.tool is Tool.HORIZON and state.shown is not None:
            wishes += self._turn_wishes(state.shown.calibration)
        for index, rectangle in enumerate(document.rectangles):
            wishes += [
                (f"rectangle_{index}_{corner}", self._corner_wish(index, corner, place))
                for corner, place in enumerate(rectangle.corners_px)
            ]
        for index, places in enumerate(document.plates):
            begun = len(places) < PLACES  # its next place may lie under the handle of the last one
            wishes += [
                (f"plate_{index}_{k}", self._plate_wish(index, k, at, begun)) for k, at in enumerate(places)
            ]
        if self._desk.tool in (Tool.LANE_LINES, Tool.POINTS):
            for index, line in enumerate(document.lane_lines):
                if line is not None:
                    wishes += [
                        (f"lane_line_{index}_{end}", self._line_wish(index, line, end)) for end in (0, 1)
                    ]
        return wishes

    def _mark_wish(self, document: Document, mark_id: int) -> _Wish:
        mark, desk = document.mark(mark_id), self._desk
        elsewhere = mark.frame is not None and mark.frame != desk.frame_index
        color = SELECTED_COLOR if desk.selected == mark_id else FAINT_COLOR if elsewhere else MARK_COLOR
        return _Wish(
            mark.column_px,
            mark.row_px,
            color,
            lambda column_px, row_px: MoveMark(mark_id, column_px, row_px),
            lambda: desk.click_mark(mark_id),
            mark.enabled,
        )

    def _corner_wish(self, rectangle: int, corner: int, place: tuple[float, float]) -> _Wish:
        def edit(column_px: float, row_px: float) -> Edit:
            return MoveCorner(rectangle, corner, column_px, row_px)

        return _Wish(*place, MARK_COLOR, edit, lambda: None)

    def _plate_wish(self, plate: int, place: int, at: tuple[float, float], begun: bool) -> _Wish:
        def edit(column_px: float, row_px: float) -> Edit:
            return MovePlatePlace(plate, place, column_px, row_px)

        return _Wish(*at, MARK_COLOR, edit, lambda: None, lets_click_through=begun)

    def _horizon_wish(self, state: SessionState) -> _Wish:
        left_px, _, right_px, _ = self._desk.view.window_px

        def edit(_: float, row_px: float) -> Edit:
            return SetHorizon(Belief(Gaussian(row_px, HORIZON_ROW_SIGMA_PX)))

        column_px = (left_px + right_px) / 2
        return _Wish(column_px, self._horizon_row_px(state), HORIZON_COLOR, edit, lambda: None)

    def _horizon_row_px(self, state: SessionState) -> float:
        """Where the horizon is taken hold of: where it was dragged to, or else where it comes out."""
        if state.document.horizon is not None:
            return state.document.horizon.prior.value
        if state.shown is not None:
            return state.shown.calibration.horizon_row_px
        return (state.document.image_size.height - 1) / 2

    def _turn_wishes(self, calibration: Calibration) -> list[tuple[str, _Wish]]:
        """The horizon's end, which tilts the camera, and the middle of the path, which turns it."""
        size, (left_px, _, right_px, bottom_px) = calibration.image_size, self._desk.view.window_px
        left_px, right_px = max(left_px, 0.0), min(right_px, size.width - 1.0)
        bottom_px = min(bottom_px, size.height - 1.0)
        camera, turned, horizon_px = calibration.camera, calibration.orientation, calibration.horizon_row_px
        aside_px = left_px + ROLL_GRIP_PART * (right_px - left_px)
        on_path_px = horizon_px + YAW_GRIP_PART * (bottom_px - horizon_px)
        ahead_px = camera.principal_column_px
        places = np.array(((ahead_px, horizon_px), (aside_px, horizon_px), (ahead_px, on_path_px)))
        way = calibration.straightening
        middle, end, path = places if way is None else way.to_picture(places)

        def tilt(_: float, row_px: float) -> Edit:
            more_rad = math.atan2(end[1] - row_px, end[0] - middle[0])
            return SetRoll(Belief(Gaussian(turned.roll_rad + more_rad, SEEN_ROLL_SIGMA_RAD)))

        def turn(column_px: float, _: float) -> Edit:
            more_rad = math.atan((column_px - path[0]) / camera.focal_y_px)
            return SetYaw(Belief(Gaussian(turned.yaw_rad + more_rad, SEEN_YAW_SIGMA_RAD)))

        return [
            (ROLL, _Wish(float(end[0]), float(end[1]), HORIZON_COLOR, tilt, lambda: None)),
            (YAW, _Wish(float(path[0]), float(path[1]), ROW_COLOR, turn, lambda: None)),
        ]

    def _line_wish(self, index: int, line: Line, end: int) -> _Wish:
        column_px, row_px = line.end_px if end else line.start_px

        def edit(column_px: float, row_px: float) -> Edit:
            moved = (column_px, row_px)
            return SetLaneLine(index, replace(line, end_px=moved) if end else replace(line, start_px=moved))

        return _Wish(column_px, row_px, HORIZON_COLOR, edit, lambda: None)
