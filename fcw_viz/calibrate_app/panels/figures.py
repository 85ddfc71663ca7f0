"""How the error grows with the distance, and the ground from above."""

import viser

from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.birds_eye import birds_eye
from fcw_viz.calibrate_app.drawing.figures import interval_plot
from fcw_viz.page.style import set_html, text_block

FIRST_WORDS = '<p class="dim">Comes with the first result.</p>'
PLOT_WORDS = (
    '<p class="dim">Two times in three the true distance lies in the band; the dots are your points.</p>'
)


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
    """The ground from above."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._picture = gui.add_html("")

    def show(self, state: SessionState) -> None:
        """Draw the result of a moment of the session."""
        if state.shown is None:
            set_html(self._picture, text_block(FIRST_WORDS))
            return
        document = state.document
        marks = document.marks if state.current else ()
        picture = birds_eye(state.shown, marks, document.imperial, state.current)
        set_html(self._picture, text_block(f'<div class="fcw-above">{picture}</div>'))
