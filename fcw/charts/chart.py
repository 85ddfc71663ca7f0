"""A plain chart: points, lines and bands over two axes, with a legend."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from fcw.charts.scale import Scale, round_values
from fcw.charts.svg import element, line, picture, words

WIDTH_PX, PLOT_PX = 720, 320
LEFT_PX, RIGHT_PX, TITLE_PX, BOTTOM_PX = 60, 20, 28, 46
FONT_PX, TITLE_FONT_PX, LETTER_PX = 12, 14, 6.6
"""Sizes of the words, and about how wide one of their letters is."""
LEGEND_PX, SWATCH_PX, APART_PX = 18, 20, 18
"""Of the legend: height of a line, width of a sign, between two names."""
GRID_OPACITY, BAND_OPACITY, DOT_OPACITY = 0.15, 0.12, 0.5
MOST_X_TICKS, MOST_Y_TICKS = 10, 8
COLORS = ("#0b6e99", "#d1495b", "#8d6a9f", "#5b8c5a")
INK, MARKED = "#1c2430", "#f6c7c7"


@dataclass(frozen=True, slots=True)
class Series:
    """One set of points.

    Attributes:
        name: in the legend; empty for a chart whose title says it.
        points: x and y; what is not finite, or outside the axes, is left out.
        line: whether they are joined.
        dot_px: radius of points that are not joined.
        color: as CSS writes it; empty for the next one of the chart's own.
        band: x, low and high of a band about a line; it is cut at the axes' ends.
        mark: a point of a line to mark.
        point_names: of points that are not joined, told while the mouse is over one; empty for none.
    """

    name: str
    points: Sequence[tuple[float, float]]
    line: bool = False
    dot_px: float = 1.6
    color: str = ""
    band: Sequence[tuple[float, float, float]] = ()
    mark: tuple[float, float] | None = None
    point_names: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Chart:
    """Axes and what is drawn over them.

    Attributes:
        title: above.
        x_label: below, with the unit.
        y_label: beside, with the unit.
        x_range: of the horizontal axis.
        y_range: of the vertical axis.
        series: drawn in this order.
        bands: stretches of x that are marked, e.g. where a warning was shown.
        x_ticks: values named on the horizontal axis; empty for round ones.
        logarithmic: whether the horizontal axis is.
    """

    title: str
    x_label: str
    y_label: str
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    series: Sequence[Series]
    bands: Sequence[tuple[float, float]] = ()
    x_ticks: Sequence[float] = ()
    logarithmic: bool = False

    def svg(self) -> str:
        """The chart as the text of an SVG file, dark on white wherever it is shown."""
        colors = [series.color or COLORS[k % len(COLORS)] for k, series in enumerate(self.series)]
        legend, top = self._legend(colors)
        floor, right = top + PLOT_PX, WIDTH_PX - RIGHT_PX
        x = Scale(*self.x_range, LEFT_PX, right, self.logarithmic)
        y = Scale(*self.y_range, floor, top)
        parts = [
            element("rect", width=WIDTH_PX, height=floor + BOTTOM_PX, fill="white"),
            words(LEFT_PX, 18, self.title, size=TITLE_FONT_PX),
            *legend,
        ]
        for start, end in self.bands:
            left = x.px(start)
            width = max(x.px(end) - left, 1.0)
            place = {"x": left, "y": top, "width": width, "height": PLOT_PX}
            # Neighbours without a seam.
            parts.append(element("rect", **place, fill=MARKED, shape_rendering="crispEdges"))
        for value in self.x_ticks or round_values(*self.x_range, MOST_X_TICKS):
            parts.append(line(x.px(value), top, x.px(value), floor, GRID_OPACITY))
            parts.append(words(x.px(value), floor + 16, _number(value), "middle"))
        for value in round_values(*self.y_range, MOST_Y_TICKS):
            parts.append(line(LEFT_PX, y.px(value), right, y.px(value), GRID_OPACITY))
            parts.append(words(LEFT_PX - 6, y.px(value) + 4, _number(value), "end"))
        parts.append(words((LEFT_PX + right) / 2, floor + 38, self.x_label, "middle"))
        turned = f"translate(14 {(top + floor) / 2:g}) rotate(-90)"
        parts.append(words(0, 0, self.y_label, "middle", transform=turned))
        for series, color in zip(self.series, colors, strict=True):
            parts += self._drawn(series, color, x, y)
        drawn = element("g", *parts, font_size=FONT_PX, color=INK)
        return picture(WIDTH_PX, floor + BOTTOM_PX, [drawn], self.title, "width: 100%; height: auto")

    def _legend(self, colors: Sequence[str]) -> tuple[list[str], float]:
        """Signs and names under the title, in as many lines as they take; where the plot begins."""
        parts, left, base = [], float(LEFT_PX), float(TITLE_PX + FONT_PX)
        named = [pair for pair in zip(self.series, colors, strict=True) if pair[0].name]
        if not named:
            return [], TITLE_PX
        for series, color in named:
            width = SWATCH_PX + LETTER_PX * len(series.name)
            if left > LEFT_PX and left + width > WIDTH_PX - RIGHT_PX:
                left, base = float(LEFT_PX), base + LEGEND_PX
            if series.line:
                parts.append(element("rect", x=left, y=base - 5, width=14, height=3, fill=color))
            else:
                parts.append(element("rect", x=left + 4, y=base - 8, width=8, height=8, rx=4, fill=color))
            parts.append(words(left + SWATCH_PX, base, series.name))
            left += width + APART_PX
        return parts, base + 12

    def _drawn(self, series: Series, color: str, x: Scale, y: Scale) -> Iterator[str]:
        if series.band:
            at, low, high = np.array(series.band, float).T
            edges = [*_places(x, y, at, high), *reversed(_places(x, y, at, low))]
            yield element("polygon", points=edges, fill=color, fill_opacity=BAND_OPACITY)
        at, values = np.array(series.points, float).reshape(-1, 2).T
        inside = (x.low <= at) & (at <= x.high) & (y.low <= values) & (values <= y.high)
        places = _places(x, y, at[inside], values[inside])
        if series.line:
            if places:
                yield element("polyline", points=places, fill="none", stroke=color, stroke_width=2)
        else:
            names = series.point_names or [""] * len(at)
            for (cx, cy), name in zip(places, compress(names, inside), strict=True):
                title = [element("title", escape(name))] if name else []
                dot = {"cx": cx, "cy": cy, "r": series.dot_px, "fill": color, "fill_opacity": DOT_OPACITY}
                yield element("circle", *title, **dot)
        if series.mark is not None and all(map(math.isfinite, series.mark)):
            yield element("circle", cx=x.px(series.mark[0]), cy=y.px(series.mark[1]), r=5, fill=color)


def _places(
    x: Scale, y: Scale, at: NDArray[np.float64], values: NDArray[np.float64]
) -> list[tuple[float, float]]:
    return list(zip(x.places_px(at).tolist(), y.places_px(values).tolist(), strict=True))


def _number(value: float) -> str:
    return f"{value:g}".replace("-", "−")
