"""Vehicles on their way: what their drivers want, and where that takes them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from fcw.simulation.world.motion import (
    PEDAL_LAG_S,
    LaneChange,
    Reaction,
    Sway,
    following_acceleration_mps2,
    seeking_acceleration_mps2,
)
from fcw.simulation.world.scenario import MPS_PER_KMH, Action, RoadPlan

SAME_LANE_M = 1.7
"""Two middles nearer than this across the road are in each other's way: a little less than half a lane."""
STRAIGHT_SPEED_MPS = 1.0
"""Below this speed a body's heading no longer follows its path across the road."""


@dataclass(slots=True)
class Mover:
    """One vehicle on its way.

    Attributes:
        s_m: of its near face; of the own vehicle, of the road below the camera.
        speed_mps: along the road, negative when oncoming.
        sense: 1 in our direction, -1 when oncoming.
        lane_m: its path across the road, without the sway.
        actions: what is still to begin, in order of time.
        sway: what is added to that path.
        front_m: from `s_m` to the end with the larger s.
        rear_m: from `s_m` to the other end.
        road: where its lanes are.
        action: what it does now along the road; None keeps the speed.
        reaction: how late it brakes when following.
        acceleration_mps2: along the road.
        lateral_m: where it is across the road.
        drift_mps: its speed across the road.
        facing_rad: its heading where it only crosses the road; None where it drives along it.
    """

    s_m: float
    speed_mps: float
    sense: float
    lane_m: LaneChange
    actions: list[Action]
    sway: Sway
    front_m: float
    rear_m: float
    road: RoadPlan
    action: Action | None = None
    reaction: Reaction = field(default_factory=Reaction)
    acceleration_mps2: float = 0.0
    lateral_m: float = 0.0
    drift_mps: float = 0.0
    facing_rad: float | None = None

    @property
    def heading_rad(self) -> float:
        """Of the axis from its near to its far face against the road; it points along the path."""
        if self.facing_rad is not None:
            return self.facing_rad
        return math.atan2(self.sense * self.drift_mps, max(abs(self.speed_mps), STRAIGHT_SPEED_MPS))

    def place(self, time_s: float) -> None:
        """Go to where the path across the road is at a time."""
        lane_m, change_mps = self.lane_m.at(time_s)
        sway_m, sway_slope = self.sway.at(self.s_m)
        self.lateral_m = lane_m + sway_m
        self.drift_mps = change_mps + sway_slope * self.speed_mps

    def wanted_mps2(self, others: Iterable["Mover"], time_s: float, step_s: float) -> float:
        """The acceleration its driver wants, after beginning the actions that are due."""
        while self.actions and self.actions[0].at_s <= time_s:
            action = self.actions.pop(0)
            if action.lane is None and action.offset_m is None:
                self.action, self.reaction = action, Reaction(action.reaction_s)
            else:
                to_m = action.offset_m
                if to_m is None:
                    to_m = self.road.lane_middle_m(action.lane or 0)
                self.lane_m = LaneChange(time_s, action.over_s, self.lane_m.at(time_s)[0], to_m)
        action = self.action
        if action is None:
            return 0.0
        if action.speed_kmh is not None:
            target_mps = self.sense * action.speed_kmh * MPS_PER_KMH
            return seeking_acceleration_mps2(self.speed_mps, target_mps, action.rate_mps2)
        desired_mps = (action.follow_kmh or 0.0) * MPS_PER_KMH
        gap_m, closing_mps = self._gap_ahead(others)
        wanted = following_acceleration_mps2(
            self.speed_mps, desired_mps, action.headway_s, gap_m, closing_mps
        )
        return self.reaction.filtered(wanted, step_s)

    def move(self, wanted_mps2: float, time_s: float, step_s: float) -> None:
        """Move on to `time_s`; the pedals take effect with a lag, and brakes stop but never reverse."""
        self.acceleration_mps2 += (wanted_mps2 - self.acceleration_mps2) * step_s / PEDAL_LAG_S
        before_mps, after_mps = self.speed_mps, self.speed_mps + self.acceleration_mps2 * step_s
        if self.sense * after_mps <= 0:
            after_mps = self.acceleration_mps2 = 0.0
        self.speed_mps = after_mps
        self.s_m += (before_mps + after_mps) / 2 * step_s
        self.place(time_s)

    def _gap_ahead(self, others: Iterable["Mover"]) -> tuple[float, float]:
        """Bumper to bumper gap to the nearest vehicle ahead in the way, and its closing speed."""
        gap_m, closing_mps = math.inf, 0.0
        front_m = self.s_m + self.front_m
        for other in others:
            rear_m = other.s_m + other.rear_m
            # Who comes into the lane counts as soon as the change is half done.
            beside = abs(other.lateral_m - self.lateral_m) >= SAME_LANE_M
            if other is self or beside or other.sense < 0 or other.s_m <= self.s_m:
                continue
            if rear_m - front_m < gap_m:
                gap_m, closing_mps = rear_m - front_m, self.speed_mps - other.speed_mps
        return gap_m, closing_mps


def advance(movers: Sequence[Mover], time_s: float, step_s: float) -> None:
    """One step of everybody from `time_s` on: first all decide, then all move."""
    wanted = [mover.wanted_mps2(movers, time_s, step_s) for mover in movers]
    for mover, wanted_mps2 in zip(movers, wanted, strict=True):
        mover.move(wanted_mps2, time_s + step_s, step_s)
