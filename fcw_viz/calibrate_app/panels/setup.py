"""Step 3 of the job: the height of the camera, and where distances start."""

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.edits import SetHeight, SetReference, SetUnits
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.page.controls import on_choice
from fcw_viz.page.style import set_html, step_heading, text_block

CAMERA, BUMPER = "the camera", "the front bumper"
METRES, FEET = "metres", "feet"
HEIGHT_WORDS = (
    '<p class="dim">From the road to the lens. It sets pitch and the sizes of vehicles, not distances.</p>'
)
BUMPER_WORDS = '<p class="dim">How far the front bumper is ahead of the lens.</p>'


class SetupPanel:
    """Height, reference and units."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._heading = gui.add_html("")
        self._height = desk.fields.add(gui, "Camera height", lambda height_m: desk.apply(SetHeight(height_m)))
        gui.add_html(text_block(HEIGHT_WORDS))
        self._reference = gui.add_dropdown(
            "Measured from", (CAMERA, BUMPER), hint="Where the distances that you typed start"
        )
        self._bumper_words = gui.add_html(text_block(BUMPER_WORDS), visible=False)
        self._offset = desk.fields.add(
            gui, "Bumper ahead", lambda offset_m: desk.apply(SetReference(True, offset_m))
        )
        self._units = gui.add_dropdown("Units", (METRES, FEET))
        self._desk = desk

        on_choice(self._reference, desk.run, self._measured_from)
        on_choice(self._units, desk.run, lambda units: desk.apply(SetUnits(units == FEET)))

    def show(self, state: SessionState) -> None:
        """Bring the fields to a moment of the session."""
        document = state.document
        unit = 1 / FEET_PER_METRE if document.imperial else 1.0
        said = document.height_m is not None and document.reference_offset_m is not None
        set_html(
            self._heading, step_heading(3, "Camera", "done" if said else "now" if document.marks else "")
        )
        unit_name = "ft" if document.imperial else "m"
        self._height.handle.label = f"Camera height, {unit_name}"
        self._height.show(document.height_m, unit)
        self._reference.value = BUMPER if document.from_bumper else CAMERA
        self._bumper_words.visible = self._offset.handle.visible = document.from_bumper
        self._offset.handle.label = f"Bumper ahead, {unit_name}"
        self._offset.show(document.bumper_offset_m, unit)
        self._units.value = FEET if document.imperial else METRES

    def _measured_from(self, reference: str) -> None:
        offset_m = self._desk.state.document.bumper_offset_m
        self._desk.apply(SetReference(reference == BUMPER, offset_m))
