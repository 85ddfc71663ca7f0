"""The panels of a live drive: words beside the picture, and plots of the last seconds under it."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

import viser

from fcw.charts.svg import css_color
from fcw.logs.overlay import LEVEL_COLORS
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.series import DriveSeries
from fcw.units import NS_PER_S
from fcw_viz.live_app.feed import HISTORY_S
from fcw_viz.live_app.latency import LatencyFigures
from fcw_viz.page.channel import says, says_size
from fcw_viz.page.keys import help_table
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.panels.layout import PAGE_STYLE, PANEL_WIDTH_PX
from fcw_viz.review_app.plots.area import figures_html, plots_html
from fcw_viz.review_app.plots.plot import make_plots
from fcw_viz.review_app.plots.signals import LIVE
from fcw_viz.review_app.plots.values import Run
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.strip import BOTTOM_PX, StripLayout
from fcw_viz.review_app.words import why

LIVE_STYLE = Path(__file__).with_name("live_page.css").read_text(encoding="utf-8")
TOP_PX = 8.0
"""Space above the plots."""
FIRST_LAYOUT = StripLayout(1040.0, 300.0)
HELP_ROWS = (
    ("B", "picture or view from above"),
    ("M", "sound on, off"),
    ("O", "overlay on, off"),
    ("Mouse", "over a box: vehicle details"),
    ("F", "whole picture"),
)


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """The last seconds of a running drive, in the form that the plots need.

    Attributes:
        header: header of the drive.
        series: the columns, with at least one row.
        first_ns: time of the first frame of the drive.
    """

    header: DriveHeader
    series: DriveSeries
    first_ns: int

    def rows_between(self, start_s: float, end_s: float) -> slice:
        """All rows, because the plots show only the last seconds."""
        return slice(0, len(self.series))

    @property
    def last_s(self) -> float:
        """Time of the last frame."""
        return (int(self.series.time_ns[-1]) - self.first_ns) / NS_PER_S


class LivePanels:
    """The panel and the strip of plots of one tab."""

    def __init__(self, gui: viser.GuiApi, title: str) -> None:
        self._title = title
        self._layout = FIRST_LAYOUT
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH_PX)
        gui.add_html(f"{PAGE_STYLE}<style>{LIVE_STYLE}</style>")
        self._sizes = gui.add_html("")
        gui.add_html(f'<div class="fcw-strip" {says_size("strip")}></div>')
        self._plots = gui.add_html("")
        self._figures = gui.add_html("")
        self._head = gui.add_html("")
        gui.add_html(text_block(_sound_html()))
        self._level = gui.add_html("")
        # The browser writes in it: it is never drawn anew. A reason, short or long, comes after it.
        gui.add_html(
            text_block('<p class="fcw-age">The picture on the screen is <b data-fcw-age>–</b> old.</p>')
        )
        self._why = gui.add_html("")
        self._latency = gui.add_html("")
        gui.add_html(text_block(f'<div class="fcw-keys">{help_table(HELP_ROWS)}</div>'))
        self.show_aspect(16, 9)

    def resized(self, about: str) -> None:
        """Take the size of an element from the browser."""
        self._layout = StripLayout.parse(about) or self._layout

    def show_aspect(self, width: int, height: int) -> None:
        """Set the height of the strip so that the picture has its room."""
        sizes = f"--fcw-docked: {PANEL_WIDTH_PX}px; --fcw-aspect: {height / width:.5f};"
        set_html(self._sizes, f"<style>:root {{ {sizes} }}</style>")

    def show_head(self, words: str, ended: bool) -> None:
        """Show what is running, and its state."""
        sign = '<span class="fcw-live ended">ended</span>' if ended else '<span class="fcw-live">LIVE</span>'
        set_html(
            self._head,
            text_block(
                f'<div class="fcw-drive"><b>{escape(self._title)}</b>{sign}</div><p class="dim">{words}</p>'
            ),
        )

    def show_result(
        self, result: FrameResult, header: DriveHeader, time_s: float, dropped: int, latency: LatencyFigures
    ) -> None:
        """Show what was found in a frame, and its age."""
        pictures = "1 picture" if dropped == 1 else f"{dropped} pictures"
        left_out = f" · {pictures} skipped" if dropped else ""
        self.show_head(
            f"{time_text(time_s)} · {header.image_size} · {escape(header.detector)}{left_out}", False
        )
        (_, level), *rows = why(result, header.imperial)
        listed = "".join(f"<dt>{escape(what)}</dt><dd>{escape(much)}</dd>" for what, much in rows)
        level_name, color = result.warning.level.name.lower(), css_color(LEVEL_COLORS[result.warning.level])
        notes = "".join(f'<div class="fcw-note">{escape(note)}</div>' for note in result.notes)
        set_html(
            self._level,
            text_block(f'<p class="fcw-level {level_name}" style="--level: {color}">{escape(level)}</p>'),
        )
        set_html(self._why, text_block(f'<dl class="fcw-why">{listed}</dl>{notes}'))
        set_html(
            self._latency,
            text_block(
                f'<p class="dim" data-name="latency">Delay since the picture arrived: '
                f"{latency.words()}. The delay of the camera itself is not included.</p>"
            ),
        )

    def show_plots(self, history: History) -> None:
        """Show the plots of the last seconds."""
        layout, end_s = self._layout, max(history.last_s, HISTORY_S)
        axis = TimeAxis(end_s - HISTORY_S, end_s, layout.axis_px)
        height_px = layout.height_px - TOP_PX - BOTTOM_PX
        runs = [Run.of(history, axis.start_s, axis.end_s)]
        plots = make_plots(runs, LIVE, history.header.imperial)
        place = layout.left_px, TOP_PX, height_px
        set_html(
            self._plots,
            f'<div class="fcw-strip fcw-now">{plots_html(plots, runs, axis, *place, slide=False)}</div>',
        )
        figures = figures_html(plots, history.last_s, *place)
        set_html(self._figures, f'<div class="fcw-strip fcw-now">{figures}</div>')


def _sound_html() -> str:
    return (
        '<div class="fcw-sound">'
        f"<button {says('mute:')} title=Sound on, off (M)>Sound</button>"
        '<span class="waits">silent until you click or press a key here</span>'
        '<span class="on">on</span><span class="muted">off</span></div>'
        f'<button {says("birdseye:")} title="Picture or view from above (B)">From above</button>'
    )
