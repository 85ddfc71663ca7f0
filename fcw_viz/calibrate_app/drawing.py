"""What is drawn over the picture, said once for the page's surface and for the report.

Everything is in pixels of the picture; what keeps its size on the screen (marks, dashes, words) is scaled
by the window's pixels per screen pixel.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

from fcw.camera.calibration import Calibration
from fcw.camera.uncertainty import NextClick
from fcw.logs.overlay import OWN_CAR_SIZE_M, ROW_COLOR, Rgb
from fcw.sources.frame import ImageSize
from fcw_viz.calibrate_app.document import Document, Line, Mark
from fcw_viz.calibrate_app.label_layout import (
    LABEL_HEIGHT_CSS_PX,
    Area,
    Label,
    LabelWish,
    Point,
    Window,
    lay_out_labels,
    text_width_css_px,
)
from fcw_viz.calibrate_app.numbers_text import (
    about_text,
    gain_text,
    interval_text,
    row_distance_text,
    typed_text,
)
from fcw_viz.calibrate_app.state import DistanceRow, Result, SessionState

MARK_COLOR: Rgb = (255, 215, 40)
SELECTED_COLOR: Rgb = (255, 255, 255)
FAINT_COLOR: Rgb = (150, 135, 75)
HORIZON_COLOR: Rgb = (245, 130, 200)
"""Also of the lane lines, which say where the horizon is."""
NEXT_CLICK_COLOR: Rgb = (255, 255, 255)
MEASURE_COLOR: Rgb = (255, 150, 40)
STALE_COLOR: Rgb = (150, 150, 150)
"""Everything of a result that is not current."""

MARK_RADIUS_CSS_PX = 8.0
FAINT_RADIUS_CSS_PX = 5.0
TARGET_RADIUS_CSS_PX = 11.0
CROSS_GAP_CSS_PX = 2.5
"""The pixel that is marked stays free."""
CIRCLE_CORNERS = 20
DASH_CSS_PX = 7.0
LABEL_GAP_CSS_PX = 5.0
MINIMUM_ROW_GAP_CSS_PX = 3.0
"""Rows closer together are one line to the eye; the nearer one is drawn."""
LANE_COUNT = 4
"""Bands that overlap stand side by side in so many lanes, and so do crowded labels."""
LANE_FILLED = 0.9
"""Part of its lane that a band takes, so that neighbours are told apart."""
GRIP_CSS_PX = (26.0, 5.0)
"""Half width and half height of the horizon's grip."""
NEXT_ROW_PART = 0.35
"""Part of the seen width that the suggested row takes."""


class FillKind(Enum):
    """What an area is; each kind has its colour and opacity."""

    ROW_BAND = "row_band"
    HORIZON_BAND = "horizon_band"
    CORRIDOR = "corridor"


FILLS: dict[FillKind, tuple[Rgb, float]] = {
    FillKind.ROW_BAND: (ROW_COLOR, 0.38),
    FillKind.HORIZON_BAND: (HORIZON_COLOR, 0.3),
    FillKind.CORRIDOR: (ROW_COLOR, 0.14),
}


@dataclass(frozen=True, slots=True)
class Fill:
    """A translucent area with four corners, in turn."""

    kind: FillKind
    corners_px: tuple[Point, Point, Point, Point]


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points; strong ones are thicker."""

    points_px: tuple[Point, ...]
    color: Rgb
    strong: bool = False


@dataclass(frozen=True, slots=True)
class Measured:
    """The point of the measuring tool, with the words beside it."""

    column_px: float
    row_px: float
    text: str


@dataclass(frozen=True, slots=True)
class Drawing:
    """Everything over the picture; labels are black on white by themselves.

    Attributes:
        current: False where the result drawn belongs to an earlier document.
        fills: the lowest.
        strokes: above them.
        labels: on top.
    """

    current: bool
    fills: tuple[Fill, ...]
    strokes: tuple[Stroke, ...]
    labels: tuple[Label, ...]


def fill_style(kind: FillKind, current: bool) -> tuple[Rgb, float]:
    """Colour and opacity of an area."""
    color, opacity = FILLS[kind]
    return (color if current else STALE_COLOR), opacity


def draw(
    state: SessionState,
    selected: int | None,
    frame: int | None,
    window: Window,
    horizon_grip: bool = False,
    measured: Measured | None = None,
) -> Drawing:
    """The drawing of one moment.

    Args:
        state: of the session.
        selected: id of the selected mark.
        frame: index of the picture shown; None draws the marks of all pictures alike.
        window: what is seen of it.
        horizon_grip: whether the horizon can be dragged.
        measured: the measuring tool's point.
    """
    pen = _Pen(state.document.image_size, window, state.document.imperial)
    result, document = state.shown, state.document
    seen = _seen(window, document.image_size)
    pen.seen = seen
    pen.measured(measured)
    # Marks before the result: words that somebody typed are more important than those computed.
    pen.marks(document, result if state.current else None, selected, frame)
    pen.lane_lines(document)
    if result is not None:
        pen.result(result, state.current, document, horizon_grip)
    elif horizon_grip or document.horizon is not None:
        pen.believed_horizon(document, horizon_grip)
    wishes = pen.wishes
    if result is not None and not state.current:
        words = "Not current: grey is the last good result"
        corner = (seen.left_px + pen.css(8), seen.bottom_px - pen.css(16))
        wishes = [LabelWish(words, (corner,)), *wishes]
    labels = lay_out_labels(wishes, seen, pen.obstacles)
    return Drawing(state.current, tuple(pen.fills), tuple(pen.strokes), labels)


def visible_rows(
    rows: Sequence[DistanceRow], size: ImageSize, pixels_per_screen_pixel: float
) -> tuple[DistanceRow, ...]:
    """The rows inside the picture, without those that would run into the one before, nearest first."""
    kept: list[DistanceRow] = []
    for row in rows:
        inside = -0.5 <= row.row_px <= size.height - 0.5
        gap_px = MINIMUM_ROW_GAP_CSS_PX * pixels_per_screen_pixel
        if inside and (not kept or kept[-1].row_px - row.row_px >= gap_px):
            kept.append(row)
    return tuple(kept)


def dashes(start_px: Point, end_px: Point, dash_px: float) -> Iterator[tuple[Point, Point]]:
    """The dashes of a line, with gaps as long as they are."""
    length_px = math.dist(start_px, end_px)
    count = max(1, round((length_px / dash_px + 1) / 2))
    step = 1 / (2 * count - 1)
    for index in range(count):
        yield _between(start_px, end_px, 2 * index * step), _between(start_px, end_px, (2 * index + 1) * step)


class _Pen:
    """Collects what is drawn; lengths that keep their size on the screen go through `css`."""

    def __init__(self, size: ImageSize, window: Window, imperial: bool) -> None:
        self._size = size
        self._scale = window.pixels_per_screen_pixel
        self._imperial = imperial
        self.seen = window
        self.fills: list[Fill] = []
        self.strokes: list[Stroke] = []
        self.wishes: list[LabelWish] = []
        self.obstacles: list[Area] = []

    def css(self, length_css_px: float) -> float:
        """A length on the screen in pixels of the picture."""
        return length_css_px * self._scale

    def marks(
        self, document: Document, result: Result | None, selected: int | None, frame: int | None
    ) -> None:
        """All marks: here or of another picture, switched on or off, with their residuals."""

        def elsewhere(mark: Mark) -> bool:
            return frame is not None and mark.frame is not None and mark.frame != frame

        for mark in sorted(document.marks, key=lambda mark: (mark.id != selected, elsewhere(mark))):
            center = (mark.column_px, mark.row_px)
            color = SELECTED_COLOR if mark.id == selected else MARK_COLOR
            if elsewhere(mark) and mark.id != selected:
                self._ring(center, FAINT_RADIUS_CSS_PX, FAINT_COLOR)
                self._label_beside(self._mark_text(mark), center, FAINT_RADIUS_CSS_PX)
                continue
            strong = mark.id == selected
            self._ring(center, MARK_RADIUS_CSS_PX, color, strong)
            if mark.enabled:
                self._cross(center, MARK_RADIUS_CSS_PX, color, strong)
            residual = None if result is None else result.residuals.get(mark.id)
            if residual is not None and result is not None and not result.exact:
                there = (mark.column_px, mark.row_px - residual.row_px)
                half_px = self.css(MARK_RADIUS_CSS_PX)
                self._stroke(color, center, there, strong=True)
                self._stroke(color, (there[0] - half_px, there[1]), (there[0] + half_px, there[1]))
            self._label_beside(self._mark_text(mark), center, MARK_RADIUS_CSS_PX)

    def result(self, result: Result, current: bool, document: Document, horizon_grip: bool) -> None:
        """Rows, horizon, corridor and the next click."""
        calibration = result.calibration
        self._corridor(calibration, current)
        self._rows(result, current)
        if current and result.next_click is not None:
            self._next_click(result.next_click, calibration)
        self._horizon(result, current, document, horizon_grip)

    def believed_horizon(self, document: Document, grip: bool) -> None:
        """The horizon where somebody dragged it to, or in the middle for somebody to drag."""
        belief = document.horizon
        row_px = (self._size.height - 1) / 2 if belief is None else belief.prior.value
        color = HORIZON_COLOR if belief is None or belief.enabled else STALE_COLOR
        self._dashed(color, (self._left_px, row_px), (self._right_px, row_px))
        if grip:
            self._grip(row_px)
        self._label_at_right("horizon, dragged" if belief else "drag to the horizon", row_px)

    def lane_lines(self, document: Document) -> None:
        """The two lane lines, extended to where they meet."""
        color = HORIZON_COLOR if document.lane_lines_enabled else STALE_COLOR
        drawn = [line for line in document.lane_lines if line is not None]
        crossing = _crossing(drawn[0], drawn[1]) if len(drawn) == 2 else None
        for line in drawn:
            self._stroke(color, line.start_px, line.end_px, strong=True)
            for end_px in (line.start_px, line.end_px):
                self._ring(end_px, FAINT_RADIUS_CSS_PX, color)
            if crossing is not None:
                nearest = min((line.start_px, line.end_px), key=lambda end: math.dist(end, crossing))
                self._dashed(color, nearest, crossing)
        if crossing is not None:
            self._cross(crossing, TARGET_RADIUS_CSS_PX, color)
            self._label_beside("lane lines meet", crossing, TARGET_RADIUS_CSS_PX)

    def measured(self, measured: Measured | None) -> None:
        """The measuring tool's point."""
        if measured is not None:
            center = (measured.column_px, measured.row_px)
            self._cross(center, TARGET_RADIUS_CSS_PX, MEASURE_COLOR, strong=True)
            self._ring(center, TARGET_RADIUS_CSS_PX, MEASURE_COLOR)
            self._label_beside(measured.text, center, TARGET_RADIUS_CSS_PX)

    @property
    def _left_px(self) -> float:
        return -0.5

    @property
    def _right_px(self) -> float:
        return self._size.width - 0.5

    def _rows(self, result: Result, current: bool) -> None:
        rows = visible_rows(result.rows, self._size, self._scale)
        color = ROW_COLOR if current else STALE_COLOR
        lane_px = (self.seen.right_px - self.seen.left_px) / LANE_COUNT
        lanes_px = [self.seen.left_px + lane * lane_px for lane in range(LANE_COUNT)]
        shared = _overlapping(
            [(row.row_px - row.row_sigma_px, row.row_px + row.row_sigma_px) for row in rows]
        )
        for index, row in enumerate(rows):
            self._stroke(color, (self._left_px, row.row_px), (self._right_px, row.row_px))
            left_px, right_px = self._left_px, self._right_px
            own_lane = index % LANE_COUNT
            if shared[index]:
                left_px, right_px = lanes_px[own_lane], lanes_px[own_lane] + LANE_FILLED * lane_px
            top_px, bottom_px = row.row_px - row.row_sigma_px, row.row_px + row.row_sigma_px
            self._band(FillKind.ROW_BAND, left_px, right_px, top_px, bottom_px)
            if shared[index]:
                for edge_px in (top_px, bottom_px):
                    self._stroke(color, (left_px, edge_px), (right_px, edge_px))
            first = own_lane if shared[index] else 0
            order = [(first + lane) % LANE_COUNT for lane in range(LANE_COUNT)]
            places = tuple((lanes_px[lane] + self.css(LABEL_GAP_CSS_PX), row.row_px) for lane in order)
            self.wishes.append(LabelWish(self._row_text(row), places))

    def _horizon(self, result: Result, current: bool, document: Document, grip: bool) -> None:
        row_px, sigma_px = result.calibration.horizon_row_px, result.sigmas.horizon_row_px
        if -0.5 <= row_px <= self._size.height - 0.5:
            color = HORIZON_COLOR if current else STALE_COLOR
            self._stroke(color, (self._left_px, row_px), (self._right_px, row_px))
            self._label_at_right(f"horizon  ±{sigma_px:.1f} px", row_px)
        self._band(FillKind.HORIZON_BAND, self._left_px, self._right_px, row_px - sigma_px, row_px + sigma_px)
        if document.horizon is not None:
            self.believed_horizon(document, grip)
        elif grip:
            self._grip(row_px)

    def _corridor(self, calibration: Calibration, current: bool) -> None:
        """The strip that the vehicle covers, from the bottom of the picture to the horizon."""
        horizon_px, camera = calibration.horizon_row_px, calibration.camera
        bottom_px = self._size.height - 0.5
        if horizon_px >= bottom_px:
            return
        distance_m = calibration.distance_at(bottom_px)
        half_m = OWN_CAR_SIZE_M[1] / 2
        left_px, right_px = (calibration.column_at(side * half_m, distance_m) for side in (1.0, -1.0))
        vanishing = (camera.principal_column_px, horizon_px)
        if not (math.isfinite(left_px) and math.isfinite(right_px)):
            return
        left, right = (left_px, bottom_px), (right_px, bottom_px)
        self.fills.append(Fill(FillKind.CORRIDOR, (vanishing, vanishing, right, left)))
        color = ROW_COLOR if current else STALE_COLOR
        for corner in (left, right):
            self._stroke(color, corner, vanishing)

    def _next_click(self, click: NextClick, calibration: Calibration) -> None:
        column_px = calibration.camera.principal_column_px
        half_px = NEXT_ROW_PART / 2 * self._size.width
        center = (column_px, click.row_px)
        radius_px = self.css(TARGET_RADIUS_CSS_PX)
        for side in (-1, 1):
            self._dashed(
                NEXT_CLICK_COLOR,
                (column_px + side * radius_px, click.row_px),
                (column_px + side * half_px, click.row_px),
            )
        self._ring(center, TARGET_RADIUS_CSS_PX, NEXT_CLICK_COLOR, dashed=True)
        self._ring(center, CROSS_GAP_CSS_PX, NEXT_CLICK_COLOR)
        gain = gain_text(click.error_before, click.error_after)
        words = f"one more point here, {about_text(click.distance_m, self._imperial)}, {gain}"
        self._label_beside(words, center, TARGET_RADIUS_CSS_PX)

    def _band(self, kind: FillKind, left_px: float, right_px: float, top_px: float, bottom_px: float) -> None:
        """A band, as much of it as lies in the picture."""
        top_px, bottom_px = max(top_px, -0.5), min(bottom_px, self._size.height - 0.5)
        if bottom_px > top_px:
            corners = ((left_px, top_px), (right_px, top_px), (right_px, bottom_px), (left_px, bottom_px))
            self.fills.append(Fill(kind, corners))

    def _grip(self, row_px: float) -> None:
        half_width_px, half_height_px = (self.css(length) for length in GRIP_CSS_PX)
        column_px = (self.seen.left_px + self.seen.right_px) / 2
        left, right = column_px - half_width_px, column_px + half_width_px
        top, bottom = row_px - half_height_px, row_px + half_height_px
        box = ((left, top), (right, top), (right, bottom), (left, bottom), (left, top))
        self.strokes.append(Stroke(box, HORIZON_COLOR, strong=True))
        self.obstacles.append(Area(left, top, right, bottom))

    def _ring(
        self, center: Point, radius_css_px: float, color: Rgb, strong: bool = False, dashed: bool = False
    ) -> None:
        radius_px = self.css(radius_css_px)
        corners = tuple(
            (
                center[0] + radius_px * math.cos(2 * math.pi * corner / CIRCLE_CORNERS),
                center[1] + radius_px * math.sin(2 * math.pi * corner / CIRCLE_CORNERS),
            )
            for corner in range(CIRCLE_CORNERS + 1)
        )
        if dashed:
            self.strokes += [Stroke(corners[k : k + 2], color, strong) for k in range(0, CIRCLE_CORNERS, 2)]
        else:
            self.strokes.append(Stroke(corners, color, strong))
        self.obstacles.append(Area.around(center, radius_px))

    def _cross(self, center: Point, radius_css_px: float, color: Rgb, strong: bool = False) -> None:
        gap_px, radius_px = self.css(CROSS_GAP_CSS_PX), self.css(radius_css_px)
        column_px, row_px = center
        for right, down in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            self._stroke(
                color,
                (column_px + right * gap_px, row_px + down * gap_px),
                (column_px + right * radius_px, row_px + down * radius_px),
                strong=strong,
            )

    def _stroke(self, color: Rgb, *points: Point, strong: bool = False) -> None:
        self.strokes.append(Stroke(points, color, strong))

    def _dashed(self, color: Rgb, start_px: Point, end_px: Point) -> None:
        dash_px = self.css(DASH_CSS_PX)
        self.strokes += [Stroke(dash, color) for dash in dashes(start_px, end_px, dash_px)]

    def _label_beside(self, text: str, center: Point, radius_css_px: float) -> None:
        """Words to the right, to the left, above, below or at a corner."""
        width_px = self.css(text_width_css_px(text))
        gap_px = self.css(radius_css_px + LABEL_GAP_CSS_PX)
        above_px = gap_px + self.css(LABEL_HEIGHT_CSS_PX / 2)
        column_px, row_px = center
        places = (
            (column_px + gap_px, row_px),
            (column_px - gap_px - width_px, row_px),
            (column_px - width_px / 2, row_px - above_px),
            (column_px - width_px / 2, row_px + above_px),
            (column_px + gap_px, row_px - above_px),
            (column_px + gap_px, row_px + above_px),
            (column_px - gap_px - width_px, row_px - above_px),
            (column_px - gap_px - width_px, row_px + above_px),
        )
        self.wishes.append(LabelWish(text, places))

    def _label_at_right(self, text: str, row_px: float) -> None:
        left_px = self.seen.right_px - self.css(text_width_css_px(text) + LABEL_GAP_CSS_PX)
        rise_px = self.css(LABEL_HEIGHT_CSS_PX)
        places = tuple((left_px, row_px + shift) for shift in (0.0, -rise_px, rise_px))
        self.wishes.append(LabelWish(text, places))

    def _mark_text(self, mark: Mark) -> str:
        if mark.distance_m is None:
            return f"{mark.name}  distance?"
        return f"{mark.name}  {typed_text(mark.distance_m, self._imperial)}"

    def _row_text(self, row: DistanceRow) -> str:
        interval = interval_text(row.low_m, row.high_m, self._imperial)
        return f"{row_distance_text(row.distance_m, self._imperial)}  {interval}"


def _seen(window: Window, size: ImageSize) -> Window:
    """The part of the picture in the window."""
    return Window(
        max(window.left_px, -0.5),
        max(window.top_px, -0.5),
        min(window.right_px, size.width - 0.5),
        min(window.bottom_px, size.height - 0.5),
        window.pixels_per_screen_pixel,
    )


def _overlapping(bands_px: Sequence[tuple[float, float]]) -> list[bool]:
    """For each (top, bottom), whether it shares rows with another."""
    return [
        any(top < other[1] and other[0] < bottom for j, other in enumerate(bands_px) if j != i)
        for i, (top, bottom) in enumerate(bands_px)
    ]


def _crossing(first: Line, second: Line) -> Point | None:
    """Where two lines meet when extended; None where they are parallel."""
    (x1, y1), (x2, y2) = first.start_px, first.end_px
    (x3, y3), (x4, y4) = second.start_px, second.end_px
    determinant = (x1 - x2) * (y3 - y4) - (y1 - y2) * (x3 - x4)
    if determinant == 0:
        return None
    a, b = x1 * y2 - y1 * x2, x3 * y4 - y3 * x4
    return (a * (x3 - x4) - (x1 - x2) * b) / determinant, (a * (y3 - y4) - (y1 - y2) * b) / determinant


def _between(start_px: Point, end_px: Point, part: float) -> Point:
    return (
        start_px[0] + (end_px[0] - start_px[0]) * part,
        start_px[1] + (end_px[1] - start_px[1]) * part,
    )
