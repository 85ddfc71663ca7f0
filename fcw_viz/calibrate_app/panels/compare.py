"""Two calibrations side by side: rows, what one reads where the other says so, which fits the vehicles."""

import math
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
import viser

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.camera.joint.evidence import Ruler
from fcw.camera.joint.widths import fit_of_widths
from fcw.camera.straight import LEVEL
from fcw.errors import UserError
from fcw.sources.bars import for_pictures
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.joint_fit import FEWEST_VEHICLES
from fcw_viz.calibrate_app.document.numbers_text import in_units, row_distance_text, unit_name
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.panels.camera.besides import LOOKING_WORDS
from fcw_viz.calibrate_app.panels.result import plus_minus
from fcw_viz.page.controls import on_button, on_choice
from fcw_viz.page.style import set_html, text_block

NOTHING = "nothing"
COMPARED_M = np.array([10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 80.0])
FILES = "*.calibration.yaml"
JUDGE = "Judge by the vehicles in the drive"
TOO_FEW_WORDS = f"The drive shows fewer than the {FEWEST_VEHICLES} vehicles needed to judge."
CLEAR_COST, ANY_COST = 6.0, 2.0
"""One calibration fits vehicles clearly better where they are twenty times as likely by it; less than e times
is nothing."""


class ComparePanel:
    """A list of the calibration files beside the drive, and a table against the one chosen."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._chosen = NOTHING
        self._list: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Compare with", [str(NOTHING)], hint="A calibration file in the folder of this one"
        )
        self._table = gui.add_html("")
        self._judge = gui.add_button(JUDGE, color="gray", icon=viser.Icon.CAR, visible=False)
        on_choice(self._list, desk.run, self._choose)
        on_button(self._judge, desk.run, desk.looks.vehicles.start)

    def show(self, state: SessionState) -> None:
        """Bring the table to a moment of the session."""
        names = (NOTHING, *sorted(path.name for path in state.save_path.parent.glob(FILES)))
        if self._chosen not in names:
            self._chosen = NOTHING
        if tuple(self._list.options) != names:
            self._list.options = names
            self._list.value = self._chosen
        look = self._desk.looks.vehicles
        compares = self._chosen != NOTHING and state.shown is not None
        unseen = look.look is None and not look.running and not state.document.vehicles
        self._judge.visible = compares and unseen and self._desk.pictures.count > 1
        set_html(self._table, text_block(self._html(state)))

    def _choose(self, name: str) -> None:
        self._chosen = name
        self._desk.refresh()

    def _html(self, state: SessionState) -> str:
        if self._chosen == NOTHING:
            return ""
        if state.shown is None:
            return '<p class="dim">Appears with the first result.</p>'
        path = state.save_path.parent / self._chosen
        try:
            other = for_pictures(read_calibration(path), self._desk.pictures.source)
        except UserError as error:
            return f'<p class="fcw-wrong" role="alert">{escape(str(error))}</p>'
        here, look = state.shown.calibration, self._desk.looks.vehicles
        words = LOOKING_WORDS if look.running else "" if look.look is None else TOO_FEW_WORDS
        rulers = state.document.vehicles or (() if look.look is None else look.look.vehicles)
        if rulers:
            words = vehicles_words(here, other, rulers, taken=bool(state.document.vehicles))
        judged = f"<p>{escape(words)}</p>" if words else ""
        return comparison_html(here, other, path, state.document.imperial) + judged


def comparison_html(here: Calibration, there: Calibration, path: Path, imperial: bool) -> str:
    """The table, and the cameras in a line each."""
    unit = unit_name(imperial)
    lines = [
        f"<tr><th>{unit}</th><th>row here</th><th>row there</th><th>reads there</th><th></th></tr>",
        *(_line(here, there, float(distance_m), imperial) for distance_m in COMPARED_M),
    ]
    cameras = "<br>".join(
        f"{name}: {camera_words(calibration, imperial)}."
        for name, calibration in (("Here", here), ("There", there))
    )
    return (
        f"<table>{''.join(lines)}</table><p class='dim'>Distances are from the reference here; “there” is "
        f"{escape(path.name)}.</p><p>{cameras}</p>"
    )


def vehicles_words(here: Calibration, there: Calibration, rulers: Sequence[Ruler], taken: bool) -> str:
    """Which of the two has the vehicles of the drive as wide as vehicles are, near and far.

    Args:
        here: the calibration of the page.
        there: the other one.
        rulers: the vehicles.
        taken: whether they are part of the fit here, so that they judge in their own cause.
    """
    by_here, by_there = fit_of_widths(here, rulers), fit_of_widths(there, rulers)
    gain = by_there.cost - by_here.cost
    better = "here" if gain > 0 else "there"
    verdict = f"they fit {'clearly ' * (abs(gain) > CLEAR_COST)}better {better}"
    if abs(gain) < ANY_COST:
        verdict = "they fit both equally well"
    parts = "; ".join(
        f"{name} they come out {by.scale - 1:+.0%} wide"
        for name, by in (("here", by_here), ("there", by_there))
    )
    own = " They are part of the fit here." if taken else ""
    return f"{len(rulers)} vehicles of the drive, by their widths near and far: {verdict} ({parts}).{own}"


def read_there(here: Calibration, there: Calibration, distance_m: float) -> float:
    """What the other one reads at the row of a distance here, from the reference here; inf for sky."""
    from_camera_m = there.distance_at(here.row_at(distance_m)) + there.reference_offset_m
    return from_camera_m - here.reference_offset_m


def camera_words(calibration: Calibration, imperial: bool) -> str:
    """Pitch, yaw and roll where the file says them, field of view, horizon and height in one line."""
    camera, turned = calibration.camera, calibration.orientation
    aside = ""
    if turned != LEVEL:
        aside = (
            f"yaw {_degrees(turned.yaw_rad, turned.yaw_sigma_rad)} to the left, "
            f"roll {_degrees(turned.roll_rad, turned.roll_sigma_rad)} to the right, "
        )
    return (
        f"pitch {math.degrees(camera.pitch_rad):.1f}°, {aside}field of view "
        f"{math.degrees(calibration.field_of_view_rad):.0f}°, horizon at row {camera.horizon_row_px:.0f}, "
        f"height {in_units(camera.height_m, imperial):.2f} {unit_name(imperial)}"
    )


def _degrees(angle_rad: float, sigma_rad: float) -> str:
    return f"{plus_minus(math.degrees(angle_rad), math.degrees(sigma_rad))}°"


def _line(here: Calibration, there: Calibration, distance_m: float, imperial: bool) -> str:
    other_m = read_there(here, there, distance_m)
    row_there_px = there.row_at(distance_m + here.reference_offset_m - there.reference_offset_m)
    sky = not math.isfinite(other_m)
    reads = "sky" if sky else f"{in_units(other_m, imperial):.1f}"
    change = "" if sky else f"{other_m / distance_m - 1:+.1%}"
    return (
        f"<tr><td>{row_distance_text(distance_m, imperial)}</td><td>{here.row_at(distance_m):.1f}</td>"
        f"<td>{row_there_px:.1f}</td><td>{reads}</td><td>{change}</td></tr>"
    )
