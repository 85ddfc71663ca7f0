"""What is drawn over the picture, said once for the page's surface and for the report."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from fcw.camera.calibration import Calibration
from fcw.camera.joint.plates import PLACES
from fcw.camera.joint.rectangle import CORNERS
from fcw.camera.uncertainty import NextClick
from fcw.frame import ImageSize
from fcw.logs.overlay import OWN_CAR_SIZE_M, ROW_COLOR, Rgb
from fcw_viz.calibrate_app.document.document import Document, Line, Mark
from fcw_viz.calibrate_app.document.numbers_text import (
    about_text,
    gain_text,
    interval_text,
    row_distance_text,
    typed_text,
)
from fcw_viz.calibrate_app.document.state import DistanceRow, Result, SessionState
from fcw_viz.calibrate_app.drawing.pen import CROSS_GAP_CSS_PX, Fill, FillKind, Pen, Stroke
from fcw_viz.page.picture.label_layout import Label, LabelWish, Point, Window, lay_out_labels

MARK_COLOR: Rgb = (255, 215, 40)
SELECTED_COLOR: Rgb = (255, 255, 255)
FAINT_COLOR: Rgb = (150, 135, 75)
HORIZON_COLOR: Rgb = (245, 130, 200)
"""Also of the lane lines, which say where the horizon is."""
NEXT_CLICK_COLOR: Rgb = (255, 255, 255)
MEASURE_COLOR: Rgb = (255, 150, 40)
STALE_COLOR: Rgb = (150, 150, 150)
"""Everything of a result that is not current."""
STALE_WORDS = "Out of date: grey is the last good result"
FILLS: dict[FillKind, tuple[Rgb, float]] = {
    FillKind.ROW_BAND: (ROW_COLOR, 0.38),
    FillKind.HORIZON_BAND: (HORIZON_COLOR, 0.3),
    FillKind.CORRIDOR: (ROW_COLOR, 0.14),
}

HANDLE_RADIUS_CSS_PX = 14.0
"""Of a `Handle`, with its cross-hair."""
MARK_RADIUS_CSS_PX = 8.0
FAINT_RADIUS_CSS_PX = 5.0
TARGET_RADIUS_CSS_PX = 11.0
MINIMUM_ROW_GAP_CSS_PX = 3.0
"""Rows closer together are one line to the eye; the nearer one is drawn."""
LANE_COUNT = 5
"""Bands that overlap stand side by side in so many lanes; an odd number, as marks stand in the middle."""
LANE_FILLED = 0.9
"""Part of its lane that a band takes, so that neighbours are told apart."""
NEXT_ROW_PART = 0.35
"""Part of the picture's width that the suggested row takes."""


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
    handles: bool = False,
    horizon_grip: bool = False,
    measured: Measured | None = None,
) -> Drawing:
    """The drawing of one moment.

    Args:
        state: of the session.
        selected: id of the selected mark.
        frame: index of the picture shown; None draws the marks of all pictures alike.
        window: what is seen of it.
        handles: whether marks, line ends and horizon have handles, which draw themselves.
        horizon_grip: whether the horizon can be dragged.
        measured: the measuring tool's point.
    """
    result, document = state.shown, state.document
    way = None if result is None else result.calibration.straightening
    pen = Pen(document.image_size, window, way)
    if measured is not None:
        _draw_measured(pen, measured)
    # Marks before the result: words that somebody typed are more important than those computed.
    _draw_marks(pen, state, selected, frame, handles)
    _draw_lane_lines(pen, state, handles)
    _draw_rectangles(pen, document, handles)
    _draw_plates(pen, document, handles)
    for edge in document.edges:
        pen.line(HORIZON_COLOR, *edge)
        for place in edge:
            pen.cross(HORIZON_COLOR, place, FAINT_RADIUS_CSS_PX)
    if result is not None:
        _draw_corridor(pen, result.calibration, state.current)
        _draw_rows(pen, result, state.current, document.imperial)
        if state.current and result.next_click is not None:
            _draw_next_click(pen, result.next_click, result.calibration, document.imperial)
        _draw_horizon(pen, result, state.current)
    if document.horizon is not None or horizon_grip:
        _draw_dragged_horizon(pen, document, result, horizon_grip)
    wishes = pen.wishes
    if result is not None and not state.current:
        wishes = [LabelWish(STALE_WORDS, pen.corners(STALE_WORDS)), *wishes]
    labels = lay_out_labels(wishes, pen.seen, pen.obstacles)
    return Drawing(state.current, tuple(pen.fills), tuple(pen.strokes), labels)


def visible_rows(
    rows: Sequence[DistanceRow], size: ImageSize, pixels_per_screen_pixel: float
) -> tuple[DistanceRow, ...]:
    """The rows inside the picture, without those that would run into the one before, nearest first."""
    kept: list[DistanceRow] = []
    gap_px = MINIMUM_ROW_GAP_CSS_PX * pixels_per_screen_pixel
    for row in rows:
        inside = -0.5 <= row.row_px <= size.height - 0.5
        if inside and (not kept or kept[-1].row_px - row.row_px >= gap_px):
            kept.append(row)
    return tuple(kept)


def _draw_measured(pen: Pen, measured: Measured) -> None:
    center = (measured.column_px, measured.row_px)
    pen.cross(MEASURE_COLOR, center, TARGET_RADIUS_CSS_PX, strong=True)
    pen.ring(MEASURE_COLOR, center, TARGET_RADIUS_CSS_PX)
    pen.words_beside(measured.text, center, TARGET_RADIUS_CSS_PX)


def _draw_marks(
    pen: Pen, state: SessionState, selected: int | None, frame: int | None, handles: bool
) -> None:
    """All marks: of this picture or another, switched on or off, with their residuals."""

    def elsewhere(mark: Mark) -> bool:
        return frame is not None and mark.frame is not None and mark.frame != frame

    result = state.shown if state.current else None
    for mark in sorted(state.document.marks, key=lambda mark: (mark.id != selected, elsewhere(mark))):
        center, strong = (mark.column_px, mark.row_px), mark.id == selected
        faint = elsewhere(mark) and not strong
        radius_css_px = FAINT_RADIUS_CSS_PX if faint else MARK_RADIUS_CSS_PX
        color = SELECTED_COLOR if strong else FAINT_COLOR if faint else MARK_COLOR
        if handles:
            radius_css_px = HANDLE_RADIUS_CSS_PX
            pen.keep_free(center, radius_css_px)
        else:
            pen.ring(color, center, radius_css_px, strong)
            if mark.enabled and not faint:
                pen.cross(color, center, radius_css_px, strong)
        residual = None if result is None or result.exact or faint else result.residuals.get(mark.id)
        if residual is not None:
            column_px, row_px = mark.column_px, mark.row_px - residual.row_px
            half_px = pen.css(radius_css_px)
            pen.line(color, center, (column_px, row_px), strong=True)
            pen.line(color, (column_px - half_px, row_px), (column_px + half_px, row_px))
        pen.words_beside(_mark_text(mark, state.document), center, radius_css_px)


def _draw_lane_lines(pen: Pen, state: SessionState, handles: bool) -> None:
    """The two lane lines, extended to where they meet, if that can be a horizon."""
    document, horizon = state.document, state.solution.lane_horizon
    color = HORIZON_COLOR if document.lane_lines_enabled else STALE_COLOR
    drawn = [line for line in document.lane_lines if line is not None]
    crossing = _crossing(drawn[0], drawn[1]) if len(drawn) == 2 and horizon is not None else None
    for line in drawn:
        pen.line(color, line.start_px, line.end_px, strong=True)
        for end_px in (line.start_px, line.end_px):
            if handles:
                pen.keep_free(end_px, HANDLE_RADIUS_CSS_PX)
            else:
                pen.ring(color, end_px, FAINT_RADIUS_CSS_PX)
        if crossing is not None:
            nearest = min((line.start_px, line.end_px), key=lambda end: math.dist(end, crossing))
            pen.dashed(color, nearest, crossing)
    if crossing is not None and horizon is not None:
        pen.cross(color, crossing, TARGET_RADIUS_CSS_PX)
        pen.words_beside(f"lane lines meet  ±{horizon.sigma:.1f} px", crossing, TARGET_RADIUS_CSS_PX)


def _draw_rectangles(pen: Pen, document: Document, handles: bool) -> None:
    """Their corners by number, as far as they are clicked, and what is known of their sides."""
    for rectangle in document.rectangles:
        places = rectangle.corners_px
        ring = (*places, places[0]) if len(places) == CORNERS else places
        if len(ring) > 1:
            pen.line(MARK_COLOR, *ring, strong=True)
        for number, place in enumerate(places, 1):
            if handles:
                pen.keep_free(place, HANDLE_RADIUS_CSS_PX)
            else:
                pen.ring(MARK_COLOR, place, FAINT_RADIUS_CSS_PX)
            pen.words_beside(str(number), place, HANDLE_RADIUS_CSS_PX if handles else FAINT_RADIUS_CSS_PX)
        for side_m, (start, end) in zip(rectangle.sides_m, pairwise(ring), strict=False):
            if side_m is not None:
                middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
                pen.words_beside(typed_text(side_m.value, document.imperial), middle, FAINT_RADIUS_CSS_PX)


def _draw_plates(pen: Pen, document: Document, handles: bool) -> None:
    """Each plate from end to end, and from there to the tyre on the road."""
    for places in document.plates:
        pen.line(MARK_COLOR, *places[:2], strong=True)
        if len(places) == PLACES:
            pen.dashed(MARK_COLOR, min(places[:2], key=lambda end: math.dist(end, places[2])), places[2])
        for place in places:
            if handles:
                pen.keep_free(place, HANDLE_RADIUS_CSS_PX)
            else:
                pen.ring(MARK_COLOR, place, FAINT_RADIUS_CSS_PX)


def _draw_rows(pen: Pen, result: Result, current: bool, imperial: bool) -> None:
    """Rows with their bands and words; bands that overlap stand side by side."""
    seen = pen.seen
    rows = visible_rows(result.rows, pen.size, seen.pixels_per_screen_pixel)
    bands_px = [(row.row_px - row.row_sigma_px, row.row_px + row.row_sigma_px) for row in rows]
    color = ROW_COLOR if current else STALE_COLOR
    lane_px = (seen.right_px - seen.left_px) / LANE_COUNT
    # From the right: the page's own panels lie over the left.
    lanes_px = [seen.right_px - lane * lane_px for lane in range(LANE_COUNT)]
    for index, (row, (top_px, bottom_px)) in enumerate(zip(rows, bands_px, strict=True)):
        others_px = bands_px[:index] + bands_px[index + 1 :]
        pen.across(color, row.row_px)
        first_lane = 0
        if any(top_px < other_bottom and other_top < bottom_px for other_top, other_bottom in others_px):
            first_lane = index % LANE_COUNT
            left_px, right_px = lanes_px[first_lane] - LANE_FILLED * lane_px, lanes_px[first_lane]
            pen.line(color, *pen.along((left_px, row.row_px), (right_px, row.row_px)), strong=True)
            for edge_px in (top_px, bottom_px):
                if -0.5 <= edge_px <= pen.bottom_px:
                    pen.line(color, *pen.along((left_px, edge_px), (right_px, edge_px)))
        else:
            left_px, right_px = pen.left_px, pen.right_px
        pen.band(FillKind.ROW_BAND, left_px, right_px, top_px, bottom_px)
        interval = interval_text(row.low_m, row.high_m, imperial)
        words = f"{row_distance_text(row.distance_m, imperial)}  {interval}"
        order = [lanes_px[(first_lane + lane) % LANE_COUNT] for lane in range(LANE_COUNT)]
        pen.words_left_of(words, row.row_px, order)


def _draw_horizon(pen: Pen, result: Result, current: bool) -> None:
    row_px, sigma_px = result.calibration.horizon_row_px, result.sigmas.horizon_row_px
    if -0.5 <= row_px <= pen.bottom_px:
        pen.across(HORIZON_COLOR if current else STALE_COLOR, row_px)
        pen.words_at_right(f"horizon  ±{sigma_px:.1f} px", row_px)
    pen.band(FillKind.HORIZON_BAND, pen.left_px, pen.right_px, row_px - sigma_px, row_px + sigma_px)


def _draw_dragged_horizon(pen: Pen, document: Document, result: Result | None, grip: bool) -> None:
    """The horizon where somebody dragged it to; before, its grip where it comes out or in the middle."""
    belief = document.horizon
    if belief is not None:
        row_px = belief.prior.value
        color = HORIZON_COLOR if belief.enabled else STALE_COLOR
        pen.dashed(color, (pen.left_px, row_px), (pen.right_px, row_px))
        pen.words_at_right("horizon as set" if belief.enabled else "horizon as set, off", row_px)
    elif result is not None:
        row_px = result.calibration.horizon_row_px
    else:
        row_px = (pen.size.height - 1) / 2
        pen.dashed(HORIZON_COLOR, (pen.left_px, row_px), (pen.right_px, row_px))
        pen.words_at_right("drag this to the horizon", row_px)
    if grip:
        pen.keep_free(((pen.seen.left_px + pen.seen.right_px) / 2, row_px), HANDLE_RADIUS_CSS_PX)


def _draw_corridor(pen: Pen, calibration: Calibration, current: bool) -> None:
    """The strip that the vehicle covers, from the bottom of the picture to the horizon."""
    horizon_px = calibration.horizon_row_px
    if horizon_px >= pen.bottom_px:
        return
    distance_m, half_m = calibration.distance_at(pen.bottom_px), OWN_CAR_SIZE_M[1] / 2
    left_px, right_px = (calibration.column_at(side * half_m, distance_m) for side in (1.0, -1.0))
    if not (math.isfinite(left_px) and math.isfinite(right_px)):
        return
    vanishing = (calibration.camera.principal_column_px, horizon_px)
    left = pen.along(vanishing, (left_px, pen.bottom_px))
    right = pen.along(vanishing, (right_px, pen.bottom_px))
    for (a, b), (c, d) in zip(pairwise(left), pairwise(right), strict=False):
        pen.fills.append(Fill(FillKind.CORRIDOR, (a, c, d, b)))
    for edge in (left, right):
        if len(edge) > 1:
            pen.line(ROW_COLOR if current else STALE_COLOR, *reversed(edge))


def _draw_next_click(pen: Pen, click: NextClick, calibration: Calibration, imperial: bool) -> None:
    """Where one more point helps most: a dashed row with a target."""
    column_px, row_px = calibration.camera.principal_column_px, click.row_px
    column_px, row_px = next(iter(pen.seen_at((column_px, row_px))), (column_px, row_px))
    half_px, radius_px = NEXT_ROW_PART / 2 * pen.size.width, pen.css(TARGET_RADIUS_CSS_PX)
    for side in (-1, 1):
        start, end = (column_px + side * radius_px, row_px), (column_px + side * half_px, row_px)
        pen.dashed(NEXT_CLICK_COLOR, start, end)
    pen.ring(NEXT_CLICK_COLOR, (column_px, row_px), TARGET_RADIUS_CSS_PX, dashed=True)
    pen.ring(NEXT_CLICK_COLOR, (column_px, row_px), CROSS_GAP_CSS_PX)
    gain = gain_text(click.error_before, click.error_after)
    words = f"one more point here, {about_text(click.distance_m, imperial)}, {gain}"
    pen.words_beside(words, (column_px, row_px), TARGET_RADIUS_CSS_PX)


def _mark_text(mark: Mark, document: Document) -> str:
    distance = "distance?" if mark.distance_m is None else typed_text(mark.distance_m, document.imperial)
    if document.paced:  # counted from the first, wherever that is
        distance = "dash"
    return f"{mark.name}  {distance}" if mark.enabled else f"{mark.name}  {distance}, off"


def _crossing(first: Line, second: Line) -> Point | None:
    """Where two lines meet when extended; None where they are parallel."""
    (x1, y1), (x2, y2) = first.start_px, first.end_px
    (x3, y3), (x4, y4) = second.start_px, second.end_px
    determinant = (x1 - x2) * (y3 - y4) - (y1 - y2) * (x3 - x4)
    if determinant == 0:
        return None
    a, b = x1 * y2 - y1 * x2, x3 * y4 - y3 * x4
    return (a * (x3 - x4) - (x1 - x2) * b) / determinant, (a * (y3 - y4) - (y1 - y2) * b) / determinant
