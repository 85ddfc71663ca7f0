"""Step 4 of the job: the camera that comes out, how far to trust it, and where one more point helps."""

import math
from html import escape
from typing import TYPE_CHECKING

import viser

from fcw_viz.calibrate_app.page_style import card, set_html, step_heading, text_block
from fcw_viz.calibrate_app.state import Result, SessionState, Status

if TYPE_CHECKING:
    from fcw_viz.calibrate_app.tab import Tab

STALE_WORDS = "Not current: this is the last result that could be calculated."
TRADE_OFF_WORDS = "These trade off against each other: judge by the distances."


class ResultPanel:
    """The quality in a sentence, the parameters with their uncertainty, and the next point."""

    def __init__(self, gui: viser.GuiApi, tab: "Tab") -> None:
        self._heading = gui.add_html("")
        self._result = gui.add_html("")

    def show(self, state: SessionState) -> None:
        """Show the result of a moment of the session, or the last good one."""
        marks = {Status.GOOD: "done", Status.IMPLAUSIBLE: "now"}
        set_html(self._heading, step_heading(4, "Result", marks.get(state.solution.status, "")))
        set_html(self._result, text_block(_result_html(state)))


def _result_html(state: SessionState) -> str:
    if state.shown is None:
        return '<p class="dim">Comes as soon as three points have their distances.</p>'
    html = _parameters_html(state.shown)
    if not state.current:
        return card(f"<p>{STALE_WORDS}</p>{html}", "stale")
    assumed = (
        '<p class="dim">The height is still to be said: pitch is that of a camera at an assumed height.</p>'
        if state.solution.height_assumed
        else ""
    )
    return f'<p class="fcw-quality">{escape(state.shown.quality)}</p>{html}{assumed}'


def _parameters_html(result: Result) -> str:
    camera, sigmas = result.calibration.camera, result.sigmas
    field_of_view_deg = math.degrees(result.calibration.field_of_view_rad)
    # d(fov)/d(f) of fov = 2 atan(width / 2 f)
    half_width_px = result.calibration.image_size.width / 2
    by_focal = 2 * half_width_px / (camera.focal_y_px**2 + half_width_px**2)
    numbers = (
        ("Pitch, down", f"{math.degrees(camera.pitch_rad):.2f} ± {math.degrees(sigmas.pitch_rad):.2f}°"),
        ("Focal length", f"{camera.focal_y_px:.0f} ± {sigmas.focal_y_px:.0f} px"),
        ("Field of view", f"{field_of_view_deg:.1f} ± {math.degrees(by_focal * sigmas.focal_y_px):.1f}°"),
        ("Lens axis, row", f"{camera.principal_row_px:.0f} ± {sigmas.principal_row_px:.0f}"),
        ("Horizon, row", f"{camera.horizon_row_px:.1f} ± {sigmas.horizon_row_px:.1f}"),
    )
    cells = "".join(f"<div><span>{name}</span>{value}</div>" for name, value in numbers)
    return f'<div class="fcw-numbers">{cells}</div><p class="dim">{TRADE_OFF_WORDS}</p>'
