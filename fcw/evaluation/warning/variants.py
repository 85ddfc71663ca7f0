"""Vehicles that come half into our way, or leave it too slowly: many ways, seen well and badly.

What drives that nobody tuned to taught: a vehicle half in the path, its middle far aside, was not warned of.
So each of these scenarios is run with other speeds across and other overlaps, and each of those with more
noise in its boxes, found late, and with frames in which nothing is found.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from fcw.simulation.world.scenario import Scenario, VehiclePlan, load_scenario

COMING_IN_S = (1.5, 2.5, 4.0)
"""How long the vehicle takes to its place: its fastest is 2.2 / 1.5 / 0.8 m/s across."""
PLACES_M = (-0.5, -0.9, -1.3)
"""Where its middle ends from the middle of our lane."""
LEAVING_S = (8.0, 10.0, 14.0)
"""How long a vehicle takes to leave our lane."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """How well vehicles are found, at the level of boxes.

    Attributes:
        name: in the results.
        noise_px: 1-sigma of the sides of the boxes, 1.5 times that of the lower edge.
        farthest_m: from the bumper; farther ones are not found.
        lost_part: part of the frames in which a vehicle is not found.
        lost_s: how long it is not found each time.
    """

    name: str = "as usual"
    noise_px: float = 2.0
    farthest_m: float = 80.0
    lost_part: float = 0.0
    lost_s: float = 0.2


SIGHTS = (
    Sight(),
    Sight(name="4 px of noise", noise_px=4.0),
    Sight(name="found at 15 m", farthest_m=15.0),
    Sight(name="lost in 30 %", lost_part=0.3),
)


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
