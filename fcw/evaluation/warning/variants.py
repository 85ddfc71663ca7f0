"""Vehicles that come half into our way, or leave it too slowly: many ways, seen well and badly.

What drives that nobody tuned to taught: a vehicle half in the path, its middle far aside, was not warned of.
So each of these scenarios is run with other speeds across and other overlaps, each with every `SIGHTS` of
`fcw.evaluation.warning.sights`.
"""

from collections.abc import Iterator
from dataclasses import replace

from fcw.simulation.world.scenario import Scenario, VehiclePlan, load_scenario

COMING_IN_S = (1.5, 2.5, 4.0)
"""How long the vehicle takes to its place: its fastest is 2.2 / 1.5 / 0.8 m/s across."""
PLACES_M = (-0.5, -0.9, -1.3)
"""Where its middle ends from the middle of our lane."""
LEAVING_S = (8.0, 10.0, 14.0)
"""How long a vehicle takes to leave our lane."""


def half_in_the_way() -> Iterator[tuple[str, Scenario]]:
    """The variants, each with its name."""
    coming = load_scenario("half-cut-in")
    for over_s in COMING_IN_S:
        for offset_m in PLACES_M:
            changed = _with_last_action(coming, over_s, offset_m)
            yield f"comes to {offset_m:g} m in {over_s:g} s", changed
    leaving = load_scenario("leaving-slowly")
    for over_s in LEAVING_S:
        yield f"leaves in {over_s:g} s", _with_last_action(leaving, over_s, None)


def _with_last_action(scenario: Scenario, over_s: float, offset_m: float | None) -> Scenario:
    def varied(plan: VehiclePlan) -> VehiclePlan:
        if plan.name != scenario.danger:
            return plan
        last = replace(plan.actions[-1], over_s=over_s)
        if offset_m is not None:
            last = replace(last, offset_m=offset_m)
        return replace(plan, actions=(*plan.actions[:-1], last))

    return replace(scenario, vehicles=tuple(varied(plan) for plan in scenario.vehicles))
