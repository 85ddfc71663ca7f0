"""The world in motion: a scenario and a seed give every instant of a drive, always the same."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from fcw.simulation.world.motion import LaneChange, NoseDive, RoadShake, Sway
from fcw.simulation.world.movers import Mover, advance
from fcw.simulation.world.scenario import (
    FRAMES_PER_SECOND,
    MPS_PER_KMH,
    Action,
    RoadPlan,
    Scenario,
    VehiclePlan,
)
from fcw.simulation.world.state import (
    VEHICLE_SIZES,
    EgoState,
    RoadMark,
    VehicleKind,
    VehicleSize,
    VehicleState,
    WorldState,
)
from fcw.simulation.world.surroundings import make_road, make_roadside, random_stream

STEPS_PER_FRAME = 8
STEP_S = 1 / (STEPS_PER_FRAME * FRAMES_PER_SECOND)
EGO_LENGTH_M = 4.6
SIZE_SPREAD = 0.03
"""How far a body's measures may be from those of its kind, as a fraction."""
SWAY_M = 0.12
"""How far drivers stray from the middle of their lane; an attentive one half as far."""
BRAKE_LAMPS_MPS2 = -0.7
"""Brake lamps light below this; rolling out is weaker."""
STANDING_MPS = 0.1
MARK_ACROSS_M = 1.6
MARK_NEAREST_ALONG_M = 0.2
MARK_STRETCH_PER_M = 1 / 500
"""A mark's length along the road grows with its distance squared, so that it stays two rows thick."""
COMMON_KINDS = (VehicleKind.SALOON, VehicleKind.HATCHBACK, VehicleKind.VAN)
COMMON_KIND_SHARES = (0.45, 0.4, 0.15)
Bgr = tuple[int, int, int]
COLORS: tuple[Bgr, ...] = (
    (208, 210, 212),
    (178, 180, 182),
    (120, 119, 116),
    (70, 68, 66),
    (36, 35, 34),
    (112, 62, 34),
    (30, 28, 128),
    (88, 84, 44),
    (92, 122, 150),
)
"""Paint as cars have it: white, silver, greys, black, blue, red, petrol, champagne."""
TRUCK_COLORS: tuple[Bgr, ...] = ((215, 216, 218), (190, 186, 180), (140, 90, 50), (60, 60, 160))


@dataclass(frozen=True, slots=True)
class _Look:
    kind: VehicleKind
    size: VehicleSize
    color: Bgr
    seed: int


class World:
    """A drive: its road, its surroundings, and its states one by one.

    Attributes:
        scenario: what happens.
        seed: varies kinds, colours and sizes of vehicles, roadside, shaking, sway and small timings.
        road: the same at all instants, as are `roadside` and `marks`.
    """

    def __init__(self, scenario: Scenario, seed: int = 0) -> None:
        self.scenario = scenario
        self.seed = seed
        self.road = make_road(scenario.road)
        self.roadside = make_roadside(scenario, seed)
        offset_m = scenario.camera.reference_offset_m
        self.marks = tuple(
            RoadMark(offset_m + d, 0.0, max(MARK_NEAREST_ALONG_M, d**2 * MARK_STRETCH_PER_M), MARK_ACROSS_M)
            for d in scenario.road.marks_m
        )
        self._looks = [_look(plan, seed) for plan in scenario.vehicles]

    def states(self) -> Iterator[WorldState]:
        """The instants of all frames, in order; each call begins anew."""
        scenario = self.scenario
        generator = random_stream(self.seed, "ego")
        shake = RoadShake(scenario.road.roughness, generator)
        dive = NoseDive()
        offset_m = scenario.camera.reference_offset_m
        ego = Mover(
            s_m=0.0,
            speed_mps=scenario.ego.speed_kmh * MPS_PER_KMH,
            sense=1.0,
            lane_m=LaneChange(0.0, 1.0, 0.0, 0.0),
            actions=_in_order(scenario.ego.actions),
            # The phase is 0: at the start the camera stands in the middle of the lane.
            sway=Sway(SWAY_M / 2, float(generator.uniform(140, 220)), 0.0),
            front_m=offset_m,
            rear_m=offset_m - EGO_LENGTH_M,
            road=scenario.road,
        )
        others = [self._mover(plan, look) for plan, look in zip(scenario.vehicles, self._looks, strict=True)]
        movers = [ego, *others]
        for mover in movers:
            mover.place(0.0)
        for index in range(scenario.frame_count):
            for step in range(STEPS_PER_FRAME if index else 0):
                advance(movers, ((index - 1) * STEPS_PER_FRAME + step) * STEP_S, STEP_S)
                dive.step(ego.acceleration_mps2, STEP_S)
            shake_rad, bounce_m = shake.at(index / FRAMES_PER_SECOND, ego.speed_mps)
            yield WorldState(
                time_ns=round(index * 1e9 / FRAMES_PER_SECOND),
                ego=EgoState(
                    s_m=ego.s_m,
                    speed_mps=ego.speed_mps,
                    acceleration_mps2=ego.acceleration_mps2,
                    lateral_m=ego.lateral_m,
                    heading_rad=ego.heading_rad if ego.speed_mps > 0 else 0.0,
                    pitch_deviation_rad=dive.pitch_rad + shake_rad,
                    bounce_m=bounce_m,
                ),
                vehicles=tuple(
                    _vehicle_state(plan, look, mover)
                    for plan, look, mover in zip(scenario.vehicles, self._looks, others, strict=True)
                ),
                road=self.road,
                roadside=self.roadside,
                marks=self.marks,
            )

    def _mover(self, plan: VehiclePlan, look: _Look) -> Mover:
        generator = random_stream(self.seed, f"driver {plan.name}")
        jitter_s = float(generator.uniform(-1, 1)) * self.scenario.timing_jitter_s
        sway = Sway(
            0.0 if plan.parked else SWAY_M * float(generator.uniform(0.3, 1.0)),
            float(generator.uniform(120, 260)),
            float(generator.uniform(0, 2 * math.pi)),
        )
        sense = -1.0 if plan.oncoming else 1.0
        lateral_m = self.scenario.road.lane_middle_m(plan.lane) + plan.offset_m
        return Mover(
            s_m=self.scenario.camera.reference_offset_m + plan.gap_m,
            speed_mps=sense * plan.speed_kmh * MPS_PER_KMH,
            sense=sense,
            lane_m=LaneChange(0.0, 1.0, lateral_m, lateral_m),
            actions=_in_order(replace(action, at_s=action.at_s + jitter_s) for action in plan.actions),
            sway=sway,
            front_m=look.size.length_m,
            rear_m=0.0,
            road=self.scenario.road,
            facing_rad=_facing_across_rad(plan, self.scenario.road),
        )


def _in_order(actions: Iterable[Action]) -> list[Action]:
    return sorted(actions, key=lambda action: action.at_s)


def _facing_across_rad(plan: VehiclePlan, road: RoadPlan) -> float | None:
    """Heading of a vehicle that only crosses the road: it faces where it goes, also before it starts."""
    drives = plan.speed_kmh > 0 or any(action.speed_kmh or action.follow_kmh for action in plan.actions)
    if drives or not plan.actions:
        return None
    action = _in_order(plan.actions)[0]
    to_m = road.lane_middle_m(action.lane or 0) if action.offset_m is None else action.offset_m
    way_m = to_m - road.lane_middle_m(plan.lane) - plan.offset_m
    return math.copysign(math.pi / 2, -way_m if plan.oncoming else way_m)


def _look(plan: VehiclePlan, seed: int) -> _Look:
    generator = random_stream(seed, f"vehicle {plan.name}")
    chosen = COMMON_KINDS[int(generator.choice(len(COMMON_KINDS), p=COMMON_KIND_SHARES))]
    kind = plan.kind or chosen
    usual = VEHICLE_SIZES[kind]
    width, height, length = (float(x) for x in 1 + SIZE_SPREAD * generator.uniform(-1, 1, 3))
    size = VehicleSize(
        width_m=usual.width_m * width,
        height_m=usual.height_m * height,
        length_m=usual.length_m * length,
        overhang_m=usual.overhang_m * length,
        clearance_m=usual.clearance_m * height,
    )
    colors = TRUCK_COLORS if kind is VehicleKind.TRUCK else COLORS
    return _Look(kind, size, colors[int(generator.integers(len(colors)))], int(generator.integers(2**31)))


def _vehicle_state(plan: VehiclePlan, look: _Look, mover: Mover) -> VehicleState:
    slowing = mover.sense * mover.acceleration_mps2 < BRAKE_LAMPS_MPS2
    standing = abs(mover.speed_mps) < STANDING_MPS and mover.acceleration_mps2 == 0
    return VehicleState(
        name=plan.name,
        kind=look.kind,
        size=look.size,
        color=look.color,
        seed=look.seed,
        s_m=mover.s_m,
        lateral_m=mover.lateral_m,
        heading_rad=mover.heading_rad,
        speed_mps=mover.speed_mps,
        acceleration_mps2=mover.acceleration_mps2,
        brake_lamps=not plan.parked and (slowing or standing),
        oncoming=plan.oncoming,
    )
