"""The strip under the picture: the buttons of playback, the time line of the drive and the plots."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import viser

from fcw_viz.page.channel import says, says_size, slides
from fcw_viz.page.style import set_html
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.session import DriveReview
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.player import SPEEDS
from fcw_viz.review_app.time.plots import Plotted, make_plots, plot_places, plots_svg, value_text
from fcw_viz.review_app.time.timeline import HEIGHT_PX as TIMELINE_PX
from fcw_viz.review_app.time.timeline import timeline_svg

LEFT_PX, RIGHT_PX = 150.0, 14.0
"""Of the time line and the plots inside the strip: their names and figures stand at the left."""
BAR_PX, PLOTS_TOP_PX, BOTTOM_PX = 38.0, 38.0 + TIMELINE_PX + 8.0, 4.0
WINDOWS_S: dict[str, float | None] = {
    "10 s": 10.0,
    "30 s": 30.0,
    "2 min": 120.0,
    "10 min": 600.0,
    "whole": None,
}
"""How much of the drive the plots show."""
DEFAULT_WINDOW = "30 s"
PANEL_END = 1e6
"""The strip's place in the page: after all parts of the panel, in which it is not seen."""
SPEED_NAMES = {0.25: "¼×", 0.5: "½×", 1.0: "1×", 2.0: "2×", 4.0: "4×", 8.0: "8×"}


def _icon(*paths: str) -> str:
    """A sign of 12x12; letters that look so are not in every font."""
    shapes = "".join(f'<path d="{path}"/>' for path in paths)
    return f'<svg width="12" height="12" viewBox="0 0 12 12" fill="currentColor">{shapes}</svg>'


PREVIOUS_EVENT, NEXT_EVENT = _icon("M1 1h2v10h-2z", "M11 1v10l-7-5z"), _icon("M9 1h2v10h-2z", "M1 1v10l7-5z")
PREVIOUS_FRAME, NEXT_FRAME = _icon("M9 1v10l-7-5z"), _icon("M3 1v10l7-5z")


@dataclass(frozen=True, slots=True)
class StripLayout:
    """Sizes in CSS pixels.

    Attributes:
        width_px: of the strip.
        height_px: of the strip.
    """

    width_px: float
    height_px: float

    @property
    def axis_px(self) -> float:
        """Width of the time line and the plots."""
        return max(self.width_px - LEFT_PX - RIGHT_PX, 100.0)

    @property
    def plots_px(self) -> float:
        """Height of all plots with their axis."""
        return max(self.height_px - PLOTS_TOP_PX - BOTTOM_PX, 80.0)

    @classmethod
    def parse(cls, text: str) -> "StripLayout | None":
        """The size that the page tells, e.g. `strip 1040x315`; None for another element's."""
        name, _, size = text.partition(" ")
        width, _, height = size.partition("x")
        if name != "strip" or not (width.isdigit() and height.isdigit()):
            return None
        return cls(float(width), float(height))


class Strip:
    """The strip of one tab; all of it is HTML that speaks to the page's channel."""

    def __init__(self, gui: viser.GuiApi) -> None:
        parts = (gui.add_html("", order=PANEL_END + number) for number in range(5))
        self._frame, self._bar, self._timeline, self._plots, self._now = parts

    def hide(self) -> None:
        """Nothing of it is seen."""
        for part in (self._frame, self._bar, self._timeline, self._plots, self._now):
            set_html(part, "")

    def show_frame(self) -> None:
        """Its ground, which tells its size."""
        set_html(self._frame, f'<div class="fcw-strip" {says_size("strip")}></div>')

    def show_bar(
        self, playing: bool, speed: float, window: str, several_events: bool, from_above: bool
    ) -> None:
        """The buttons."""
        off = "" if several_events else " disabled"
        buttons = (
            f'<button {says("event:previous")} title="Previous event (P)"{off}>{PREVIOUS_EVENT}</button>'
            f'<button {says("step:-1")} title="Previous frame (←)">{PREVIOUS_FRAME}</button>'
            f'<button class="play{" on" if playing else ""}" {says("play:")} title="Play, stop (space)">'
            f"{'Stop' if playing else 'Play'}</button>"
            f'<button {says("step:1")} title="Next frame (→)">{NEXT_FRAME}</button>'
            f'<button {says("event:next")} title="Next event (N)"{off}>{NEXT_EVENT}</button>'
        )
        speeds = "".join(
            f'<button class="{"on" if one == speed else ""}" {says(f"speed:{one}")}>{SPEED_NAMES[one]}'
            "</button>"
            for one in SPEEDS
        )
        windows = "".join(
            f'<button class="{"on" if name == window else ""}" {says(f"window:{name}")}>{name}</button>'
            for name in WINDOWS_S
        )
        html = (
            f'<div class="fcw-strip fcw-now"><div class="fcw-bar" style="pointer-events: all">{buttons}'
            f'<span class="dim">speed</span><span class="fcw-choice">{speeds}</span>'
            f'<span class="space"></span><button class="{"on" if from_above else ""}" {says("birdseye:")} '
            'title="The road from above, or the picture (B)">From above</button>'
            f'<span class="dim">plots of</span><span class="fcw-choice">{windows}</span></div></div>'
        )
        set_html(self._bar, html)

    def show_timeline(
        self,
        drive: Drive,
        shown: DriveReview,
        window: tuple[float, float],
        selected: int | None,
        layout: StripLayout,
    ) -> None:
        """The whole drive."""
        axis = whole_axis(drive, layout)
        svg = timeline_svg(axis, shown.events, shown.review, window, selected, drive.header.imperial)
        area = (
            f'<div class="fcw-area" style="left:{LEFT_PX:.0f}px;top:{BAR_PX:.0f}px;'
            f'width:{axis.width_px:.0f}px;height:{TIMELINE_PX:.0f}px;pointer-events:all">'
            f'<div class="fcw-slide" {slides("fcw-whole", "seek", axis.start_s, axis.end_s)}></div>'
            f'<div class="fcw-marks" style="position:absolute;inset:0">{svg}</div></div>'
        )
        set_html(self._timeline, f'<div class="fcw-strip fcw-now">{area}</div>')

    def show_plots(self, drive: Drive, window: tuple[float, float], layout: StripLayout) -> None:
        """The plots of a range of time."""
        axis = TimeAxis(*window, layout.axis_px)
        area = (
            f'<div class="fcw-area" style="left:{LEFT_PX:.0f}px;top:{PLOTS_TOP_PX:.0f}px;'
            f'width:{axis.width_px:.0f}px;height:{layout.plots_px:.0f}px;pointer-events:all">'
            f"{plots_svg(drive, axis, layout.plots_px)}"
            f'<div class="fcw-slide" {slides("fcw-plots", "seek", axis.start_s, axis.end_s)}></div></div>'
        )
        set_html(self._plots, f'<div class="fcw-strip fcw-now">{area}</div>')

    def show_now(self, drive: Drive, row: int, window: tuple[float, float], layout: StripLayout) -> None:
        """The cursors and the figures of a moment."""
        time_s = drive.time_s(row)
        whole, plots = whole_axis(drive, layout), TimeAxis(*window, layout.axis_px)
        html = [
            _cursor("whole", LEFT_PX + whole.x(time_s), BAR_PX, TIMELINE_PX - 12),
            f'<div class="fcw-clock" style="top:{BAR_PX + 8:.0f}px" data-time="{time_s!r}" data-row="{row}">'
            f"<b>{time_text(time_s, 2)}</b><br><small>of {time_text(drive.duration_s)}, frame "
            f"{drive.frame_index(row)}</small></div>",
        ]
        if plots.holds(time_s):
            html.append(_cursor("plots", LEFT_PX + plots.x(time_s), PLOTS_TOP_PX, layout.plots_px - 16))
        html += figures_html(drive, row, layout.plots_px)
        set_html(self._now, f'<div class="fcw-strip fcw-now">{"".join(html)}</div>')


def whole_axis(drive: Drive, layout: StripLayout) -> TimeAxis:
    """The time line's axis."""
    return TimeAxis(0.0, max(drive.duration_s, 0.04), layout.axis_px)


def _cursor(name: str, x: float, top: float, height: float) -> str:
    return (
        f'<div class="fcw-cursor" data-cursor="{name}" '
        f'style="left:{x:.2f}px;top:{top:.0f}px;height:{height:.0f}px"></div>'
    )


def figures_html(drive: Plotted, row: int, height_px: float, top_px: float = PLOTS_TOP_PX) -> Sequence[str]:
    """Name and value of each plot, beside it."""
    plots = make_plots(drive.series, slice(row, row + 1), drive.header.imperial)
    figures = []
    for plot, (own_top_px, _) in zip(plots, plot_places(plots, height_px), strict=True):
        small = ""
        if plot.low is not None and plot.high is not None and plot.low[0] == plot.low[0]:
            high = f"{plot.high[0]:.{plot.decimals}f}" if plot.high[0] < float("inf") else "∞"
            small = f"<small>{plot.low[0]:.{plot.decimals}f} – {high}</small>"
        figures.append(
            f'<div class="fcw-figure" data-figure="{plot.key}" '
            f'style="top:{top_px + own_top_px:.0f}px;width:{LEFT_PX - 16:.0f}px">'
            f"<span>{escape(plot.title)}</span><b>{value_text(float(plot.values[0]), plot)}</b>{small}</div>"
        )
    return figures
