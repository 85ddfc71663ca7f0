"""Step 1 of the job: what somebody has to calibrate with, what each way needs and how good it gets."""

import math
from functools import cache
from html import escape

import numpy as np
import viser

from fcw.camera.uncertainty import relative_errors
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.edits import ChooseWay
from fcw_viz.calibrate_app.document.numbers_text import percent_text, row_distance_text
from fcw_viz.calibrate_app.document.solution import EFFECT_DISTANCE_M, calibration_of
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.ways import WAYS, Way, chosen_way
from fcw_viz.page.channel import says
from fcw_viz.page.style import set_html, step_heading, text_block

CHOICE_WORDS = "What do you have?"
OTHER_WAY = "Choose another method; nothing you entered is lost"


class WayPanel:
    """All ways as cards until one is chosen; then that one in a line."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._cards_were_shown = False
        self._heading = gui.add_html("")
        self._cards = gui.add_html("")
        desk.channel.on("way", self._choose)

    def show(self, state: SessionState) -> None:
        """Show the choice, or what was chosen."""
        way = chosen_way(state.document)
        set_html(self._heading, step_heading(1, CHOICE_WORDS, "now" if way is None else "done"))
        if way is not None:
            change = f'<button class="fcw-link" {says("way:")} title="{OTHER_WAY}">change</button>'
            # Chosen at the end of the list, the steps that follow would stay out of sight above. A page that
            # opens with what was chosen before stays at its top.
            seen = " data-fcw-seen" * self._cards_were_shown
            set_html(self._cards, text_block(f"<p{seen}><b>{escape(way.name)}</b> {change}</p>"))
            return
        self._cards_were_shown = True
        cards = "".join(_card(way, state.document.image_size, state.document.imperial) for way in WAYS)
        set_html(self._cards, text_block(f'<div class="fcw-ways">{cards}</div>'))

    def _choose(self, key: str) -> None:
        document = self._desk.state.document
        way = next((way for way in WAYS if way.key == key), None)
        self._desk.apply(*((ChooseWay(""),) if way is None else way.start(document)))


def _card(way: Way, size: ImageSize, imperial: bool) -> str:
    error = typical_error(way, size)
    at = row_distance_text(EFFECT_DISTANCE_M, imperial)
    good = f"At {at} about ± {percent_text(error)}" if math.isfinite(error) else ""
    when = "works with an earlier clip" if way.recorded else "with the car parked"
    return (
        f'<button class="fcw-way" {says(f"way:{way.key}")}><b>{escape(way.name)}</b>'
        f"<span>{escape(way.needs)}</span><i>{good}; {when}</i></button>"
    )


@cache
def typical_error(way: Way, size: ImageSize) -> float:
    """Relative standard deviation at `EFFECT_DISTANCE_M` by that way, of a typical camera clicked to 1 px."""
    calibration = calibration_of(way.example(size))
    if calibration is None:
        return math.inf
    return float(relative_errors(calibration, np.array([EFFECT_DISTANCE_M]))[0])
