"""Draws the curve of a detector: detection rate over false positives per image."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fcw.charts.chart import Chart, Series
from fcw.detection.matching import DetectionCurve, OperatingPoint

LOWEST_FPPI, HIGHEST_FPPI = 0.005, 20.0
FPPI_TICKS = (0.01, 0.046, 0.1, 0.3, 1.0, 3.0, 10.0)
"""0.046 is the value of the paper's Table 3."""
GRID_FPPI = np.geomspace(LOWEST_FPPI, HIGHEST_FPPI, 60)


@dataclass(frozen=True, slots=True)
class PlottedCurve:
    """A line of the plot.

    Attributes:
        name: its name in the legend.
        color: its CSS colour.
        curve: the curve.
        mark: the operating point of its detector; None for no mark.
        band: (low, high) rates at each of `GRID_FPPI`; empty for no band.
    """

    name: str
    color: str
    curve: DetectionCurve
    mark: OperatingPoint | None = None
    band: Sequence[tuple[float, float]] = ()


def curve_chart(curves: Sequence[PlottedCurve]) -> Chart:
    """The plot; false positives on a logarithmic axis."""
    return Chart(
        "Detection rate over false positives per image",
        "false positives per image",
        "detection rate",
        (LOWEST_FPPI, HIGHEST_FPPI),
        (0.0, 1.0),
        [_series(plotted) for plotted in curves],
        x_ticks=FPPI_TICKS,
        logarithmic=True,
    )


def _series(plotted: PlottedCurve) -> Series:
    fppis = GRID_FPPI[: len(plotted.band)].tolist()
    return Series(
        plotted.name,
        _staircase(plotted.curve),
        line=True,
        color=plotted.color,
        band=[(fppi, *rates) for fppi, rates in zip(fppis, plotted.band, strict=True)],
        mark=plotted.mark and (plotted.mark.fppi, plotted.mark.detection_rate),
    )


def _staircase(curve: DetectionCurve) -> list[tuple[float, float]]:
    """The curve as steps: between two points, the rate is that of the point with fewer false positives."""
    corners = [(LOWEST_FPPI, 0.0)]
    for point in curve.points():
        fppi = min(max(point.fppi, LOWEST_FPPI), HIGHEST_FPPI)
        corners += [(fppi, corners[-1][1]), (fppi, point.detection_rate)]
    return [*corners, (HIGHEST_FPPI, corners[-1][1])]
