"""From chosen curves to plots: curves of one signal share a plot, whose axis holds what is there."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.charts.svg import css_color
from fcw.logs.overlay import ROW_COLOR
from fcw_viz.review_app.plots.signals import AHEAD, OWN, SIGNALS, Chosen, Signal, subject_name
from fcw_viz.review_app.plots.values import Run, Values
from fcw_viz.review_app.time.axis import TimeAxis

COLORS = (
    css_color(ROW_COLOR),
    "rgb(232, 89, 12)",
    "rgb(132, 94, 247)",
    "rgb(12, 166, 120)",
    "rgb(230, 73, 128)",
    "rgb(240, 170, 0)",
)
"""Of a plot's curves, one after the other."""
AXIS_PX = 16.0
"""Height of the words under the plots."""
GAP_PX = 4.0
TITLE_PX, LINE_PX = 15.0, 15.0
"""Beside a plot: its title, and a line for each curve."""
LEAST_PX = 32.0


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve of a plot, in the unit of its axis.

    Attributes:
        chosen: what it is of.
        name: in the legend; empty where the plot's title says all.
        color: of its line.
        run: whose it is.
        drawn: what of it the axis holds.
        told: its values whatever the axis holds.
        dashed: whether it is of another run than the one that is reviewed.
    """

    chosen: Chosen
    name: str
    color: str
    run: Run
    drawn: Values
    told: Values
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Plot:
    """Curves over one axis of values.

    Attributes:
        signal: of its curves.
        title: over them.
        unit: of its axis.
        decimals: of a value in words.
        bottom: value at the lower edge.
        top: value at the upper edge.
        step: of the values that the axis can name.
        limit: above it nothing is drawn; infinite where there is no such value.
        curves: at least one.
    """

    signal: Signal
    title: str
    unit: str
    decimals: int
    bottom: float
    top: float
    step: float
    limit: float
    curves: tuple[Curve, ...]

    @property
    def least_px(self) -> float:
        """The room that its words want."""
        return max(LEAST_PX, TITLE_PX + LINE_PX * len(self.curves))

    def text(self, value: float) -> str:
        """A value with its unit; a dash where there is none."""
        if np.isnan(value):
            return "–"
        words = "∞" if np.isposinf(value) else f"{value:.{self.decimals}f}"
        return f"{words} {self.unit}".rstrip() if self.unit != "%" else f"{words} %"


def make_plots(runs: Sequence[Run], chosen: Sequence[Chosen], imperial: bool) -> tuple[Plot, ...]:
    """The plots of what is chosen, in the order in which it was chosen.

    Args:
        runs: the one that is reviewed, and one that it is compared with, whose vehicles have other numbers:
            of those only the first run's are drawn.
        chosen: by somebody.
        imperial: units.
    """
    grouped: dict[str, list[Chosen]] = {}
    for one in chosen:
        grouped.setdefault(one.signal, []).append(one)
    return tuple(_plot(SIGNALS[key], ones, runs, imperial) for key, ones in grouped.items())


def _plot(signal: Signal, chosen: Sequence[Chosen], runs: Sequence[Run], imperial: bool) -> Plot:
    unit, factor, decimals = signal.quantity.in_units(imperial)
    found = [
        (one, run, number, run.values(one))
        for one in chosen
        for number, run in enumerate(runs)
        if number == 0 or one.subject in (AHEAD, OWN)
    ]
    drawn = [_drawn(signal, values) for _, _, _, values in found]
    held = [part for values in drawn for part in values if part is not None]
    bottom, top, step = signal.span.axis(held, factor)
    several = len(found) > 1
    curves = tuple(
        Curve(
            one,
            _name(one, run) if several else "",
            COLORS[place % len(COLORS)],
            run,
            _scaled(values, factor),
            _scaled(told, factor),
            number > 0,
        )
        for place, ((one, run, number, told), values) in enumerate(zip(found, drawn, strict=True))
    )
    of_vehicle = not several and chosen[0].subject not in (AHEAD, OWN)
    title = f"{signal.title} {subject_name(chosen[0].subject)}" if of_vehicle else signal.title
    limit = signal.span.highest * factor
    return Plot(signal, title, unit, decimals, bottom, top, step, limit, curves)


def _name(chosen: Chosen, run: Run) -> str:
    if run.name:
        return run.name if chosen.subject in (AHEAD, OWN) else f"#{chosen.subject}"
    return {AHEAD: "ahead", OWN: ""}.get(chosen.subject, f"#{chosen.subject}")


def _drawn(signal: Signal, values: Values) -> Values:
    """Values that the axis is for; NaN beyond, so that no curve runs along the plot's edge."""
    if signal.span.highest == np.inf:
        return values
    value = np.where(values.value <= signal.span.highest, values.value, np.nan)
    if values.low is None or values.high is None:
        return Values(value)
    high = np.where(np.isnan(value), np.nan, np.minimum(values.high, signal.span.highest))
    return Values(value, np.where(np.isnan(value), np.nan, values.low), high)


def _scaled(values: Values, factor: float) -> Values:
    low, high = (None if part is None else part * factor for part in values[1:])
    return Values(values.value * factor, low, high)


def plot_places(plots: Sequence[Plot], height_px: float) -> list[tuple[float, float]]:
    """Upper edge and height of each plot, of all the height there is: what its words want, and a part of the
    rest."""
    least = [plot.least_px for plot in plots]
    room_px = height_px - AXIS_PX - (len(plots) - 1) * GAP_PX
    places, top_px = [], 0.0
    for own in least:
        own_px = own * room_px / sum(least)
        places.append((top_px, own_px))
        top_px += own_px + GAP_PX
    return places


def wanted_px(plots: Sequence[Plot]) -> float:
    """The height that the plots want at the least."""
    return AXIS_PX + sum(plot.least_px + GAP_PX for plot in plots)


def readout(plots: Sequence[Plot], axis: TimeAxis) -> str:
    """What the page tells of the moment under the mouse, as JSON.

    Of each run its moments, at most one a pixel, and of each curve its name, unit, colour and figures there.
    """
    runs: list[dict[str, object]] = []
    known: dict[str, tuple[int, NDArray[np.intp]]] = {}
    for plot in plots:
        for curve in plot.curves:
            run = curve.run
            if run.name not in known:
                times_s = run.times_s
                every = max(1, -(-len(times_s) // max(int(axis.width_px), 1)))
                at = np.arange(0, len(times_s), every)
                known[run.name] = len(runs), at
                # After the run's end there is no value any more.
                ends_s = [*times_s[at], *filter(np.isfinite, [run.end_s])]
                moments_s = [round(float(time_s), 3) for time_s in ends_s]
                runs.append({"times_s": moments_s, "curves": []})
            number, at = known[run.name]
            listed = runs[number]["curves"]
            assert isinstance(listed, list)
            listed.append(
                {
                    "name": " · ".join(filter(None, (plot.title, curve.name))),
                    "unit": plot.unit,
                    "color": curve.color,
                    "values": [*(_number(value, plot.decimals) for value in curve.told.value[at]), ""],
                }
            )
    return json.dumps(runs, separators=(",", ":"))


def _number(value: float, decimals: int) -> str:
    return "" if np.isnan(value) else f"{value:.{decimals}f}"
