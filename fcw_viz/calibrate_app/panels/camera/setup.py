"""Step 3 of the job: the height of the camera, and where distances start."""

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import SetHeight, SetReference, SetUnits
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.height import MEASURED_SIGMA_M, TYPICAL_HEIGHTS
from fcw_viz.calibrate_app.document.ways.ways import Part, chosen_way
from fcw_viz.calibrate_app.quantities import HEIGHT, LENGTH_ERROR, OFFSET
from fcw_viz.page.controls import on_choice
from fcw_viz.page.style import set_html, step_heading, text_block

CAMERA, BUMPER = "the camera", "the front bumper"
METRES, FEET = "metres", "feet"
MEASURED = "I measured it"
HEIGHT_WORDS = "From the road to the lens. It sets pitch and the sizes of vehicles, not distances."
SCALE_WORDS = "From the road to the lens. Without measured points, every distance is proportional to it."
SIZED_WORDS = (
    "From the road to the lens. It follows from the rest; measuring it makes all distances more accurate."
)
BUMPER_WORDS = '<p class="dim">How far the front bumper is ahead of the lens.</p>'


class SetupPanel:
    """Height, reference and units."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._heading = gui.add_html("")
        self._typical = gui.add_dropdown(
            "Vehicle",
            (MEASURED, *(typical.name for typical in TYPICAL_HEIGHTS)),
            hint="If you cannot measure: the usual height in that kind of vehicle, with a wider interval",
        )
        self._height = desk.fields.add(gui, "Camera height", HEIGHT, self._height_typed)
        self._sigma = desk.fields.add(
            gui,
            "Height ±",
            LENGTH_ERROR,
            self._sigma_typed,
            hint="Uncertainty, as a standard deviation",
        )
        self._height_words = gui.add_html("")
        self._reference = gui.add_dropdown(
            "Measured from", (CAMERA, BUMPER), hint="Where the distances that you type start"
        )
        self._bumper_words = gui.add_html(text_block(BUMPER_WORDS), visible=False)
        self._offset = desk.fields.add(
            gui, "Bumper ahead", OFFSET, lambda offset_m: desk.offer(SetReference(True, offset_m))
        )
        self._units = gui.add_dropdown("Units", (METRES, FEET))

        on_choice(self._typical, desk.run, self._take_typical)
        on_choice(self._reference, desk.run, self._measured_from)
        on_choice(self._units, desk.run, lambda units: desk.apply(SetUnits(units == FEET)))

    def show(self, state: SessionState) -> None:
        """Bring the fields to a moment of the session."""
        document = state.document
        unit = 1 / FEET_PER_METRE if document.imperial else 1.0
        unit_name = "ft" if document.imperial else "m"
        way = chosen_way(document)
        height_said = document.height_m is not None or document.has_size
        said = height_said and document.reference_offset_m is not None
        set_html(self._heading, step_heading(3, "Camera", "done" if said else "now" if way else ""))
        scales = _height_scales(document)
        words = SIZED_WORDS if document.has_size else SCALE_WORDS if scales else HEIGHT_WORDS
        set_html(self._height_words, text_block(f'<p class="dim">{words}</p>'))
        self._height.handle.label = f"Camera height, {unit_name}"
        self._height.show(document.height_m, unit)
        self._sigma.visible = document.height_sigma_m is not None
        self._sigma.handle.label = f"Height ±, {unit_name}"
        self._sigma.show(document.height_sigma_m, unit)
        self._typical.visible = scales
        self._typical.value = next(
            (
                typical.name
                for typical in TYPICAL_HEIGHTS
                if (typical.height_m, typical.sigma_m) == (document.height_m, document.height_sigma_m)
            ),
            MEASURED,
        )
        self._reference.value = BUMPER if document.from_bumper else CAMERA
        self._bumper_words.visible = self._offset.visible = document.from_bumper
        self._offset.handle.label = f"Bumper ahead, {unit_name}"
        self._offset.show(document.bumper_offset_m, unit)
        self._units.value = FEET if document.imperial else METRES

    def _height_typed(self, height_m: float | None) -> None:
        scales = height_m is not None and _height_scales(self._desk.state.document)
        self._desk.offer(SetHeight(height_m, MEASURED_SIGMA_M if scales else None))

    def _sigma_typed(self, sigma_m: float | None) -> None:
        self._desk.offer(SetHeight(self._desk.state.document.height_m, sigma_m or MEASURED_SIGMA_M))

    def _take_typical(self, name: str) -> None:
        typical = next((typical for typical in TYPICAL_HEIGHTS if typical.name == name), None)
        if typical is not None:
            self._desk.apply(SetHeight(typical.height_m, typical.sigma_m))
        else:
            self._desk.apply(SetHeight(None))

    def _measured_from(self, reference: str) -> None:
        offset_m = self._desk.state.document.bumper_offset_m
        self._desk.apply(SetReference(reference == BUMPER, offset_m))


def _height_scales(document: Document) -> bool:
    """Whether distances follow from the height, so that its error counts."""
    way = chosen_way(document)
    return document.paced or (way is not None and (Part.LENS in way.parts or Part.RECTANGLE in way.parts))
