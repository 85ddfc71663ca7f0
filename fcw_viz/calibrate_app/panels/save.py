"""Step 6 of the job: the calibration file, what to type next, and the other forms of it."""

from datetime import datetime
from functools import partial
from html import escape
from pathlib import Path
from shlex import quote

import viser

from fcw.camera.export import ExportFormat, export_text
from fcw.camera.file import calibration_text, default_path
from fcw.errors import UserError
from fcw.versions import versions
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.state import Result, SessionState, Status
from fcw_viz.calibrate_app.report import report_html
from fcw_viz.page.controls import on_button, on_press
from fcw_viz.page.style import card, set_html, step_heading, text_block

SAVE_COLOR = (47, 158, 68)
FILE, REPORT, ROS, KALIBR = "↓ YAML", "↓ Report", "↓ camera_info", "↓ Kalibr"
EXPORT_FORMATS: dict[str, ExportFormat] = {ROS: "camera_info", KALIBR: "kalibr"}
ANEW = "Start over"
EXACT_HEIGHTS, EXACT_PART = 0.05, 0.05
"""An axis known to so many picture heights and a focal length to such a part may be handed on as they are."""


class SavePanel:
    """The button that saves, with the reason where it cannot; downloads."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._heading = gui.add_html("")
        self._button = gui.add_button("Save", color=SAVE_COLOR, icon=viser.Icon.DEVICE_FLOPPY, disabled=True)
        self._words = gui.add_html("")
        self._downloads = gui.add_button_group("", (FILE, REPORT, ROS, KALIBR), visible=False)
        self._export_words = gui.add_html("")
        self._anew = gui.add_button_group("", (ANEW,))

        on_button(self._button, desk.run, desk.save)
        on_press(
            self._downloads,
            desk.run,
            {kind: partial(self._download, kind) for kind in (FILE, REPORT, ROS, KALIBR)},
        )
        on_press(self._anew, desk.run, {ANEW: desk.start_anew})

    def show(self, state: SessionState) -> None:
        """Bring the step to a moment of the session."""
        can_save = state.solution.can_save
        mark = "done" if state.saved else "now" if can_save else ""
        note = "saved" if state.saved else "not saved yet"
        set_html(self._heading, step_heading(6, "Save", mark, note))
        self._button.label = "Saved" if state.saved else f"Save {state.save_path.name}"
        self._button.disabled = state.saved or not can_save
        self._downloads.visible = can_save
        result = state.solution.result
        doubt = "" if result is None or not can_save else export_doubt(result)
        set_html(self._export_words, text_block(f'<p class="dim">{doubt}</p>') if doubt else "")
        set_html(self._words, text_block(self._words_html(state)))

    def _words_html(self, state: SessionState) -> str:
        command = f"fcw run {quote(str(self._desk.source))}{_flag(self._desk.source, state.save_path)}"
        if state.saved:
            return f"<p>Next, type <code>{escape(command)}</code></p>"
        if state.solution.status is Status.DEGENERATE:
            return card("<p>Cannot be saved: no camera fits these points.</p>")
        if not state.solution.can_save:
            return f'<p class="dim">Not yet: {escape(state.solution.hint)}</p>'
        warning = "The saved calibration will include the warning above." if state.solution.warnings else ""
        return f'<p class="dim">Your work is kept at every step, saved or not. {warning}</p>'

    def _download(self, kind: str) -> None:
        desk = self._desk
        result = desk.state.solution.result
        if result is None or not desk.state.solution.can_save:
            raise UserError(f"nothing to download yet: {desk.state.solution.hint}")
        stem = desk.source.stem if desk.source.is_file() else desk.source.resolve().name
        if kind == FILE:
            warnings = desk.state.solution.warnings
            name, text = desk.state.save_path.name, calibration_text(result.calibration, warnings)
        elif kind == REPORT:
            name, text = f"{stem}.calibration.html", self._report()
        else:
            export_format = EXPORT_FORMATS[kind]
            name, text = f"{stem}.{export_format}.yaml", export_text(result.calibration, export_format)
        desk.client.send_file_download(name, text.encode(), save_immediately=True)

    def _report(self) -> str:
        """The report, with the picture of this desk."""
        desk = self._desk
        image = desk.pictures.read(desk.frame_index).image
        today = datetime.now().astimezone().date()
        return report_html(desk.state, image, desk.frame_index, str(desk.source), today, versions())


def export_doubt(result: Result) -> str:
    """What the formats of others cannot say of a lens that the points leave open; empty where it is known."""
    calibration, sigmas = result.calibration, result.sigmas
    focal_part = sigmas.focal_y_px / calibration.camera.focal_y_px
    if sigmas.principal_row_px < EXACT_HEIGHTS * calibration.image_size.height and focal_part < EXACT_PART:
        return ""
    return (
        "camera_info and Kalibr cannot express uncertainty. They would state this lens as exact, but it "
        f"is known only to ± {sigmas.focal_y_px:.0f} px in focal length and ± "
        f"{sigmas.principal_row_px:.0f} rows in its axis: first type what you know of the lens, or import "
        "its file (`fcw calibrate PICTURES --chessboard 9x6`)."
    )


def _flag(source: Path, save_path: Path) -> str:
    """What `fcw run` needs to find the file; nothing where it looks for it by itself."""
    return "" if save_path == default_path(source) else f" --calibration {quote(str(save_path))}"
