"""The plots under the picture: distance, closing speed, TTC, headway and own speed, as SVG."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fcw.charts.scale import Scale
from fcw.charts.svg import css_color, element, line, picture, words
from fcw.logs.overlay import LEVEL_COLORS, ROW_COLOR
from fcw.logs.records import DriveHeader
from fcw.logs.series import DriveSeries
from fcw.units import FEET_PER_METRE, KMH_PER_MPS, MPH_PER_MPS
from fcw.warning.types import WarningLevel
from fcw_viz.review_app.drive import NS_PER_S, time_text
from fcw_viz.review_app.time.axis import TimeAxis

DISTANCE_SHARE = 1.8
"""The distance has an interval to be seen: its plot is the highest."""
AXIS_PX = 16.0
"""Height of the words under the plots."""
GAP_PX = 5.0
PAD_PX = 3.0
"""From a plot's edge to its lowest and highest value."""
CURVE_WIDTH_PX = 1.6
BAND_OPACITY = 0.28
LEVEL_OPACITY = {WarningLevel.ADVISORY: 0.1, WarningLevel.CAUTION: 0.16, WarningLevel.WARNING: 0.2}
DISTANCE_TOPS_M = (10.0, 20.0, 30.0, 40.0, 60.0, 80.0, 100.0, 150.0)
SPEED_TOPS_MPS = (2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 50.0)
LONGEST_TTC_S = 10.0
"""Beyond ten seconds nobody is warned: the plot keeps its room for what matters."""
LONGEST_HEADWAY_S = 4.0
CURVE_COLOR = css_color(ROW_COLOR)


class Plotted(Protocol):
    """A drive, or what is known of one that still runs."""

    @property
    def header(self) -> DriveHeader:
        """Of the drive."""
        ...

    @property
    def series(self) -> DriveSeries:
        """Its columns."""
        ...

    @property
    def first_ns(self) -> int:
        """From when seconds count."""
        ...

    def rows_between(self, start_s: float, end_s: float) -> slice:
        """Rows of a range of time, with the one before and the one after."""
        ...


@dataclass(frozen=True, slots=True)
class Plot:
    """One curve over time.

    Attributes:
        key: of its place on the page.
        title: its name.
        unit: of its axis.
        values: (N,) float, NaN where there is none, in that unit.
        bottom: value at the lower edge.
        top: value at the upper edge.
        decimals: of a value in words.
        share: of the height, beside the others.
        low: (N,) lower edge of the interval; None where there is no interval.
        high: (N,) its upper edge, inf where it has none.
    """

    key: str
    title: str
    unit: str
    values: NDArray[np.float64]
    bottom: float
    top: float
    decimals: int
    share: float = 1.0
    low: NDArray[np.float64] | None = None
    high: NDArray[np.float64] | None = None


def make_plots(series: DriveSeries, rows: slice, imperial: bool) -> tuple[Plot, ...]:
    """The plots of a range of rows, each with a scale that holds what is there.

    They are of the warned vehicle while one is warned of, else of the lead; the last is our own speed.
    """
    metre = FEET_PER_METRE if imperial else 1.0
    speed = MPH_PER_MPS if imperial else KMH_PER_MPS
    distance_m = series.about("distance_m")[rows].astype(np.float64)
    high_m = series.about("distance_high_m")[rows].astype(np.float64)
    closing_mps = series.about("closing_speed_mps")[rows].astype(np.float64)
    farthest_m = _largest(np.where(np.isfinite(high_m), high_m, distance_m))
    fastest_mps = _largest(np.abs(closing_mps))
    top = _above(farthest_m, DISTANCE_TOPS_M) * metre
    speed_top = _above(fastest_mps, SPEED_TOPS_MPS) * speed
    bottom = -speed_top if _largest(-closing_mps) > 0.1 * fastest_mps else 0.0
    decimals = 0 if imperial else 1
    low_m = series.about("distance_low_m")[rows].astype(np.float64)
    interval = low_m * metre, high_m * metre
    ttc_s = _up_to(series.about("ttc_s")[rows], LONGEST_TTC_S)
    headway_s = _up_to(series.about("headway_s")[rows], LONGEST_HEADWAY_S)
    own_mps = series.ego_speed_mps[rows].astype(np.float64)
    # A speed that was given has no interval.
    own_sigma_mps = np.where(series.ego_speed_sigma_mps[rows] > 0, series.ego_speed_sigma_mps[rows], np.nan)
    own_low_mps, own_high_mps = np.maximum(own_mps - own_sigma_mps, 0.0), own_mps + own_sigma_mps
    own_top = _above(_largest(np.fmax(own_mps, own_high_mps)), SPEED_TOPS_MPS) * speed
    own_interval = own_low_mps * speed, own_high_mps * speed
    length, rate = ("ft", "mph") if imperial else ("m", "km/h")
    return (
        Plot(
            "distance", "Distance", length, distance_m * metre, 0.0, top, decimals, DISTANCE_SHARE, *interval
        ),
        Plot("closing", "Closing speed", rate, closing_mps * speed, bottom, speed_top, 0),
        Plot("ttc", "Time to collision", "s", ttc_s, 0.0, LONGEST_TTC_S, 1),
        Plot("headway", "Headway", "s", headway_s, 0.0, LONGEST_HEADWAY_S, 1),
        Plot("own", "Own speed", rate, own_mps * speed, 0.0, own_top, 0, 1.0, *own_interval),
    )


def plots_svg(drive: Plotted, axis: TimeAxis, height_px: float) -> str:
    """The plots one above the other along the same axis of time, whose words stand under them."""
    rows = drive.rows_between(axis.start_s, axis.end_s)
    times_s = (drive.series.time_ns[rows] - drive.first_ns) / NS_PER_S
    plots = make_plots(drive.series, rows, drive.header.imperial)
    columns = _columns(axis, times_s)
    ground = _level_spans(drive.series.level[rows], times_s, axis, height_px - AXIS_PX)
    parts = [element("g", *ground, data_name="levels")]
    parts += [
        line(axis.x(tick_s), 0, axis.x(tick_s), height_px - AXIS_PX, 0.1)
        + words(axis.x(tick_s), height_px - 3, time_text(tick_s, _tick_decimals(axis)), "middle", 0.65)
        for tick_s in axis.ticks_s()
        if 20 <= axis.x(tick_s) <= axis.width_px - 20
    ]
    for plot, (top_px, own_px) in zip(plots, plot_places(plots, height_px), strict=True):
        drawn = _plot(plot, axis, own_px, columns)
        parts.append(element("g", *drawn, data_plot=plot.key, transform=f"translate(0 {top_px:.1f})"))
    return picture(round(axis.width_px), round(height_px), parts, "The vehicle ahead over time")


def plot_places(plots: Sequence[Plot], height_px: float) -> list[tuple[float, float]]:
    """Upper edge and height of each plot, of all the height there is."""
    shared_px = height_px - AXIS_PX - (len(plots) - 1) * GAP_PX
    shares = [plot.share for plot in plots]
    places, top_px = [], 0.0
    for share in shares:
        own_px = shared_px * share / sum(shares)
        places.append((top_px, own_px))
        top_px += own_px + GAP_PX
    return places


def value_text(value: float, plot: Plot) -> str:
    """A value of a plot with its unit; a dash where there is none."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.{plot.decimals}f} {plot.unit}"


def _up_to(values: NDArray[np.float32], limit: float) -> NDArray[np.float64]:
    """Values up to a limit; NaN beyond, so that no curve runs along the plot's edge."""
    return np.where(values <= limit, values, np.nan).astype(np.float64)


def _largest(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else 0.0


def _above(value: float, tops: tuple[float, ...]) -> float:
    return next((top for top in tops if top >= value), tops[-1])


def _tick_decimals(axis: TimeAxis) -> int:
    ticks_s = axis.ticks_s()
    return 1 if any(tick_s != round(tick_s) for tick_s in ticks_s) else 0


@dataclass(frozen=True, slots=True)
class _Columns:
    """Rows gathered where several fall on one column of pixels.

    Attributes:
        x: (M,) where each column stands.
        starts: (M,) its first row.
        count: of all rows.
        thin: whether every column is one row.
    """

    x: NDArray[np.float64]
    starts: NDArray[np.intp]
    count: int
    thin: bool

    def lowest(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The smallest value of each column; NaN where there is none."""
        return values if self.thin else np.fmin.reduceat(values, self.starts)

    def highest(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The largest value of each column; NaN where there is none."""
        return values if self.thin else np.fmax.reduceat(values, self.starts)


def _columns(axis: TimeAxis, times_s: NDArray[np.float64]) -> _Columns:
    x = (times_s - axis.start_s) / axis.span_s * axis.width_px
    if len(x) <= axis.width_px:
        return _Columns(x, np.arange(len(x)), len(x), True)
    pixel = np.floor(x).astype(np.int64)
    starts = np.flatnonzero(np.diff(pixel, prepend=pixel[0] - 1))
    return _Columns((pixel[starts] + 0.5).astype(np.float64), starts, len(x), False)


def _plot(plot: Plot, axis: TimeAxis, height_px: float, columns: _Columns) -> Iterator[str]:
    yield element("rect", width=axis.width_px, height=height_px, fill="currentColor", fill_opacity=0.035)
    scale = Scale(plot.bottom, plot.top, height_px - PAD_PX, PAD_PX)
    y = scale.places_px
    if plot.bottom < 0:
        yield line(0, scale.px(0), axis.width_px, scale.px(0), 0.3)
    if plot.low is not None and plot.high is not None:
        low, high = y(columns.lowest(plot.low)), y(columns.highest(plot.high))
        for run in _runs(np.isfinite(low) & np.isfinite(high)):
            outline = [*zip(columns.x[run], high[run], strict=True)]
            outline += [*zip(columns.x[run][::-1], low[run][::-1], strict=True)]
            color = {"fill": CURVE_COLOR, "fill_opacity": BAND_OPACITY}
            yield element("polygon", data_name="interval", points=outline, **color)
    lowest, highest = y(columns.lowest(plot.values)), y(columns.highest(plot.values))
    for run in _runs(np.isfinite(lowest)):
        if columns.thin:
            corners = list(zip(columns.x[run], lowest[run], strict=True))
        else:
            # All values of a column of pixels: up and down it.
            corners = [
                corner
                for x, bottom, top in zip(columns.x[run], lowest[run], highest[run], strict=True)
                for corner in ((x, bottom), (x, top))
            ]
        style = {"fill": "none", "stroke": CURVE_COLOR, "stroke_width": CURVE_WIDTH_PX}
        yield element("polyline", data_name="curve", points=corners, stroke_linejoin="round", **style)
    label = f"{plot.top:g} {plot.unit}"
    yield words(axis.width_px - 4, 11, label, "end", 0.55, size=10)


def _runs(known: NDArray[np.bool_]) -> list[slice]:
    """Unbroken runs of what is known."""
    edges = np.flatnonzero(np.diff(known.astype(np.int8), prepend=0, append=0))
    return [slice(int(start), int(end)) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def _level_spans(
    levels: NDArray[np.int8], times_s: NDArray[np.float64], axis: TimeAxis, height_px: float
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
