"""The strip under the picture: the buttons of playback, the time line of the drive and the plots."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import viser

from fcw.annotation.review import Review
from fcw.units import NS_PER_S
from fcw_viz.page.channel import chooses, leads_to, says, says_size, slides, slides_along
from fcw_viz.page.style import set_html
from fcw_viz.review_app.drive import Drive, time_text, utc_text
from fcw_viz.review_app.plots.area import figures_html, plots_html
from fcw_viz.review_app.plots.choice import PLACE as PLOTS_PLACE
from fcw_viz.review_app.plots.plot import Plot, make_plots, wanted_px
from fcw_viz.review_app.plots.signals import Chosen
from fcw_viz.review_app.plots.values import Run
from fcw_viz.review_app.session import DriveReview
from fcw_viz.review_app.time.axis import TimeAxis
from fcw_viz.review_app.time.other_run import NO_OTHER_RUN, OtherRun, other_run_svg
from fcw_viz.review_app.time.player import SPEEDS
from fcw_viz.review_app.time.timeline import HEIGHT_PX as TIMELINE_PX
from fcw_viz.review_app.time.timeline import SIGNS_PX, TRACK_PX, labelled_spans, timeline_svg

RIGHT_PX, BOTTOM_PX = 14.0, 4.0
LEFT_PX, NARROW_LEFT_PX = 190.0, 144.0
"""Of the time line and the plots inside the strip: their names and figures stand at the left."""
BAR_PX, PLOTS_TOP_PX = 38.0, 38.0 + TIMELINE_PX + 8.0
"""The time line stands under the buttons, the plots under it."""
LISTS_BELOW_PX, NARROW_BELOW_PX = 910.0, 600.0
"""Of the strip's width: where it is less, speeds and ranges are chosen from lists; and the figures beside the
plots take less room."""
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
    def lists(self) -> bool:
        """Whether speeds and ranges are chosen from lists, for there is no room for all their buttons."""
        return self.width_px < LISTS_BELOW_PX

    @property
    def narrow(self) -> bool:
        """Whether figures beside the plots say the least."""
        return self.width_px < NARROW_BELOW_PX

    @property
    def left_px(self) -> float:
        """Where the time line and the plots begin."""
        return NARROW_LEFT_PX if self.narrow else LEFT_PX

    @property
    def axis_px(self) -> float:
        """Width of the time line and the plots."""
        return max(self.width_px - self.left_px - RIGHT_PX, 100.0)

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
        self._drawn: tuple[Plot, ...] = ()

    def hide(self) -> None:
        """Nothing of it is seen."""
        for part in (self._frame, self._bar, self._timeline, self._plots, self._now):
            set_html(part, "")

    def show_frame(self) -> None:
        """Its ground, which tells its size, and is as high as the plots want at the least."""
        least_px = PLOTS_TOP_PX + wanted_px(self._drawn) + BOTTOM_PX
        html = (
            f"<style>:root {{ --fcw-least: {least_px:.0f}px; }}</style>"
            f'<div class="fcw-strip" {says_size("strip")}>'
            '<div class="fcw-splitter" data-fcw-splitter title="Drag to resize the plots (H)"></div></div>'
        )
        set_html(self._frame, html)

    def show_bar(
        self,
        playing: bool,
        speed: float,
        window: str,
        several_events: bool,
        from_above: bool,
        layout: StripLayout,
    ) -> None:
        """The buttons."""
        off = "" if several_events else " disabled"
        buttons = (
            f'<button {says("event:previous")} title="Previous event (P)"{off}>{PREVIOUS_EVENT}</button>'
            f'<button {says("step:-1")} title="Previous frame (←)">{PREVIOUS_FRAME}</button>'
            f'<button class="play{" on" if playing else ""}" {says("play:")} title="Play or pause (space)">'
            f"{'Pause' if playing else 'Play'}</button>"
            f'<button {says("step:1")} title="Next frame (→)">{NEXT_FRAME}</button>'
            f'<button {says("event:next")} title="Next event (N)"{off}>{NEXT_EVENT}</button>'
        )
        speeds = _choice("speed", {str(one): SPEED_NAMES[one] for one in SPEEDS}, str(speed), layout.lists)
        windows = _choice("window", {name: name for name in WINDOWS_S}, window, layout.lists)
        speed_words, window_words = (
            ("", "")
            if layout.narrow
            else ('<span class="dim">speed</span>', '<span class="dim">window</span>')
        )
        above, add = ("Above", "+") if layout.narrow else ("From above", "+ Plot")
        close = " close" if layout.narrow else ""
        html = (
            f'<div class="fcw-strip fcw-now"><div class="fcw-bar{close}" style="height:{BAR_PX:.0f}px">'
            f"{buttons}"
            f'{speed_words}{speeds}<span class="space"></span>'
            f'<button class="{"on" if from_above else ""}" {says("birdseye:")} '
            f'title="Picture or view from above (B)">{above}</button>'
            f'<button {leads_to("Plots", PLOTS_PLACE)} title="Choose the plots">{add}</button>'
            f"{window_words}{windows}</div></div>"
        )
        set_html(self._bar, html)

    def show_timeline(
        self,
        drive: Drive,
        shown: DriveReview,
        window: tuple[float, float],
        selected: int | None,
        layout: StripLayout,
        marked: tuple[float, float] | None = None,
        other: OtherRun = NO_OTHER_RUN,
        reviewer: str = "",
    ) -> None:
        """The whole drive, with the range that is marked, and what differs from another run.

        The reviewer's own missed events have ends that are dragged.
        """
        axis = whole_axis(drive, layout)
        labelled = labelled_spans(drive, shown.review)
        imperial = drive.header.imperial
        svg = timeline_svg(axis, shown.events, shown.review, window, selected, imperial, labelled=labelled)
        area = (
            f'<div class="fcw-area" style="left:{layout.left_px:.0f}px;top:{BAR_PX:.0f}px;'
            f'width:{axis.width_px:.0f}px;height:{TIMELINE_PX:.0f}px;pointer-events:all">'
            f'<div class="fcw-slide" {slides("fcw-whole", "seek", axis.start_s, axis.end_s)}></div>'
            f'<div class="fcw-marks" style="position:absolute;inset:0">{svg}</div>'
            f'<div class="fcw-marks" style="position:absolute;inset:0">{other_run_svg(axis, other)}</div>'
            f"{_missed_ends_html(axis, shown.review, reviewer)}"
            f"{'' if marked is None else _marked_html(axis, marked)}</div>"
        )
        set_html(self._timeline, f'<div class="fcw-strip fcw-now">{area}</div>')

    def show_plots(
        self,
        runs: Sequence[Run],
        chosen: Sequence[Chosen],
        window: tuple[float, float],
        layout: StripLayout,
        imperial: bool,
        reading: bool = False,
        zero_utc_ns: int | None = None,
    ) -> None:
        """The plots of a range of time.

        Args:
            runs: the parts of the drives that are drawn, the one that is reviewed first.
            chosen: the curves.
            window: start and end.
            layout: of the strip.
            imperial: units.
            reading: whether some values have still to come.
            zero_utc_ns: UTC of the axis's 0; None where it is not known.
        """
        axis = TimeAxis(*window, layout.axis_px)
        self._drawn = make_plots(runs, chosen, imperial)
        html = plots_html(
            self._drawn, runs, axis, layout.left_px, PLOTS_TOP_PX, layout.plots_px, zero_utc_ns=zero_utc_ns
        )
        if not chosen:
            words = "No plots chosen. Add one with + Plot."
            html += f'<p class="fcw-none" style="left:{layout.left_px:.0f}px">{words}</p>'
        if reading:
            html += '<div class="fcw-reading">reading …</div>'
        set_html(self._plots, f'<div class="fcw-strip fcw-now">{html}</div>')
        self.show_frame()

    def show_now(self, drive: Drive, row: int, window: tuple[float, float], layout: StripLayout) -> None:
        """The cursors and the figures of a moment."""
        time_s = drive.time_s(row)
        whole, plots = whole_axis(drive, layout), TimeAxis(*window, layout.axis_px)
        frame = "" if layout.narrow else f", frame {drive.frame_index(row)}"
        zero_ns = drive.zero_utc_ns
        clock = (
            ""
            if zero_ns is None
            else f"<br><small>{utc_text(zero_ns + round(time_s * NS_PER_S), False)}</small>"
        )
        html = [
            _cursor("whole", layout.left_px + whole.x(time_s), BAR_PX, TIMELINE_PX - 12),
            f'<div class="fcw-clock" style="top:{BAR_PX - 1:.0f}px" data-time="{time_s!r}" '
            f'data-row="{row}"><b>{time_text(time_s, 2)}</b><br><small>of {time_text(drive.duration_s)}'
            f"{frame}</small>{clock}</div>",
        ]
        if plots.holds(time_s):
            html.append(
                _cursor("plots", layout.left_px + plots.x(time_s), PLOTS_TOP_PX, layout.plots_px - 16)
            )
        html.append(figures_html(self._drawn, time_s, layout.left_px, PLOTS_TOP_PX, layout.plots_px))
        set_html(self._now, f'<div class="fcw-strip fcw-now">{"".join(html)}</div>')


def _marked_html(axis: TimeAxis, marked: tuple[float, float]) -> str:
    """A range on the time line; its ends are dragged (`markstart:<seconds>`, `markend:<seconds>`)."""
    left, right = map(axis.x, marked)
    height = f"top:8px;height:{TIMELINE_PX - 20:.0f}px"
    ends = "".join(
        f'<div class="fcw-end" style="left:{x:.1f}px;{height}" '
        f"{slides_along(f'fcw-{name}', 'fcw-whole', name, axis.start_s, axis.end_s)}></div>"
        for name, x in (("markstart", left), ("markend", right))
    )
    width = max(right - left, 1.0)
    return f'<div class="fcw-marked" style="left:{left:.1f}px;width:{width:.1f}px;{height}"></div>{ends}'


def _missed_ends_html(axis: TimeAxis, review: Review, reviewer: str) -> str:
    """The ends of missed events (`missedfrom:<id>:<seconds>`, `missedto:<id>:<seconds>`), told once."""
    ends = []
    for entry in review.missed:
        if entry.person != reviewer:
            continue
        for name, time_s in (("missedfrom", entry.said.start_s), ("missedto", entry.said.end_s)):
            if not axis.holds(time_s):
                continue  # said of an earlier run, that was longer
            slide = slides_along(
                f"fcw-{name}-{entry.entry_id}",
                "fcw-whole",
                f"{name}:{entry.entry_id}",
                axis.start_s,
                axis.end_s,
                waits=True,
            )
            ends.append(
                f'<div class="fcw-end missed" style="left:{axis.x(time_s):.1f}px;top:{SIGNS_PX:.0f}px;'
                f'height:{TRACK_PX:.0f}px" title="Drag to change when it was missed" {slide}></div>'
            )
    return "".join(ends)


def whole_axis(drive: Drive, layout: StripLayout) -> TimeAxis:
    """The time line's axis."""
    return TimeAxis(0.0, max(drive.duration_s, 0.04), layout.axis_px)


def _cursor(name: str, x: float, top: float, height: float) -> str:
    return (
        f'<div class="fcw-cursor" data-cursor="{name}" '
        f'style="left:{x:.2f}px;top:{top:.0f}px;height:{height:.0f}px"></div>'
    )


def _choice(name: str, choices: Mapping[str, str], chosen: str, as_list: bool) -> str:
    """One of several, each by a button or all from a list."""
    if as_list:
        options = "".join(
            f'<option value="{escape(value)}"{" selected" * (value == chosen)}>{escape(words)}</option>'
            for value, words in choices.items()
        )
        return f'<select {chooses(name)} title="{escape(name)}">{options}</select>'
    buttons = "".join(
        f'<button class="{"on" if value == chosen else ""}" {says(f"{name}:{value}")}>{escape(words)}'
        "</button>"
        for value, words in choices.items()
    )
    return f'<span class="fcw-choice">{buttons}</span>'
