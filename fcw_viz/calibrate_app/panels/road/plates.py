"""Step 2 of the job where somebody has number plates: how many are clicked, and how wide they are."""

import viser

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.plates import PLATE_SIGMA_M
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.plates import RemovePlate, SetPlateWidth
from fcw_viz.calibrate_app.document.document import FEWEST_PLATES
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.presets import PLATE_PRESETS
from fcw_viz.calibrate_app.document.ways.ways import PLATES, chosen_way
from fcw_viz.calibrate_app.quantities import PLATE_WIDTH
from fcw_viz.page.controls import on_choice, on_press
from fcw_viz.page.style import set_html, step_heading, text_block

TITLE = "Number plates"
OTHER, REMOVE = "Other width", "Remove the last"
WORDS = (
    "On a vehicle seen from straight behind, click both ends of its plate, then where a rear tyre meets "
    "the road. Zoom in: plates are small. Use near and far vehicles, also from several pictures of the "
    "clip."
)


class PlatesPanel:
    """What to click, and the width of the plates."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._heading = gui.add_html("")
        self._words = gui.add_html("")
        self._country = gui.add_dropdown("Country", (*PLATE_PRESETS, OTHER))
        self._width = desk.fields.add(gui, "Plate width, m", PLATE_WIDTH, self._width_typed)
        self._actions = gui.add_button_group("", (REMOVE,))
        on_choice(self._country, desk.run, self._take_country)
        on_press(self._actions, desk.run, {REMOVE: lambda: desk.apply(RemovePlate())})

    def show(self, state: SessionState) -> None:
        """Bring it to a moment of the session."""
        document = state.document
        way = chosen_way(document)
        shown = (way is not None and way.key == PLATES) or bool(document.plates)
        whole = len(document.whole_plates)
        note = f"{whole} clicked" if whole >= FEWEST_PLATES else f"{whole} of at least {FEWEST_PLATES}"
        mark = "done" if whole >= FEWEST_PLATES and document.plates == document.whole_plates else "now"
        set_html(self._heading, step_heading(2, TITLE, mark, note) if shown else "")
        set_html(self._words, text_block(f'<p class="dim">{WORDS}</p>') if shown else "")
        self._country.visible = self._width.visible = shown
        self._actions.visible = bool(document.plates)
        countries = (
            name for name, width_m in PLATE_PRESETS.items() if width_m == document.plate_width_m.value
        )
        self._country.value = next(countries, OTHER)
        self._width.show(document.plate_width_m.value)

    def _width_typed(self, width_m: float | None) -> None:
        if width_m is not None:
            self._desk.offer(SetPlateWidth(Gaussian(width_m, PLATE_SIGMA_M)))

    def _take_country(self, name: str) -> None:
        if name in PLATE_PRESETS:
            self._desk.apply(SetPlateWidth(Gaussian(PLATE_PRESETS[name], PLATE_SIGMA_M)))
