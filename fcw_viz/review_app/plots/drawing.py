"""The plots as SVG: curves with their intervals, axes with their values, and levels as the ground."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.charts.scale import Scale
from fcw.charts.svg import css_color, element, line, picture, words
from fcw.logs.overlay import LEVEL_COLORS
from fcw.warning.types import WarningLevel
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.plots.plot import AXIS_PX, Curve, Plot, plot_places
from fcw_viz.review_app.plots.quantities import tick_text, ticks
from fcw_viz.review_app.plots.values import Column, Run
from fcw_viz.review_app.time.axis import TimeAxis

PAD_PX = 3.0
"""From a plot's edge to its lowest and highest value."""
CURVE_WIDTH_PX = 1.6
DASHES = "5 3"
BAND_OPACITY = 0.28
LEVEL_OPACITY = {WarningLevel.ADVISORY: 0.1, WarningLevel.CAUTION: 0.16, WarningLevel.WARNING: 0.2}
TICK_PX, TICK_FONT_PX = 14.0, 9.5
"""Between the values of an axis at the least, and their size."""
BEYOND_PX = 64.0
"""Width of the words for what is above the axis, at the least."""
LONGEST_STEP, LONGEST_STEP_S = 4.0, 0.5
"""Frames further apart than so many usual ones, and than so long, are a gap: a live drive skips some."""


def plots_svg(plots: Sequence[Plot], runs: Sequence[Run], axis: TimeAxis, height_px: float) -> str:
    """The plots one above the other along the same axis of time, whose words stand under them.

    Args:
        plots: see `make_plots`.
        runs: of which they are; the first one's warnings are the ground.
        axis: of time.
        height_px: of all of it.
    """
    first = runs[0]
    ground = _level_spans(first.series.level[first.rows], first.times_s, axis, height_px - AXIS_PX)
    parts = [element("g", *ground, data_name="levels")]
    parts += [
        line(axis.x(tick_s), 0, axis.x(tick_s), height_px - AXIS_PX, 0.1)
        + words(axis.x(tick_s), height_px - 3, time_text(tick_s, axis.tick_decimals), "middle", 0.65)
        for tick_s in axis.ticks_s()
        if 20 <= axis.x(tick_s) <= axis.width_px - 20
    ]
    columns = {run.name: _columns(axis, run.times_s) for run in runs}
    for plot, (top_px, own_px) in zip(plots, plot_places(plots, height_px), strict=True):
        drawn = _plot(plot, axis, own_px, columns)
        parts.append(element("g", *drawn, data_plot=plot.signal.key, transform=f"translate(0 {top_px:.1f})"))
    return picture(round(axis.width_px), round(height_px), parts, "Signals over time")


@dataclass(frozen=True, slots=True)
class _Columns:
    """Rows gathered where several fall on one column of pixels.

    Attributes:
        x: (M,) where each column stands.
        starts: (M,) its first row.
        thin: whether every column is one row.
        torn: (M,) whether there is a gap in time before it.
    """

    x: Column
    starts: NDArray[np.intp]
    thin: bool
    torn: NDArray[np.bool_]

    def lowest(self, values: Column) -> Column:
        """The smallest value of each column; NaN where there is none."""
        return values if self.thin else np.fmin.reduceat(values, self.starts)

    def highest(self, values: Column) -> Column:
        """The largest value of each column; NaN where there is none."""
        return values if self.thin else np.fmax.reduceat(values, self.starts)


def _columns(axis: TimeAxis, times_s: Column) -> _Columns:
    x = (times_s - axis.start_s) / axis.span_s * axis.width_px
    steps_s = np.diff(times_s, prepend=times_s[:1])
    usual_s = float(np.median(steps_s[1:])) if len(times_s) > 1 else math.inf
    torn = steps_s > max(LONGEST_STEP * usual_s, LONGEST_STEP_S)
    if len(x) <= axis.width_px:
        return _Columns(x, np.arange(len(x)), True, torn)
    pixel = np.floor(x).astype(np.int64)
    starts = np.flatnonzero(np.diff(pixel, prepend=pixel[0] - 1))
    return _Columns((pixel[starts] + 0.5).astype(np.float64), starts, False, torn[starts])


def _plot(plot: Plot, axis: TimeAxis, height_px: float, columns: dict[str, _Columns]) -> Iterator[str]:
    yield element("rect", width=axis.width_px, height=height_px, fill="currentColor", fill_opacity=0.035)
    scale = Scale(plot.bottom, plot.top, height_px - PAD_PX, PAD_PX)
    for value in ticks(plot.bottom, plot.top, plot.step, max(int(height_px / TICK_PX), 2)):
        y = scale.px(value)
        yield line(0, y, axis.width_px, y, 0.3 if value == 0 and plot.bottom < 0 else 0.1)
        text = words(-5, min(max(y + 3.5, 8), height_px), tick_text(value), "end", 0.65, size=TICK_FONT_PX)
        yield element("g", text, data_name="tick")
    for number, curve in enumerate(plot.curves):
        if len(curve.run.times_s):
            yield from _curve(curve, scale, columns[curve.run.name])
            yield from _beyond(plot, number, axis, columns[curve.run.name])


def _beyond(plot: Plot, number: int, axis: TimeAxis, columns: _Columns) -> Iterator[str]:
    """Words where a curve is above all that the axis holds: without them it would seem not to be known."""
    told = columns.lowest(plot.curves[number].told.value)
    for run in _runs(told > plot.limit, columns.torn):
        left_px, right_px = max(columns.x[run][0], 0.0), min(columns.x[run][-1], axis.width_px)
        if right_px - left_px >= BEYOND_PX:
            text = f"over {plot.text(plot.limit)}"
            y = (number + 1) * TICK_PX
            said = words((left_px + right_px) / 2, y, text, "middle", 0.65, size=TICK_FONT_PX)
            yield element("g", said, data_name="beyond")


def _curve(curve: Curve, scale: Scale, columns: _Columns) -> Iterator[str]:
    y, values = scale.places_px, curve.drawn
    if values.low is not None and values.high is not None:
        low, high = y(columns.lowest(values.low)), y(columns.highest(values.high))
        for run in _runs(np.isfinite(low) & np.isfinite(high), columns.torn):
            outline = [*zip(columns.x[run], high[run], strict=True)]
            outline += [*zip(columns.x[run][::-1], low[run][::-1], strict=True)]
            color = {"fill": curve.color, "fill_opacity": BAND_OPACITY / (2 if curve.dashed else 1)}
            yield element("polygon", data_name="interval", points=outline, **color)
    lowest, highest = y(columns.lowest(values.value)), y(columns.highest(values.value))
    for run in _runs(np.isfinite(lowest), columns.torn):
        if columns.thin:
            corners = list(zip(columns.x[run], lowest[run], strict=True))
        else:
            # All values of a column of pixels: up and down it.
            corners = [
                corner
                for x, bottom, top in zip(columns.x[run], lowest[run], highest[run], strict=True)
                for corner in ((x, bottom), (x, top))
            ]
        if len(corners) == 1:  # a single value is seen, too
            corners = [(corners[0][0] - 0.5, corners[0][1]), (corners[0][0] + 0.5, corners[0][1])]
        style = {"fill": "none", "stroke": curve.color, "stroke_width": CURVE_WIDTH_PX}
        dashes = DASHES if curve.dashed else None
        yield element(
            "polyline",
            data_name="curve",
            points=corners,
            stroke_linejoin="round",
            stroke_dasharray=dashes,
            **style,
        )


def _runs(known: NDArray[np.bool_], torn: NDArray[np.bool_]) -> list[slice]:
    """Unbroken runs of what is known."""
    starts = np.flatnonzero(known & (torn | ~np.concatenate([[False], known[:-1]])))
    ends = np.flatnonzero(known & np.concatenate([torn[1:] | ~known[1:], [True]])) + 1
    return [slice(int(start), int(end)) for start, end in zip(starts, ends, strict=True)]


def _level_spans(
    levels: NDArray[np.int8], times_s: Column, axis: TimeAxis, height_px: float
) -> Iterator[str]:
    """The stretches in which a warning was shown, over all plots."""
    if not len(levels):
        return
    starts = np.flatnonzero(np.diff(levels, prepend=np.int8(-1)))
    ends = [*starts[1:], len(levels) - 1]
    for start, end in zip(starts, ends, strict=True):
        level = WarningLevel(int(levels[start]))
        if level is WarningLevel.NONE:
            continue
        left_px = max(axis.x(float(times_s[start])), 0.0)
        right_px = min(axis.x(float(times_s[min(end, len(times_s) - 1)])), axis.width_px)
        color = {"fill": css_color(LEVEL_COLORS[level]), "fill_opacity": LEVEL_OPACITY[level]}
        yield element("rect", x=left_px, width=max(right_px - left_px, 1.0), height=height_px, **color)
