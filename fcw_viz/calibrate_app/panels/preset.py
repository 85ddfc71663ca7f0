"""What somebody has to measure with: a choice that gives the points to come their distances."""

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.edits import PlanDistances
from fcw_viz.calibrate_app.document.numbers_text import in_units, unit_name
from fcw_viz.calibrate_app.document.presets import PRESETS, SPACED_PRESETS, Preset, SpacedPreset
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.page.controls import on_choice
from fcw_viz.page.style import set_html, text_block

OWN_DISTANCES = "Marks at distances I know"
OWN_WORDS = (
    "Click three marks on the road whose distance you know, and type each distance. One of them should be "
    "far away, 20 m or more: near ones alone leave the far distances open."
)


class PresetPanel:
    """The list, what to do with the choice, and for evenly spaced marks the distance of the first one."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._chosen: Preset | SpacedPreset | None = None
        self._first_m: float | None = None
        self._presets = {preset.name: preset for preset in (*PRESETS, *SPACED_PRESETS)}
        list_ = gui.add_dropdown("You have", (OWN_DISTANCES, *self._presets))
        self._words = gui.add_html("")
        self._first = desk.fields.add(
            gui, "First mark at", self._plan_from, hint="Distance of the near end of the first one, measured"
        )
        on_choice(list_, desk.run, self._choose)

    def show(self, state: SessionState) -> None:
        """Say what to do with the choice."""
        imperial = state.document.imperial
        self._first.handle.visible = isinstance(self._chosen, SpacedPreset)
        self._first.handle.label = f"First mark at, {unit_name(imperial)}"
        self._first.show(self._first_m, 1 / FEET_PER_METRE if imperial else 1.0)
        if self._chosen is None:
            words = OWN_WORDS if not state.document.marks else ""
        else:
            words = self._chosen.instruction
        planned = [f"{in_units(distance_m, imperial):.4g}" for distance_m in state.document.planned_m]
        if planned:
            words += f" Clicks get {', '.join(planned)} {unit_name(imperial)} in turn."
        set_html(self._words, text_block(f"<p class='dim'>{words.strip()}</p>") if words else "")

    def _choose(self, name: str) -> None:
        self._chosen = self._presets.get(name)
        self._first_m = None
        planned_m = self._chosen.distances_m if isinstance(self._chosen, Preset) else ()
        if planned_m != self._desk.state.document.planned_m:
            self._desk.apply(PlanDistances(planned_m))
        self._desk.refresh()

    def _plan_from(self, first_m: float | None) -> None:
        if isinstance(self._chosen, SpacedPreset):
            planned_m = () if first_m is None else self._chosen.starting_at(first_m).distances_m
            self._first_m = first_m
            self._desk.apply(PlanDistances(planned_m))
