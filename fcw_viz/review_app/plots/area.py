"""The plots' part of the strip: names and figures at the left, the curves beside them."""

from collections.abc import Iterator, Sequence
from html import escape

import numpy as np

from fcw_viz.page.channel import says, slides
from fcw_viz.review_app.plots.drawing import plots_svg
from fcw_viz.review_app.plots.plot import LINE_PX, TITLE_PX, Curve, Plot, plot_places, readout
from fcw_viz.review_app.plots.signals import AHEAD, OWN, chosen_text
from fcw_viz.review_app.plots.values import Run
from fcw_viz.review_app.time.axis import TimeAxis

TICKS_PX, EDGE_PX = 36.0, 12.0
"""Left of the curves: the values of their axes, and the room at the strip's edge."""
BUTTONS_FROM_PX = 150.0
"""Where names and figures have less room, curves are taken away in the list alone."""


def plots_html(
    plots: Sequence[Plot],
    runs: Sequence[Run],
    axis: TimeAxis,
    left_px: float,
    top_px: float,
    height_px: float,
    slide: bool = True,
    zero_utc_ns: int | None = None,
) -> str:
    """The curves with their names; a click or a drag along them is `seek:<seconds>`.

    Args:
        plots: see `make_plots`.
        runs: of which they are.
        axis: of time.
        left_px: where the axis begins in the strip.
        top_px: where the plots begin in it.
        height_px: of them.
        slide: whether moments can be chosen and curves be taken away.
        zero_utc_ns: UTC of the axis's 0; None where it is not known.
    """
    legend = "".join(_legend(plots, left_px, top_px, height_px, slide))
    utc = "" if zero_utc_ns is None else f' data-fcw-utc="{zero_utc_ns // 1_000_000}"'
    catch = (
        f'<div class="fcw-slide" {slides("fcw-plots", "seek", axis.start_s, axis.end_s)} '
        f'data-fcw-readout="{escape(readout(plots, axis))}"{utc}></div>'
        if slide
        else ""
    )
    return (
        f'{legend}<div class="fcw-area" style="left:{left_px:.0f}px;top:{top_px:.0f}px;'
        f'width:{axis.width_px:.0f}px;height:{height_px:.0f}px;pointer-events:{"all" if slide else "none"}">'
        f"{plots_svg(plots, runs, axis, height_px)}{catch}</div>"
    )


def figures_html(
    plots: Sequence[Plot], time_s: float, left_px: float, top_px: float, height_px: float
) -> str:
    """The values of a moment, beside their curves."""
    figures = []
    for plot, (own_top_px, _) in zip(plots, plot_places(plots, height_px), strict=True):
        several = len(plot.curves) > 1
        for number, curve in enumerate(plot.curves):
            row = _row_at(curve, time_s)
            value = np.nan if row is None else float(curve.told.value[row])
            small = ""
            if row is not None and not several and curve.told.low is not None and curve.told.high is not None:
                low, high = float(curve.told.low[row]), float(curve.told.high[row])
                if not (np.isnan(low) or np.isnan(high)):
                    top = f"{high:.{plot.decimals}f}" if np.isfinite(high) else "∞"
                    small = f"<small>{low:.{plot.decimals}f} – {top}</small>"
            place = top_px + own_top_px + TITLE_PX + LINE_PX * number
            figures.append(
                f'<div class="fcw-figure{" side" if several else ""}" data-figure="{_figure(curve)}" '
                f'style="top:{place:.0f}px;width:{left_px - EDGE_PX - TICKS_PX:.0f}px">'
                f"<b>{escape(plot.text(value))}</b>{small}</div>"
            )
    return "".join(figures)


def _legend(
    plots: Sequence[Plot], left_px: float, top_px: float, height_px: float, removable: bool
) -> Iterator[str]:
    width = f"width:{left_px - EDGE_PX - TICKS_PX:.0f}px"
    for plot, (own_top_px, _) in zip(plots, plot_places(plots, height_px), strict=True):
        top = top_px + own_top_px
        several = len(plot.curves) > 1
        away = _away(plot.curves[0]) if removable and left_px > BUTTONS_FROM_PX and not several else ""
        yield (
            f'<div class="fcw-plot-title" style="top:{top:.0f}px;{width}" title="{escape(plot.title)}">'
            f"<span>{escape(plot.title)}</span>{away}</div>"
        )
        if not several:
            continue
        for number, curve in enumerate(plot.curves):
            dashed = " dashed" if curve.dashed else ""
            place = top + TITLE_PX + LINE_PX * number
            away = _away(curve) if removable and left_px > BUTTONS_FROM_PX and not curve.dashed else ""
            yield (
                f'<div class="fcw-plot-curve{dashed}" style="top:{place:.0f}px;{width};'
                f'--curve:{curve.color}"><i></i><span>{escape(curve.name)}</span>{away}</div>'
            )


def _away(curve: Curve) -> str:
    """The button that takes a curve away."""
    return f'<button {says(f"plot:{chosen_text([curve.chosen])}")} title="Remove">×</button>'


def _figure(curve: Curve) -> str:
    parts = [curve.chosen.signal]
    parts += [curve.chosen.subject] if curve.chosen.subject not in (AHEAD, OWN) else []
    parts += ["other"] if curve.dashed else []
    return " ".join(parts)


def _row_at(curve: Curve, time_s: float) -> int | None:
    """Which of its values is that of a moment; None where the run is not there then."""
    row = int(np.searchsorted(curve.run.times_s, time_s + 1e-6, side="right")) - 1
    return None if row < 0 or time_s > curve.run.end_s else row
