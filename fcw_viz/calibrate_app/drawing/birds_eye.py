"""The ground from above as inline SVG, for the page's panels and for the report."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from fcw.camera.calibration import Calibration
from fcw.charts.svg import element, picture, words
from fcw.logs.overlay import OWN_CAR_SIZE_M, VEHICLE_LENGTH_M
from fcw_viz.calibrate_app.document.document import Mark
from fcw_viz.calibrate_app.document.numbers_text import interval_text, row_distance_text
from fcw_viz.calibrate_app.document.state import DistanceRow, Result
from fcw_viz.calibrate_app.drawing.figures import AMBER, FARTHEST_M, FIGURE_STYLE, TEAL

SEEN_AHEAD_M = 50.0
"""Least depth of the ground seen from above."""
ABOVE_MARGIN = 1.1
LANES = 3
LANE_FILLED = 0.92
MINIMUM_ROW_GAP_PX = 14.0
"""Rows closer together leave no room for their words; the farther one is drawn."""


@dataclass(frozen=True, slots=True)
class GroundScale:
    """Where a point of the ground is drawn, seen from above, ahead being up, the same scale both ways.

    Attributes:
        width_px: of the drawing.
        height_px: of the drawing.
        ahead_m: how far from the reference the drawing reaches.
        behind_m: how far behind the reference.
    """

    width_px: float
    height_px: float
    ahead_m: float
    behind_m: float

    @property
    def px_per_m(self) -> float:
        """The scale."""
        return self.height_px / (self.ahead_m + self.behind_m)

    def place(self, distance_m: float, lateral_m: float) -> tuple[float, float]:
        """Where a point is drawn: distance from the reference, lateral positive to the left."""
        return (
            self.width_px / 2 - lateral_m * self.px_per_m,
            (self.ahead_m - distance_m) * self.px_per_m,
        )


def ground_scale(result: Result, marks: Iterable[Mark]) -> GroundScale:
    """The scale of `birds_eye`."""
    farthest_m = max((mark.distance_m or 0.0 for mark in marks), default=0.0)
    ahead_m = max(SEEN_AHEAD_M, min(farthest_m * ABOVE_MARGIN, FARTHEST_M * ABOVE_MARGIN))
    behind_m = max(result.calibration.reference_offset_m, 1.0) + 0.03 * ahead_m
    return GroundScale(300.0, 360.0, ahead_m, behind_m)


def birds_eye(result: Result, marks: Sequence[Mark], imperial: bool, current: bool = True) -> str:
    """The ground from above: the camera and what it sees, the rows with their intervals, the path, the marks.

    Marks lie where the calibration sees them, at their clicked row and column.
    """
    calibration = result.calibration
    scale = ground_scale(result, marks)
    color = TEAL if current else "#8a8a8a"
    parts = [*_wedge(calibration, scale, color), *_path(scale, color)]
    parts += _row_lines(result.rows, scale, color, imperial)
    camera_x, camera_y = scale.place(-calibration.reference_offset_m, 0.0)
    half_m = OWN_CAR_SIZE_M[1] / 2
    if calibration.reference_offset_m > 0:
        x, y = scale.place(0.0, half_m)
        size = {"width": 2 * half_m * scale.px_per_m, "height": VEHICLE_LENGTH_M * scale.px_per_m}
        ink = {"fill": "currentColor", "stroke": "currentColor"}
        parts.append(element("rect", x=x, y=y, **size, **ink, rx=2, fill_opacity=0.25, stroke_opacity=0.6))
    parts.append(element("circle", data_name="camera", cx=camera_x, cy=camera_y, r=3, fill="currentColor"))
    parts.append(words(camera_x + 8, camera_y + 4, "camera", opacity=0.75))
    parts += _ground_marks(calibration, marks, scale)
    return picture(scale.width_px, scale.height_px, parts, "The ground seen from above", style=FIGURE_STYLE)


def _wedge(calibration: Calibration, scale: GroundScale, color: str) -> Iterator[str]:
    """What the picture's width sees of the ground."""
    size = calibration.image_size
    camera_m = -calibration.reference_offset_m
    # The lens looks along the vehicle's axis: the picture's sides are at these laterals for each metre.
    depth_m = (scale.ahead_m + calibration.reference_offset_m) * math.cos(calibration.camera.pitch_rad)
    sides = (
        (calibration.camera.principal_column_px + 0.5) / calibration.camera.focal_y_px * depth_m,
        (calibration.camera.principal_column_px + 0.5 - size.width) / calibration.camera.focal_y_px * depth_m,
    )
    corners = [
        scale.place(camera_m, 0.0),
        scale.place(scale.ahead_m, sides[0]),
        scale.place(scale.ahead_m, sides[1]),
    ]
    yield element(
        "polygon",
        points=corners,
        fill=color,
        fill_opacity=0.07,
        stroke=color,
        stroke_opacity=0.45,
        stroke_dasharray="4 3",
    )


def _path(scale: GroundScale, color: str) -> Iterator[str]:
    half_m = OWN_CAR_SIZE_M[1] / 2
    left_x, top_y = scale.place(scale.ahead_m, half_m)
    right_x, bottom_y = scale.place(0.0, -half_m)
    size = {"width": right_x - left_x, "height": bottom_y - top_y}
    yield element("rect", x=left_x, y=top_y, **size, fill=color, fill_opacity=0.22)


def _row_lines(rows: Sequence[DistanceRow], scale: GroundScale, color: str, imperial: bool) -> Iterator[str]:
    """Lines across at the rows' distances; intervals that overlap stand side by side."""
    shown: list[DistanceRow] = []
    for row in reversed([row for row in rows if row.distance_m <= scale.ahead_m]):
        gap_m = MINIMUM_ROW_GAP_PX / scale.px_per_m
        if row.distance_m > 0 and (not shown or shown[-1].distance_m - row.distance_m >= gap_m):
            shown.append(row)
    lane_px = scale.width_px / LANES
    for index, row in enumerate(shown):
        others = (other for other in shown if other is not row)
        left, right, own = 0.0, scale.width_px, 1.1
        if any(row.low_m < other.high_m and other.low_m < row.high_m for other in others):
            left, own = index % LANES * lane_px, 2.6
            right = left + LANE_FILLED * lane_px
        top_y = scale.place(min(row.high_m, scale.ahead_m), 0.0)[1]
        bottom_y = scale.place(row.low_m, 0.0)[1]
        y = scale.place(row.distance_m, 0.0)[1]
        size = {"width": right - left, "height": max(bottom_y - top_y, 0.0)}
        yield element("rect", x=left, y=top_y, **size, fill=color, fill_opacity=0.3)
        for start, end, thickness in ((0.0, scale.width_px, 0.7), (left, right, own)):
            yield element("line", x1=start, y1=y, x2=end, y2=y, stroke=color, stroke_width=thickness)
        interval = interval_text(row.low_m, row.high_m, imperial)
        yield words(4, y - 3, f"{row_distance_text(row.distance_m, imperial)}  {interval}")


def _ground_marks(calibration: Calibration, marks: Sequence[Mark], scale: GroundScale) -> Iterator[str]:
    for mark in marks:
        column_px, row_px = calibration.straight_place(mark.column_px, mark.row_px)
        distance_m = calibration.distance_at(row_px)
        if not math.isfinite(distance_m) or distance_m > scale.ahead_m:
            continue
        x, y = scale.place(distance_m, calibration.lateral_at(column_px, row_px))
        fill = AMBER if mark.enabled else "none"
        yield element("circle", data_mark=str(mark.id), cx=x, cy=y, r=4, fill=fill, stroke="currentColor")
        yield words(x + 7, y + 4, mark.name)
