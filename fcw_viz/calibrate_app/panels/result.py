"""Step 5 of the job: how far to trust the camera that comes out, what is wrong with it, and its numbers."""

import math
from html import escape

import viser

from fcw.logs.overlay import OWN_CAR_SIZE_M
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.numbers_text import row_distance_text
from fcw_viz.calibrate_app.document.state import Result, SessionState, Status
from fcw_viz.calibrate_app.panels.trouble import TroublePanel
from fcw_viz.page.style import card, set_html, step_heading, text_block

FIRST_WORDS = '<p class="dim">Appears as soon as enough is known.</p>'
STALE_WORDS = "Out of date: the last result that could be calculated."
UNTOLD_WORDS = (
    '<p class="dim">Pitch and lens appear once the camera height is known; until then, the intervals allow '
    "for any height.</p>"
)
BANDS_WORDS = (
    "In the picture, each line marks the road at that distance, and its band is where the row lies two "
    "times in three. The strip is the path of a car {width} wide driving straight ahead."
)
TRADE_OFF_WORDS = "These trade off against each other: judge by the distances."


class ResultPanel:
    """The quality in a sentence, the troubles with their mends, and the parameters with their uncertainty."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._heading = gui.add_html("")
        self._quality = gui.add_html("")
        self._troubles = TroublePanel(gui, desk)
        self._numbers = gui.add_html("")

    def show(self, state: SessionState) -> None:
        """Show the result of a moment of the session, or the last good one."""
        marks = {Status.GOOD: "done", Status.DOUBTFUL: "done", Status.IMPLAUSIBLE: "now"}
        set_html(self._heading, step_heading(5, "Result", marks.get(state.solution.status, "")))
        set_html(self._quality, text_block(_quality_html(state)))
        self._troubles.show(state)
        set_html(self._numbers, text_block("" if state.shown is None else _numbers_html(state, state.shown)))


def _quality_html(state: SessionState) -> str:
    if state.shown is None:
        return FIRST_WORDS
    quality = f'<p class="fcw-quality">{escape(state.shown.quality)}</p>'
    return quality if state.current else card(f"<p>{STALE_WORDS}</p>{quality}", "stale")


def _numbers_html(state: SessionState, result: Result) -> str:
    camera, sigmas, turned = result.calibration.camera, result.sigmas, result.calibration.orientation
    # d(angle)/d(f) of angle = 2 atan(half width / f)
    half_width_px = result.calibration.image_size.width / 2
    angle_per_px = 2 * half_width_px / (camera.focal_y_px**2 + half_width_px**2)
    angle_sigma_deg = math.degrees(angle_per_px * sigmas.focal_y_px)
    numbers = (
        ("Pitch, down", math.degrees(camera.pitch_rad), math.degrees(sigmas.pitch_rad), "°"),
        ("Focal length", camera.focal_y_px, sigmas.focal_y_px, " px"),
        ("Field of view", math.degrees(result.calibration.field_of_view_rad), angle_sigma_deg, "°"),
        ("Yaw, left", math.degrees(turned.yaw_rad), math.degrees(turned.yaw_sigma_rad), "°"),
        ("Roll, right", math.degrees(turned.roll_rad), math.degrees(turned.roll_sigma_rad), "°"),
        ("Lens axis, row", camera.principal_row_px, sigmas.principal_row_px, ""),
        ("Horizon, row", camera.horizon_row_px, sigmas.horizon_row_px, ""),
    )
    if state.current and state.solution.height_assumed:
        # The others are those of the height that was assumed, which nobody said.
        numbers = numbers[-1:]
    cells = "".join(
        f"<div><span>{name}</span>{plus_minus(value, sigma)}{unit}</div>"
        for name, value, sigma, unit in numbers
    )
    stale = "" if state.current else " fcw-stale"
    words = f'<p class="dim">{TRADE_OFF_WORDS}</p>' if len(numbers) > 1 else UNTOLD_WORDS
    width = row_distance_text(OWN_CAR_SIZE_M[1], state.document.imperial)
    bands = f'<p class="dim">{BANDS_WORDS.format(width=width)}</p>'
    return f'<div class="fcw-numbers{stale}">{cells}</div>{words}{bands}'


def plus_minus(value: float, sigma: float) -> str:
    """A value with its standard deviation, and no digit that that does not carry."""
    decimals = 0 if sigma >= 10 else 1 if sigma >= 1 else 2
    return f"{rounded(value, decimals):.{decimals}f} ± {sigma:.{decimals}f}"


def rounded(value: float, decimals: int) -> float:
    """Rounded, and never to a zero with a minus."""
    return round(value, decimals) + 0.0
