"""Plain charts as SVG: points and lines over two axes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

WIDTH_PX, HEIGHT_PX = 720, 400
LEFT_PX, RIGHT_PX, TOP_PX, BOTTOM_PX = 60, 20, 34, 46
COLOURS = ("#0b6e99", "#d1495b", "#8d6a9f", "#5b8c5a")


@dataclass(frozen=True, slots=True)
class Series:
    """One set of points.

    Attributes:
        name: in the legend.
        points: x and y; what is not finite, or outside the axes, is left out.
        line: whether they are joined.
        dot_px: radius of points that are not joined.
    """

    name: str
    points: Sequence[tuple[float, float]]
    line: bool = False
    dot_px: float = 1.6


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
    """

    title: str
    x_label: str
    y_label: str
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    series: Sequence[Series]
    bands: Sequence[tuple[float, float]] = ()

    def svg(self) -> str:
        """The chart as the text of an SVG file."""
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH_PX} {HEIGHT_PX}" '
            'font-family="sans-serif" font-size="12">',
            f'<rect width="{WIDTH_PX}" height="{HEIGHT_PX}" fill="white"/>',
            f'<text x="{LEFT_PX}" y="18" font-size="14">{_escaped(self.title)}</text>',
        ]
        floor_px, ceiling_px = HEIGHT_PX - BOTTOM_PX, TOP_PX
        for start, end in self.bands:
            left_px, right_px = self._x_px(max(start, self.x_range[0])), self._x_px(min(end, self.x_range[1]))
            parts.append(
                f'<rect x="{left_px:.1f}" y="{ceiling_px}" width="{max(right_px - left_px, 1.0):.1f}" '
                f'height="{floor_px - ceiling_px}" fill="#f6c7c7"/>'
            )
        for value in _ticks(*self.x_range):
            x_px = self._x_px(value)
            parts.append(f'<path d="M{x_px:.1f} {ceiling_px}V{floor_px}" stroke="#e4e4e4"/>')
            parts.append(f'<text x="{x_px:.1f}" y="{floor_px + 16}" text-anchor="middle">{value:g}</text>')
        for value in _ticks(*self.y_range):
            y_px = self._y_px(value)
            parts.append(f'<path d="M{LEFT_PX} {y_px:.1f}H{WIDTH_PX - RIGHT_PX}" stroke="#e4e4e4"/>')
            parts.append(f'<text x="{LEFT_PX - 6}" y="{y_px + 4:.1f}" text-anchor="end">{value:g}</text>')
        middle_px = (TOP_PX + floor_px) / 2
        parts.append(f'<text x="{WIDTH_PX / 2}" y="{HEIGHT_PX - 8}">{_escaped(self.x_label)}</text>')
        parts.append(
            f'<text transform="translate(14 {middle_px}) rotate(-90)" text-anchor="middle">'
            f"{_escaped(self.y_label)}</text>"
        )
        for place, series in enumerate(self.series):
            parts += self._drawn(series, place)
        return "\n".join([*parts, "</svg>", ""])

    def _drawn(self, series: Series, place: int) -> list[str]:
        colour = COLOURS[place % len(COLOURS)]
        legend_px = WIDTH_PX - RIGHT_PX - 150 * (len(self.series) - place)
        parts = [
            f'<text x="{legend_px}" y="{TOP_PX - 6}" fill="{colour}">{_escaped(series.name)}</text>',
        ]
        inside = [
            (self._x_px(x), self._y_px(y))
            for x, y in series.points
            if self.x_range[0] <= x <= self.x_range[1] and self.y_range[0] <= y <= self.y_range[1]
        ]
        if series.line and inside:
            path = "L".join(f"{x:.1f} {y:.1f}" for x, y in inside)
            parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        else:
            parts += [
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{series.dot_px:g}" fill="{colour}" '
                'fill-opacity="0.5"/>'
                for x, y in inside
            ]
        return parts

    def _x_px(self, value: float) -> float:
        low, high = self.x_range
        return LEFT_PX + (value - low) / (high - low) * (WIDTH_PX - LEFT_PX - RIGHT_PX)

    def _y_px(self, value: float) -> float:
        low, high = self.y_range
        return HEIGHT_PX - BOTTOM_PX - (value - low) / (high - low) * (HEIGHT_PX - BOTTOM_PX - TOP_PX)


def _ticks(low: float, high: float) -> list[float]:
    """Round values, four to ten of them."""
    step = 10 ** math.floor(math.log10((high - low) / 2))
    while (high - low) / step > 10:
        step *= 2.5 if str(step).lstrip("0.").startswith("2") else 2
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
