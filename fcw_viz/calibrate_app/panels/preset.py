"""The distances that come with a way: a choice that gives the points to come theirs."""

import viser

from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.besides.knowledge import SetPaced
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import PlanDistances, SetDistance
from fcw_viz.calibrate_app.document.numbers_text import in_units, unit_name
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.document.ways.presets import Preset, SpacedPreset, dashes
from fcw_viz.calibrate_app.document.ways.ways import DASHES, Part, chosen_way
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
            hint="Measured distance to the near end of the first one; for dashes, it may stay empty",
        )
        self._period = desk.fields.add(
            gui,
            "Repeat every",
            DISTANCE,
            self._take_period,
            hint="From the near end of one dash to that of the next",
        )
        on_choice(self._list, desk.run, self._choose)

    def show(self, state: SessionState) -> None:
        """Say what to do with the choice."""
        imperial = state.document.imperial
        self._offer(state.document)
        self._first.visible = isinstance(self._chosen, SpacedPreset)
        self._first.handle.label = f"First mark at, {unit_name(imperial)}"
        self._first.show(self._first_m, 1 / FEET_PER_METRE if imperial else 1.0)
        self._period.visible = self._may_pace(state.document)
        self._period.handle.label = f"Repeat every, {unit_name(imperial)}"
        document = state.document
        period_m = self._chosen.spacing_m if isinstance(self._chosen, SpacedPreset) else None
        if period_m is None and document.paced and document.planned_m:
            period_m = document.planned_m[0]
        self._period.show(period_m, 1 / FEET_PER_METRE if imperial else 1.0)
        way = chosen_way(state.document)
        needed = way is None or Part.POINTS in way.parts
        words = own_words(imperial) if needed and not state.document.marks else ""
        if self._chosen is not None:
            words = self._chosen.instruction
        planned = [f"{in_units(distance_m, imperial):.4g}" for distance_m in state.document.planned_m]
        if planned and not state.document.paced:
            words += f" Your clicks get {', '.join(planned)} {unit_name(imperial)} in turn."
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
        self._take(self._presets.get(name))

    def _take(self, chosen: Preset | SpacedPreset | None) -> None:
        self._chosen, self._first_m = chosen, None
        document = self._desk.state.document
        paced = isinstance(chosen, SpacedPreset) and self._may_pace(document)
        planned_m = chosen.distances_m if isinstance(chosen, Preset) else ()
        if paced and isinstance(chosen, SpacedPreset):
            planned_m = chosen.starting_at(chosen.spacing_m).distances_m
        if (planned_m, paced) != (document.planned_m, document.paced):
            self._desk.apply(SetPaced(paced), PlanDistances(planned_m))
        self._desk.refresh()

    def _take_period(self, period_m: float | None) -> None:
        """Dashes of a period that is in no list."""
        self._take(None if period_m is None else dashes("as typed", period_m))

    def _plan_from(self, first_m: float | None) -> None:
        """The first distance known, or not any more: marks that have theirs by the plan move along."""
        document, chosen = self._desk.state.document, self._chosen
        if not isinstance(chosen, SpacedPreset):
            return
        paced = first_m is None and self._may_pace(document)
        start_m = chosen.spacing_m if paced else first_m
        planned_m = () if start_m is None else chosen.starting_at(start_m).distances_m
        renamed = dict(zip(document.planned_m, planned_m, strict=False))
        moved = [SetDistance(m.id, renamed[m.distance_m]) for m in document.marks if m.distance_m in renamed]
        self._desk.offer(SetPaced(paced), *moved, PlanDistances(planned_m))
        self._first_m = first_m

    @staticmethod
    def _may_pace(document: Document) -> bool:
        """Whether the first distance need not be known."""
        way = chosen_way(document)
        return way is not None and way.key == DASHES


def own_words(imperial: bool) -> str:
    """What to do with marks at any distance."""
    return (
        "Click three marks on the road whose distances you know, and type each distance. One of them should "
        f"be far away, {'65 ft' if imperial else '20 m'} or more: near ones alone leave far distances "
        "uncertain."
    )
