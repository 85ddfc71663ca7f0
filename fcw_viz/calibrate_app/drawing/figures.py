"""Small figures as inline SVG, for the page's panels and for the report.

Words and axes are drawn in `currentColor`, so that they read in dark and in light.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from fcw.camera.calibration import Calibration
from fcw.camera.plausibility import OUTLIER_SIGMAS
from fcw.logs.overlay import OWN_CAR_SIZE_M, ROW_COLOR, VEHICLE_LENGTH_M
from fcw_viz.calibrate_app.document.document import Mark
from fcw_viz.calibrate_app.document.numbers_text import (
    in_units,
    interval_text,
    percent_text,
    row_distance_text,
    unit_name,
)
from fcw_viz.calibrate_app.document.state import DistanceRow, Result
from fcw_viz.charts.svg import line, points_text, svg_element, words

TEAL = "rgb({}, {}, {})".format(*ROW_COLOR)
AMBER = "#d98a00"
"""Marks; dark enough for a white page, light enough for a dark one."""
GRID_OPACITY = 0.22

NEAREST_M, FARTHEST_M = 3.0, 80.0
"""The range of the plot."""
CURVE_POINTS = 90
TICKS_M = (3.0, 5.0, 10.0, 20.0, 40.0, 80.0)
TICKS_FT = (10.0, 25.0, 50.0, 100.0, 250.0)
INTERVAL_LINES_PX = (38, 27)
"""Below the plot, in turn, so that neighbours do not run into each other."""
PLOT_HEIGHTS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""What the relative error's axis may reach; of these the first that holds the plot up to `FULL_TO_M`."""
FULL_TO_M = 50.0

BAR_SIGMAS = 4.0
"""A residual's bar is full at so many sigmas."""
NOISE_SIGMAS = 2.0
"""Residuals up to this are to be expected."""

SEEN_AHEAD_M = 50.0
"""Least depth of the ground seen from above."""
ABOVE_MARGIN = 1.1
LANES = 3
LANE_FILLED = 0.92
MINIMUM_ROW_GAP_PX = 14.0
"""Rows closer together leave no room for their words; the farther one is drawn."""


def interval_plot(result: Result, imperial: bool) -> str:
    """The interval of the distance over the distance, relative above and in units below.

    Dots are the points, as the camera sees them. Where the upper end is unbounded, words say so.
    """
    width, height, left, right, top, bottom = 340, 240, 46, 24, 20, 74
    unit_m = 1 / in_units(1.0, imperial)
    calibration = result.calibration
    distances_m = [
        NEAREST_M * (FARTHEST_M / NEAREST_M) ** (k / (CURVE_POINTS - 1)) for k in range(CURVE_POINTS)
    ]
    curve = [(distance_m, *_relative_interval(calibration, distance_m)) for distance_m in distances_m]
    reach = _plot_height(curve)

    def x(distance_m: float) -> float:
        part = math.log(distance_m / NEAREST_M) / math.log(FARTHEST_M / NEAREST_M)
        return left + part * (width - left - right)

    def y(relative: float) -> float:
        part = (min(max(relative, -reach), reach) + reach) / (2 * reach)
        return height - bottom - part * (height - top - bottom)

    parts = [line(left, y(level), width - right, y(level), GRID_OPACITY) for level in _levels(reach)]
    parts += [words(left - 4, y(level) + 4, _signed_percent(level), "end", 0.75) for level in _levels(reach)]
    upper = [(x(d), y(high)) for d, _, high in curve if math.isfinite(high)]
    lower = [(x(d), y(low)) for d, low, _ in curve]
    unbounded = [d for d, _, high in curve if not math.isfinite(high)]
    if unbounded:
        upper += [(x(unbounded[0]), y(reach)), (x(FARTHEST_M), y(reach))]
    parts.append(
        f'<polygon points="{points_text([*upper, *reversed(lower)])}" fill="{TEAL}" fill-opacity="0.35" '
        f'stroke="{TEAL}" stroke-width="1.2"/>'
    )
    parts.append(line(left, y(0.0), width - right, y(0.0), 0.8))
    for number, tick in enumerate(TICKS_FT if imperial else TICKS_M):
        distance_m = tick * unit_m
        parts.append(line(x(distance_m), y(reach), x(distance_m), y(-reach) + 4, GRID_OPACITY))
        parts.append(words(x(distance_m), height - bottom + 15, f"{tick:g}", "middle"))
        low_m, high_m = calibration.distance_interval(calibration.row_at(distance_m))
        short = interval_text(low_m, high_m, imperial) if math.isfinite(high_m) else "open"
        if number > 0:  # the first one would run into the axis of the errors
            base = height - bottom + INTERVAL_LINES_PX[number % 2]
            parts.append(words(x(distance_m), base, short, "middle", 0.75, size=9.5))
    for point in calibration.points:
        if NEAREST_M <= point.distance_m <= FARTHEST_M:
            seen_m = calibration.distance_at(point.row_px)
            relative = (seen_m - point.distance_m) / point.distance_m
            parts.append(
                f'<circle cx="{x(point.distance_m):.2f}" cy="{y(relative):.2f}" r="3.5" fill="{AMBER}" '
                'stroke="currentColor" stroke-width="0.8"/>'
            )
    parts.append(words(left, 12, "error of the distance, 16th to 84th percentile"))
    axis = f"distance in {unit_name(imperial)}, and its interval"
    parts.append(words(left, height - 20, axis, opacity=0.75))
    if unbounded:
        limit = row_distance_text(_rounded_down(in_units(unbounded[0], imperial)) * unit_m, imperial)
        parts.append(words(left, height - 6, f"beyond {limit} the interval has no upper end"))
    return svg_element(width, height, parts, "Error of the distance over the distance")


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
        car = (2 * half_m * scale.px_per_m, VEHICLE_LENGTH_M * scale.px_per_m)
        parts.append(
            f'<rect x="{x:.2f}" y="{y:.2f}" width="{car[0]:.2f}" height="{car[1]:.2f}" rx="2" '
            'fill="currentColor" fill-opacity="0.25" stroke="currentColor" stroke-opacity="0.6"/>'
        )
    parts.append(
        f'<circle data-name="camera" cx="{camera_x:.3f}" cy="{camera_y:.3f}" r="3" fill="currentColor"/>'
    )
    parts.append(words(camera_x + 8, camera_y + 4, "camera", opacity=0.75))
    parts += _ground_marks(calibration, marks, scale)
    return svg_element(scale.width_px, scale.height_px, parts, "The ground seen from above")


def residual_bar(sigmas: float) -> str:
    """A bar from the middle, as long as a residual is large in standard deviations of a click.

    It is full at `BAR_SIGMAS`; beyond, an arrow head says that it goes on. The grey ground is the noise that
    is to be expected.
    """
    width, height = 72.0, 12.0
    middle = width / 2
    shown = min(max(sigmas, -BAR_SIGMAS), BAR_SIGMAS)
    per_sigma = (middle - 6) / BAR_SIGMAS
    size = abs(sigmas)
    color = TEAL if size <= NOISE_SIGMAS else AMBER if size <= OUTLIER_SIGMAS else "#d9480f"
    end = middle + shown * per_sigma
    parts = [
        f'<rect x="{middle - NOISE_SIGMAS * per_sigma:.2f}" y="1" width="{2 * NOISE_SIGMAS * per_sigma:.2f}" '
        'height="10" fill="currentColor" fill-opacity="0.12"/>',
        f'<rect x="{min(middle, end):.2f}" y="3" width="{abs(end - middle):.2f}" height="6" fill="{color}"/>',
        line(middle, 0, middle, height, 0.8),
    ]
    if size > BAR_SIGMAS:
        tip = end + math.copysign(5, sigmas)
        parts.append(
            f'<polygon points="{points_text([(end, 1.0), (tip, 6.0), (end, 11.0)])}" fill="{color}"/>'
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
        f'height="{height:g}" role="img"><title>{sigmas:+.1f} times the error of a click</title>'
        f"{''.join(parts)}</svg>"
    )


def _relative_interval(calibration: Calibration, distance_m: float) -> tuple[float, float]:
    low_m, high_m = calibration.distance_interval(calibration.row_at(distance_m))
    return low_m / distance_m - 1, high_m / distance_m - 1


def _plot_height(curve: Sequence[tuple[float, float, float]]) -> float:
    worst = max(max(-low, high) for distance_m, low, high in curve if distance_m <= FULL_TO_M)
    return next((reach for reach in PLOT_HEIGHTS if worst <= reach), PLOT_HEIGHTS[-1])


def _levels(reach: float) -> tuple[float, ...]:
    return -reach, -reach / 2, 0.0, reach / 2, reach


def _signed_percent(part: float) -> str:
    if part == 0:
        return "0"
    return f"{'+' if part > 0 else '−'}{percent_text(abs(part)).replace('.0%', '%')}"


def _rounded_down(value: float) -> float:
    """To two digits."""
    digit = 10 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digit) * digit


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
    yield (
        f'<polygon points="{points_text(corners)}" fill="{color}" fill-opacity="0.07" stroke="{color}" '
        'stroke-opacity="0.45" stroke-dasharray="4 3"/>'
    )


def _path(scale: GroundScale, color: str) -> Iterator[str]:
    half_m = OWN_CAR_SIZE_M[1] / 2
    left_x, top_y = scale.place(scale.ahead_m, half_m)
    right_x, bottom_y = scale.place(0.0, -half_m)
    yield (
        f'<rect x="{left_x:.2f}" y="{top_y:.2f}" width="{right_x - left_x:.2f}" '
        f'height="{bottom_y - top_y:.2f}" fill="{color}" fill-opacity="0.22"/>'
    )


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
        yield (
            f'<rect x="{left:.2f}" y="{top_y:.2f}" width="{right - left:.2f}" '
            f'height="{max(bottom_y - top_y, 0.0):.2f}" fill="{color}" fill-opacity="0.3"/>'
        )
        for start, end, thickness in ((0.0, scale.width_px, 0.7), (left, right, own)):
            yield (
                f'<line x1="{start:.2f}" y1="{y:.2f}" x2="{end:.2f}" y2="{y:.2f}" stroke="{color}" '
                f'stroke-width="{thickness:g}"/>'
            )
        interval = interval_text(row.low_m, row.high_m, imperial)
        yield words(4, y - 3, f"{row_distance_text(row.distance_m, imperial)}  {interval}")


def _ground_marks(calibration: Calibration, marks: Sequence[Mark], scale: GroundScale) -> Iterator[str]:
    for mark in marks:
        distance_m = calibration.distance_at(mark.row_px)
        if not math.isfinite(distance_m) or distance_m > scale.ahead_m:
            continue
        x, y = scale.place(distance_m, calibration.lateral_at(mark.column_px, mark.row_px))
        fill = AMBER if mark.enabled else "none"
        yield (
            f'<circle data-mark="{mark.id}" cx="{x:.6f}" cy="{y:.6f}" r="4" fill="{fill}" '
            'stroke="currentColor" stroke-width="1"/>'
        )
        yield words(x + 7, y + 4, mark.name)
