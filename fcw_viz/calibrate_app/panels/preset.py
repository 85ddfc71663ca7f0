"""The distances that come with a way: a choice that gives the points to come theirs."""

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import PlanDistances
from fcw_viz.calibrate_app.document.numbers_text import in_units, unit_name
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.presets import Preset, SpacedPreset
from fcw_viz.calibrate_app.document.ways.ways import Part, chosen_way
from fcw_viz.calibrate_app.quantities import DISTANCE
from fcw_viz.page.controls import on_choice
from fcw_viz.page.style import set_html, text_block

OWN_DISTANCES = "Marks at distances I know"


class PresetPanel:
    """The list, what to do with the choice, and for evenly spaced marks the distance of the first one."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._chosen: Preset | SpacedPreset | None = None
        self._first_m: float | None = None
        self._presets: dict[str, Preset | SpacedPreset] = {}
        self._list: viser.GuiDropdownHandle[str] = gui.add_dropdown("Distances", [str(OWN_DISTANCES)])
        self._words = gui.add_html("")
        self._first = desk.fields.add(
            gui,
            "First mark at",
            DISTANCE,
            self._plan_from,
            hint="Distance of the near end of the first one, measured",
        )
        on_choice(self._list, desk.run, self._choose)

    def show(self, state: SessionState) -> None:
        """Say what to do with the choice."""
        imperial = state.document.imperial
        self._offer(state.document)
        self._first.visible = isinstance(self._chosen, SpacedPreset)
        self._first.handle.label = f"First mark at, {unit_name(imperial)}"
        self._first.show(self._first_m, 1 / FEET_PER_METRE if imperial else 1.0)
        way = chosen_way(state.document)
        needed = way is None or Part.POINTS in way.parts
        words = own_words(imperial) if needed and not state.document.marks else ""
        if self._chosen is not None:
            words = self._chosen.instruction
        planned = [f"{in_units(distance_m, imperial):.4g}" for distance_m in state.document.planned_m]
        if planned:
            words += f" Clicks get {', '.join(planned)} {unit_name(imperial)} in turn."
        set_html(self._words, text_block(f"<p class='dim'>{words.strip()}</p>") if words else "")

    def _offer(self, document: Document) -> None:
        """Those of the way."""
        way = chosen_way(document)
        presets = {preset.name: preset for preset in (way.presets if way else ())}
        self._list.visible = bool(presets)
        if presets.keys() == self._presets.keys():
            return
        self._presets = presets
        if self._chosen is not None and self._chosen.name not in presets:
            self._chosen = self._first_m = None
        self._list.options = (OWN_DISTANCES, *presets)
        self._list.value = OWN_DISTANCES if self._chosen is None else self._chosen.name

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
            self._desk.offer(PlanDistances(planned_m))
            self._first_m = first_m


def own_words(imperial: bool) -> str:
    """What to do with marks at any distance."""
    return (
        "Click three marks on the road whose distance you know, and type each distance. One of them should "
        f"be far away, {'65 ft' if imperial else '20 m'} or more: near ones alone leave far distances open."
    )
