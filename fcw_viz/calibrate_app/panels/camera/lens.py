"""Step 4 of the job: what is known of the lens, and where the horizon is."""

import math
from html import escape

import viser

from fcw.camera.calibration import Gaussian
from fcw.camera.prior_sigmas import (
    FIELD_OF_VIEW_SIGMA_DEG,
    HORIZON_ROW_SIGMA_PX,
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
)
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.edits import SetFieldOfView, SetHorizon, SetPrincipalRow
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.ways import TYPICAL_LENSES, Part, chosen_way
from fcw_viz.calibrate_app.panels.camera.belief import BeliefControls, BeliefKind
from fcw_viz.calibrate_app.panels.camera.besides import BesidesPanel
from fcw_viz.calibrate_app.panels.camera.horizon import HorizonPanel
from fcw_viz.calibrate_app.quantities import ANGLE_ERROR, FIELD_OF_VIEW, ROW, ROW_ERROR
from fcw_viz.page.controls import on_button, on_choice
from fcw_viz.page.style import set_html, step_heading, text_block

FIRST_WORDS = '<p class="dim">Each of these makes far distances more accurate, or replaces a point.</p>'
DATA_SHEET = "From its data sheet"
FIND_VIEW, TAKE_VIEW = "Find the field of view from turns", "Use this field of view"
LOOKING_WORDS = "Analysing the drive's turns: {} pictures so far."


class LensPanel:
    """The field of view, the horizon and the lens's axis; folded where the way does not need them."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        height_px = desk.pictures.image_size.height
        self._heading = gui.add_html("")
        self._more = gui.add_checkbox("More inputs", False, hint="Lens, horizon, lane lines and more")
        self._opened: bool | None = None
        self._folder = gui.add_folder(None)
        with self._folder:
            self._words = gui.add_html("")
            self._typical = gui.add_dropdown(
                "Kind of camera",
                (DATA_SHEET, *(typical.name for typical in TYPICAL_LENSES)),
                hint=(
                    "If you have no data sheet: the usual view of that kind of camera, with a wider interval"
                ),
            )
            self._view = BeliefControls(
                gui,
                desk,
                BeliefKind(
                    "field_of_view",
                    "Field of view, °",
                    "Horizontal, of the whole picture, as in the lens's data sheet",
                    FIELD_OF_VIEW,
                    ANGLE_ERROR,
                    math.radians(1),
                    math.radians(FIELD_OF_VIEW_SIGMA_DEG),
                    SetFieldOfView,
                ),
            )
            several = desk.pictures.count > 1
            self._find_view = gui.add_button(FIND_VIEW, icon=viser.Icon.SEARCH, visible=several)
            self._view_words = gui.add_html("")
            self._horizon = HorizonPanel(gui, desk)
            self._beliefs = [
                BeliefControls(gui, desk, kind)
                for kind in (
                    BeliefKind(
                        "horizon",
                        "Horizon, row",
                        "Where a flat road would end",
                        ROW,
                        ROW_ERROR,
                        1.0,
                        HORIZON_ROW_SIGMA_PX,
                        SetHorizon,
                    ),
                    BeliefKind(
                        "principal_row",
                        "Lens axis, row",
                        f"Row of the optical axis: {(height_px - 1) / 2:g}, unless the picture was cropped",
                        ROW,
                        ROW_ERROR,
                        1.0,
                        PRINCIPAL_ROW_SIGMA_HEIGHTS * height_px,
                        SetPrincipalRow,
                    ),
                )
            ]
            self._besides = BesidesPanel(gui, desk)
        on_choice(self._typical, desk.run, self._take_typical)
        on_choice(self._more, desk.run, self._open)
        on_button(self._find_view, desk.run, self._view_pressed)

    def show(self, state: SessionState) -> None:
        """Bring the step to a moment of the session."""
        document = state.document
        way = chosen_way(document)
        needed = way is not None and Part.LENS in way.parts
        said = document.field_of_view is not None and (
            document.horizon is not None or state.solution.lane_horizon is not None
        )
        note = "" if needed else "optional"
        mark = "done" if said else "now" if needed and document.height_m is not None else ""
        set_html(self._heading, step_heading(4, "Lens and horizon", mark, note))
        opened = needed or _anything_said(document) if self._opened is None else self._opened
        self._more.visible = not needed
        self._more.value = opened
        self._folder.visible = opened or needed
        set_html(self._words, "" if needed else text_block(FIRST_WORDS))
        view = None if document.field_of_view is None else document.field_of_view.prior
        self._typical.value = next(
            (lens.name for lens in TYPICAL_LENSES if view == lens.across(document.image_size)),
            DATA_SHEET,
        )
        self._view.show(state)
        self._show_view_look(view)
        self._horizon.show(state)
        for controls in self._beliefs:
            controls.show(state)
        self._besides.show(state)

    def _show_view_look(self, said: Gaussian | None) -> None:
        look = self._desk.looks.view
        found = None if look.look is None else look.look.view_rad
        useful = look.look is None or (found is not None and found != said)
        self._find_view.visible = self._desk.pictures.count > 1 and useful
        self._find_view.disabled = look.running
        self._find_view.label = FIND_VIEW if look.look is None else TAKE_VIEW
        words = "" if look.look is None else look.look.words
        if look.running:
            words = LOOKING_WORDS.format(look.picture_count)
        set_html(self._view_words, text_block(f'<p class="dim">{escape(words)}</p>') if words else "")

    def _view_pressed(self) -> None:
        look = self._desk.looks.view
        if look.look is None:
            look.start()
        elif look.look.view_rad is not None:
            self._desk.apply(SetFieldOfView(Belief(look.look.view_rad)))

    def _open(self, opened: bool) -> None:
        self._opened = opened
        self._desk.refresh()

    def _take_typical(self, name: str) -> None:
        lens = next((lens for lens in TYPICAL_LENSES if lens.name == name), None)
        belief = None if lens is None else Belief(lens.across(self._desk.pictures.image_size))
        self._desk.apply(SetFieldOfView(belief))


def _anything_said(document: Document) -> bool:
    beliefs = (document.field_of_view, document.principal_row, document.horizon, *document.lane_lines)
    besides = (document.lens, document.yaw, document.roll, document.lane_width, document.speed)
    told = any(belief is not None for belief in (*beliefs, *besides))
    return told or bool(document.vehicles) or bool(document.edges)
