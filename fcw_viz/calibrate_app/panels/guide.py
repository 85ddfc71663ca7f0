"""The line over the picture that says what to do next, and who else is here."""

from html import escape

import viser

from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.joint_fit import FEWEST_VEHICLES
from fcw_viz.calibrate_app.document.solution import EFFECT_DISTANCE_M
from fcw_viz.calibrate_app.document.state import SessionState, Status
from fcw_viz.calibrate_app.document.ways.hints import hint_clip
from fcw_viz.calibrate_app.document.ways.ways import VEHICLES
from fcw_viz.calibrate_app.panels.camera.besides import LOOKING_WORDS, looked_words
from fcw_viz.calibrate_app.proposals.drive_look import Look
from fcw_viz.page.channel import leads_to, says
from fcw_viz.page.style import CROSSHAIR_STYLE, STYLE, set_html, sheet_style, text_block

GOOD_ERROR = 0.1
"""An error of a tenth at the distance of the quality sentence may be called good."""
SHEET_WIDEST_PX = 900
"""A window that is higher than wide has the panel below the picture, up to this width."""

WAY_TO_TROUBLE = f'<button class="fcw-link" {leads_to("Calibrate", "trouble")}>Show it</button>'

SAVE = f'<button class="fcw-link" {says("save")}>Save</button>'


class Guide:
    """The line over the picture, which is always seen, and the notices above the steps."""

    def __init__(self, gui: viser.GuiApi, desk: Desk, docked_px: int) -> None:
        self._desk = desk
        # The colours of a page are those of its root: the docked panel's width is told there, too.
        docked = f"<style>:root {{ --fcw-docked: {docked_px}px; }}</style>"
        gui.add_html(f"{STYLE}{docked}{sheet_style(SHEET_WIDEST_PX)}{CROSSHAIR_STYLE}")
        desk.channel.on("save", lambda _: desk.save())
        self._banner = gui.add_html("")
        self._notices = gui.add_html("")

    def show(self, state: SessionState) -> None:
        """Say what to do next at a moment of the session."""
        look = self._desk.looks.vehicles
        words = vehicle_words(state, look.running, look.look) or _words(state)
        words = self._desk.tool_words or words
        kind = "" if self._desk.tool_words else _kind(state)
        way = "" if self._desk.tool_words else _way_on(state)
        banner = f'<div class="fcw-banner {kind}" role="status">{escape(words)} {way}</div>'
        set_html(self._banner, banner)
        notices = [state.notice] if state.notice else []
        if len(state.people) > 1:
            own = self._desk.person.name
            names = ", ".join(f"{name} (this one)" if name == own else name for name in state.people)
            notices.append(f"{len(state.people)} tabs are open: {names}. They share the same points.")
        html = "".join(f"<p>{escape(notice)}</p>" for notice in notices)
        set_html(self._notices, text_block(html) if html else "")


def vehicle_words(state: SessionState, running: bool, look: Look | None) -> str:
    """While vehicles are looked for, and where there were too few: what else would do; else empty.

    Args:
        state: of the session.
        running: whether they are looked for.
        look: what came of it.
    """
    document = state.document
    waits = state.solution.status is Status.INCOMPLETE and document.way == VEHICLES
    if not waits or document.vehicles:
        return ""
    if running:
        return LOOKING_WORDS
    if look is None or len(look.vehicles) >= FEWEST_VEHICLES:
        return ""
    shown = document.horizon is not None or None not in document.lane_lines
    return hint_clip(document) if shown else looked_words(document, look)


def _way_on(state: SessionState) -> str:
    """What does at once what the line says."""
    if state.solution.troubles:
        return WAY_TO_TROUBLE
    return SAVE if state.solution.can_save and not state.saved else ""


def _words(state: SessionState) -> str:
    """The next step, and with a result how good it is."""
    if state.saved and state.shown is not None:
        return f"{state.shown.quality} Saved{', with its warning' if state.solution.warnings else ''}."
    if state.current and state.shown is not None and not state.solution.height_assumed:
        return f"{state.shown.quality} {state.solution.hint}"
    return state.solution.hint


def _kind(state: SessionState) -> str:
    """The line's colour: plain, good, or trouble."""
    if state.solution.status in (Status.IMPLAUSIBLE, Status.DEGENERATE):
        return "trouble"
    if state.solution.status is not Status.GOOD or state.shown is None:
        return ""
    calibration = state.shown.calibration
    low_m, high_m = calibration.distance_interval(calibration.row_at(EFFECT_DISTANCE_M))
    return "good" if (high_m - low_m) / 2 <= GOOD_ERROR * EFFECT_DISTANCE_M else ""
