"""Step 2 of the job where somebody has a rectangle on the road: its corners and its sides."""

from functools import partial
from html import escape

import numpy as np
import viser

from fcw.camera.calibration import Calibration, Gaussian, GroundRectangle
from fcw.camera.joint.rectangle import CORNERS
from fcw.camera.prior_sigmas import SIDE_SIGMA_M
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.joint_fit import sides_are_exchanged
from fcw_viz.calibrate_app.document.besides.rectangles import AddCorner, RemoveRectangle, SetAlong, SetSides
from fcw_viz.calibrate_app.document.numbers_text import in_units, unit_name
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.presets import RECTANGLE_PRESETS, RectanglePreset
from fcw_viz.calibrate_app.document.ways.ways import RECTANGLE, chosen_way
from fcw_viz.calibrate_app.fields import NumberField
from fcw_viz.calibrate_app.quantities import LENGTH_ERROR, SIDE
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.controls import on_choice, on_press
from fcw_viz.page.style import set_html, step_heading, text_block

TITLE = "Rectangle on the road"
MEASURED = "I measured it"
ANOTHER, REMOVE = "Add another", "Remove rectangle"
CORNER_WORDS = (
    "Click the four corners in turn, each at the same edge of the paint, for example of a parking bay or "
    "a field of a crossing. The larger and nearer, the better."
)
SIDE_WORDS = "One side is enough. Without any, the camera height sets the scale."
SIDE_NAMES = ("Side 1–2", "Side 2–3")
ALONG = "Aligned with road"
ALONG_HINT = (
    "Its sides lie along and across the direction of travel, as those of a crossing do. This gives the yaw"
)


class RectanglePanel:
    """What to click, the sides of the rectangle clicked last, and what the calibration makes of them."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._corners_were_missing = False
        self._heading = gui.add_html("")
        self._words = gui.add_html("")
        self._kind = gui.add_dropdown(
            "Size from",
            (MEASURED, *(preset.name for preset in RECTANGLE_PRESETS)),
            hint=(
                "The size by a country's rule, if you cannot measure it; allows for how exactly it is painted"
            ),
        )
        self._sides: list[NumberField] = []
        self._sigmas: list[NumberField] = []
        for k, name in enumerate(SIDE_NAMES):
            self._sides.append(desk.fields.add(gui, name, SIDE, partial(self._typed, k)))
            hint = "Uncertainty, as a standard deviation"
            self._sigmas.append(desk.fields.add(gui, "±", LENGTH_ERROR, partial(self._sigma_typed, k), hint))
        self._along = gui.add_checkbox(ALONG, False, hint=ALONG_HINT)
        self._found = gui.add_html("")
        self._actions = gui.add_button_group("", (ANOTHER, REMOVE))
        on_choice(self._kind, desk.run, self._take_kind)
        on_choice(self._along, desk.run, lambda along: desk.apply(SetAlong(self._index, along)))
        on_press(self._actions, desk.run, {ANOTHER: self._another, REMOVE: self._remove})

    @property
    def _index(self) -> int:
        return len(self._desk.state.document.rectangles) - 1

    @property
    def _last(self) -> GroundRectangle | None:
        rectangles = self._desk.state.document.rectangles
        return rectangles[-1] if rectangles else None

    def show(self, state: SessionState) -> None:
        """Bring it to a moment of the session."""
        document, last = state.document, self._last
        way = chosen_way(document)
        chosen = way is not None and way.key == RECTANGLE
        clicked = 0 if last is None else len(last.corners_px)
        whole, shown = clicked == CORNERS, chosen or last is not None
        note = f"{len(document.rectangles)} rectangles" if len(document.rectangles) > 1 else ""
        note = note if whole else f"{clicked} of {CORNERS} corners"
        heading = step_heading(2, TITLE, "done" if whole else "now", note)
        set_html(self._heading, heading if shown else "")
        self._corners_were_missing |= not whole
        # The fields of the sides appear above what a low window shows. A page that opens with them stays at
        # its top.
        words = (
            f'<p class="dim"{" data-fcw-seen" * self._corners_were_missing}>{SIDE_WORDS}</p>'
            if whole
            else f'<p class="dim">{CORNER_WORDS}</p>'
        )
        set_html(self._words, text_block(words) if shown else "")
        self._kind.visible = self._along.visible = whole
        self._actions.visible = clicked > 0
        unit = 1 / FEET_PER_METRE if document.imperial else 1.0
        sides = (None, None) if last is None else last.sides_m
        for name, side, field, sigma in zip(SIDE_NAMES, sides, self._sides, self._sigmas, strict=True):
            field.visible = whole
            field.handle.label = f"{name}, {unit_name(document.imperial)}"
            field.show(None if side is None else side.value, unit)
            sigma.visible = whole and side is not None
            sigma.handle.label = f"{name} ±"
            sigma.show(None if side is None else side.sigma, unit)
        preset = next((p for p in RECTANGLE_PRESETS if sides in (p.sides_m, p.sides_m[::-1])), None)
        self._kind.value = MEASURED if preset is None else preset.name
        self._along.value = last is not None and last.along
        found = ""
        if whole and last is not None and state.current and state.shown is not None:
            found = found_words(state.shown.calibration, last, document.imperial)
        set_html(self._found, text_block(f'<p class="dim">{escape(found)}</p>') if found else "")

    def _typed(self, side: int, value_m: float | None) -> None:
        if self._last is None:
            return
        sides = list(self._last.sides_m)
        before = sides[side]
        sigma_m = SIDE_SIGMA_M if before is None else before.sigma
        sides[side] = None if value_m is None else Gaussian(value_m, sigma_m)
        self._desk.offer(SetSides(self._index, sides[0], sides[1]))

    def _sigma_typed(self, side: int, sigma_m: float | None) -> None:
        if self._last is None:
            return
        sides = list(self._last.sides_m)
        before = sides[side]
        if before is not None:
            sides[side] = Gaussian(before.value, sigma_m or SIDE_SIGMA_M)
            self._desk.offer(SetSides(self._index, sides[0], sides[1]))

    def _take_kind(self, name: str) -> None:
        """The sides of a standard, whichever way round its corners were clicked."""
        preset: RectanglePreset | None = next((p for p in RECTANGLE_PRESETS if p.name == name), None)
        if preset is None:
            self._desk.apply(SetSides(self._index, None, None))
            return
        edit = SetSides(self._index, *preset.sides_m)
        if sides_are_exchanged(edit.apply(self._desk.state.document), self._index):
            edit = SetSides(self._index, *reversed(preset.sides_m))
        self._desk.apply(edit)

    def _another(self) -> None:
        """The next four clicks are its corners, whatever else a click would do."""

        def clicked(column_px: float, row_px: float) -> None:
            if not self._desk.apply(AddCorner(column_px, row_px)):
                return
            if len(self._desk.session.state.document.rectangles[-1].corners_px) == CORNERS:
                self._desk.use(Tool.POINTS)

        self._desk.use(Tool.CORNERS, clicked, CORNER_WORDS)

    def _remove(self) -> None:
        self._desk.apply(RemoveRectangle(self._index))


def found_words(calibration: Calibration, rectangle: GroundRectangle, imperial: bool) -> str:
    """The sides and the camera's height as they come out."""
    places = np.array([calibration.straight_place(*corner) for corner in rectangle.corners_px])
    ground = np.column_stack(
        (calibration.camera.distance_at(places[:, 1]), calibration.lateral_at(places[:, 0], places[:, 1]))
    )
    if not np.isfinite(ground).all():
        return ""
    lengths_m = np.linalg.norm(np.roll(ground, -1, axis=0) - ground, axis=1)
    first, second = (in_units(float(lengths_m[[k, k + 2]].mean()), imperial) for k in (0, 1))
    height, unit = in_units(calibration.camera.height_m, imperial), unit_name(imperial)
    return f"Result: {first:.2f} by {second:.2f} {unit}, camera height {height:.2f} {unit}."
