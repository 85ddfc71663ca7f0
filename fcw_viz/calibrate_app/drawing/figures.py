"""Figures of errors as inline SVG, for the page's panels and for the report."""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.plausibility import OUTLIER_SIGMAS
from fcw.charts.scale import Scale
from fcw.charts.svg import css_color, element, line, picture, words
from fcw.logs.overlay import ROW_COLOR
from fcw_viz.calibrate_app.document.numbers_text import (
    in_units,
    interval_text,
    percent_text,
    row_distance_text,
    unit_name,
)
from fcw_viz.calibrate_app.document.state import Result

TEAL = css_color(ROW_COLOR)
AMBER = "#d98a00"
"""Marks; dark enough for a white page, light enough for a dark one."""
GRID_OPACITY = 0.22
FIGURE_STYLE = "display: block; width: 100%; max-width: 26rem; height: auto"
"""As wide as its place, up to a readable width."""

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


def interval_plot(result: Result, imperial: bool) -> str:
    """The interval of the distance over the distance, relative above and in units below.

    Dots are the points, as the camera sees them. Where the upper end is unbounded, words say so.
    """
    width, height, left, right, top, bottom = 340, 240, 46, 24, 20, 74
    unit_m = 1 / in_units(1.0, imperial)
    calibration = result.calibration
    distances_m = np.geomspace(NEAREST_M, FARTHEST_M, CURVE_POINTS).tolist()
    curve = [(distance_m, *_relative_interval(calibration, distance_m)) for distance_m in distances_m]
    reach = _plot_height(curve)
    x = Scale(NEAREST_M, FARTHEST_M, left, width - right, logarithmic=True).px
    y = Scale(-reach, reach, height - bottom, top).px
    parts = [line(left, y(level), width - right, y(level), GRID_OPACITY) for level in _levels(reach)]
    parts += [words(left - 4, y(level) + 4, _signed_percent(level), "end", 0.75) for level in _levels(reach)]
    upper = [(x(d), y(high)) for d, _, high in curve if math.isfinite(high)]
    lower = [(x(d), y(low)) for d, low, _ in curve]
    unbounded = [d for d, _, high in curve if not math.isfinite(high)]
    if unbounded:
        upper += [(x(unbounded[0]), y(reach)), (x(FARTHEST_M), y(reach))]
    outline = [*upper, *reversed(lower)]
    parts.append(
        element("polygon", points=outline, fill=TEAL, fill_opacity=0.35, stroke=TEAL, stroke_width=1.2)
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
    for point, row_px in zip(calibration.points, calibration.straight_rows_px, strict=True):
        if NEAREST_M <= point.distance_m <= FARTHEST_M:
            seen_m = calibration.distance_at(row_px)
            relative = (seen_m - point.distance_m) / point.distance_m
            place = {"cx": x(point.distance_m), "cy": y(relative)}
            parts.append(
                element("circle", **place, r=3.5, fill=AMBER, stroke="currentColor", stroke_width=0.8)
            )
    parts.append(words(left, 12, "error of the distance, two times in three"))
    axis = f"distance in {unit_name(imperial)}, and its interval"
    parts.append(words(left, height - 20, axis, opacity=0.75))
    if unbounded:
        limit = row_distance_text(_rounded_down(in_units(unbounded[0], imperial)) * unit_m, imperial)
        parts.append(words(left, height - 6, f"beyond {limit} the interval has no upper end"))
    return picture(width, height, parts, "Error of the distance over the distance", style=FIGURE_STYLE)


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
    noise_px = NOISE_SIGMAS * per_sigma
    ground = {"fill": "currentColor", "fill_opacity": 0.12}
    parts = [
        element("rect", x=middle - noise_px, y=1, width=2 * noise_px, height=10, **ground),
        element("rect", x=min(middle, end), y=3, width=abs(end - middle), height=6, fill=color),
        line(middle, 0, middle, height, 0.8),
    ]
    if size > BAR_SIGMAS:
        tip = end + math.copysign(5, sigmas)
        parts.append(element("polygon", points=[(end, 1), (tip, 6), (end, 11)], fill=color))
    title = f"{sigmas:+.1f} times the click error"
    return picture(width, height, parts, title)


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
