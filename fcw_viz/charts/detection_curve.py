"""The curve of a detector as an SVG picture: detection rate over false positives per image."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from fcw.detection.matching import DetectionCurve, OperatingPoint

LEFT, TOP, WIDTH, HEIGHT = 64, 16, 620, 320
LOWEST_FPPI, HIGHEST_FPPI = 0.005, 20.0
FPPI_TICKS = (0.01, 0.046, 0.1, 0.3, 1.0, 3.0, 10.0)
"""0.046 is where the paper's Table 4 stands."""
GRID_FPPI = np.geomspace(LOWEST_FPPI, HIGHEST_FPPI, 60)


@dataclass(frozen=True, slots=True)
class PlottedCurve:
    """A line of the plot.

    Attributes:
        name: for the legend.
        color: as CSS writes it.
        curve: the curve.
        mark: where its detector works; None: not marked.
        band: (low, high) rates at each of `GRID_FPPI`; empty: none is drawn.
    """

    name: str
    color: str
    curve: DetectionCurve
    mark: OperatingPoint | None = None
    band: Sequence[tuple[float, float]] = ()


def svg_curve(curves: Sequence[PlottedCurve]) -> str:
    """The plot as an `<svg>` element; false positives on a logarithmic axis."""
    parts = [
        f'<svg class="curve" viewBox="0 0 {LEFT + WIDTH + 16} {TOP + HEIGHT + 52}" role="img" '
        'aria-label="Detection rate over false positives per image">'
    ]
    for fppi in FPPI_TICKS:
        x = _x(fppi)
        parts.append(f'<line class="grid" x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{TOP + HEIGHT}"/>')
        parts.append(f'<text x="{x:.1f}" y="{TOP + HEIGHT + 18}" text-anchor="middle">{fppi:g}</text>')
    for tenth in range(0, 11, 2):
        y = _y(tenth / 10)
        parts.append(f'<line class="grid" x1="{LEFT}" y1="{y:.1f}" x2="{LEFT + WIDTH}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{tenth / 10:.1f}</text>')
    middle = LEFT + WIDTH / 2
    parts.append(f'<text x="{middle}" y="{TOP + HEIGHT + 40}" text-anchor="middle">')
    parts.append("false positives per image</text>")
    parts.append(f'<text transform="translate(16 {TOP + HEIGHT / 2}) rotate(-90)" text-anchor="middle">')
    parts.append("detection rate</text>")
    for plotted in curves:
        parts.extend(_band(plotted))
    for number, plotted in enumerate(curves):
        parts.append(f'<polyline fill="none" stroke="{plotted.color}" points="{_line(plotted.curve)}"/>')
        if plotted.mark is not None and not math.isnan(plotted.mark.detection_rate):
            x, y = _x(plotted.mark.fppi), _y(plotted.mark.detection_rate)
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{plotted.color}"/>')
        y = TOP + HEIGHT - 14 - 20 * (len(curves) - 1 - number)
        parts.append(f'<rect x="{LEFT + WIDTH - 330}" y="{y - 9}" width="18" height="4" ')
        parts.append(f'fill="{plotted.color}"/><text x="{LEFT + WIDTH - 306}" y="{y}">')
        parts.append(f"{escape(plotted.name)}</text>")
    return "".join([*parts, "</svg>"])


def _line(curve: DetectionCurve) -> str:
    """A staircase: between two thresholds the rate is that of the lower one with no more false positives."""
    corners = [(LOWEST_FPPI, 0.0)]
    for point in curve.points():
        corners += [(point.fppi, corners[-1][1]), (point.fppi, point.detection_rate)]
    corners.append((HIGHEST_FPPI, corners[-1][1]))
    return " ".join(f"{_x(fppi):.1f},{_y(rate):.1f}" for fppi, rate in corners if not math.isnan(rate))


def _band(plotted: PlottedCurve) -> list[str]:
    if not plotted.band:
        return []
    high = [f"{_x(x):.1f},{_y(high):.1f}" for x, (_, high) in zip(GRID_FPPI, plotted.band, strict=True)]
    low = [f"{_x(x):.1f},{_y(low):.1f}" for x, (low, _) in zip(GRID_FPPI, plotted.band, strict=True)]
    points = " ".join([*high, *reversed(low)])
    return [f'<polygon fill="{plotted.color}" fill-opacity="0.12" points="{points}"/>']


def _x(fppi: float) -> float:
    inside = min(max(fppi, LOWEST_FPPI), HIGHEST_FPPI)
    return LEFT + WIDTH * math.log(inside / LOWEST_FPPI) / math.log(HIGHEST_FPPI / LOWEST_FPPI)


def _y(rate: float) -> float:
    return TOP + HEIGHT * (1 - rate)
