"""How the error grows with the distance, and the ground from above, as drawn and as the picture shows it."""

import threading
import time

import viser

from fcw.camera.calibration import Calibration
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.birds_eye import birds_eye
from fcw_viz.calibrate_app.drawing.figures import interval_plot
from fcw_viz.calibrate_app.drawing.warped import warped_scale, warped_svg
from fcw_viz.page.channel import says_size
from fcw_viz.page.style import set_html, text_block

FIRST_WORDS = '<p class="dim">Appears with the first result.</p>'
PLOT_WORDS = (
    '<p class="dim">Two times in three the true distance lies in the band; the dots are your points.</p>'
)
WARPED_WORDS = (
    '<p class="dim">The picture projected onto the ground. The lane lines of a straight road must be '
    "straight, parallel and their true distance apart; the bar is as wide as a usual lane. A wrong width "
    "means a wrong height; lines that converge or diverge ahead mean a wrong horizon.</p>"
)
SIZE_NAME = "above"
WARP_PAUSE_S = 0.4
"""While somebody drags, the warped picture follows in such steps."""


class IntervalPanel:
    """The interval over the distance."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._plot = gui.add_html("")

    def show(self, state: SessionState) -> None:
        """Draw the result of a moment of the session."""
        if state.shown is None:
            set_html(self._plot, text_block(FIRST_WORDS))
            return
        stale = "" if state.current else ' class="fcw-stale"'
        plot = interval_plot(state.shown, state.document.imperial)
        set_html(self._plot, text_block(f"<div{stale}>{plot}</div>{PLOT_WORDS}"))


class AbovePanel:
    """The ground from above, drawn and warped.

    Warping takes longer than all else that follows a drag: it begins when somebody turns to it.
    """

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._picture = gui.add_html("")
        self._warped = ""
        self._warped_of: tuple[int, Calibration, bool] | None = None
        self._warped_s = 0.0
        self._later: threading.Timer | None = None
        self._seen = False
        desk.channel.on("size", self._shown)

    def show(self, state: SessionState) -> None:
        """Draw the result of a moment of the session."""
        if state.shown is None:
            set_html(self._picture, text_block(FIRST_WORDS))
            return
        document = state.document
        marks = document.marks if state.current else ()
        drawn = birds_eye(state.shown, marks, document.imperial, state.current)
        if self._seen:
            self._warp(state)
        figures = f'<div class="fcw-above" {says_size(SIZE_NAME)}>{self._warped}{drawn}</div>'
        set_html(self._picture, text_block(f"{WARPED_WORDS}{figures}"))

    def _shown(self, _: str) -> None:
        if not self._seen:
            self._seen = True
            self._desk.refresh()

    def close(self) -> None:
        """The tab is gone."""
        if self._later is not None:
            self._later.cancel()

    def _warp(self, state: SessionState) -> None:
        desk, result = self._desk, state.shown
        if result is None:
            return
        wanted = (desk.frame_index, result.calibration, state.document.imperial)
        if wanted == self._warped_of:
            return
        now_s = time.monotonic()
        if now_s - self._warped_s < WARP_PAUSE_S:
            if self._later is None or not self._later.is_alive():
                self._later = threading.Timer(WARP_PAUSE_S, lambda: desk.run(desk.refresh))
                self._later.start()
            return
        self._warped_s, self._warped_of = now_s, wanted
        image_bgr = desk.pictures.read(desk.frame_index).image
        self._warped = warped_svg(image_bgr, result, warped_scale(result), state.document.imperial)
