"""The road and what stands along it, from a scenario and a seed."""

import zlib

import numpy as np

from fcw.simulation.world.road import Lane, LaneMarking, RoadProfile, Swell
from fcw.simulation.world.scenario import RoadPlan, Scenario
from fcw.simulation.world.state import RoadsideItem, RoadsideKind

BEHIND_M = 50.0
AHEAD_M = 700.0
"""The roadside reaches from so far behind the start to so far beyond the fastest possible end."""
VERGE_M = 2.5
"""Nothing tall grows nearer to the asphalt."""
WOODS_M = 28.0
"""Nor is anything placed farther out."""
POST_SPACING_M = 50.0
BUSH_SHARE = 0.35
BARRIER_FROM_EDGE_M, BARRIER_HEIGHT_M = 0.6, 0.75
BRIDGE_CLEARANCE_M, BRIDGE_TOP_M, BRIDGE_DECK_M, BRIDGE_SPAN_BEYOND_M = 5.2, 7.4, 9.0, 14.0
SIGN_WIDTH_M, SIGN_TOP_M, SIGN_CLEARANCE_M, SIGN_FROM_EDGE_M = 1.6, 3.6, 2.2, 1.8
MEDIAN_WITH_BARRIER_M = 1.5


def random_stream(seed: int, purpose: str) -> np.random.Generator:
    """A generator of its own for each purpose, so that adding one thing changes no other."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def make_road(plan: RoadPlan) -> RoadProfile:
    """The road's cross-section and course."""
    ours = range(-plan.lanes_right, plan.lanes_left + 1)
    theirs = range(plan.lanes_left + 1, plan.lanes_left + 1 + plan.opposing_lanes)
    lanes = tuple(Lane(plan.lane_middle_m(k), plan.lane_width_m, k in theirs) for k in (*ours, *theirs))
    half_m = plan.lane_width_m / 2
    right_line_m, left_line_m = lanes[0].lateral_m - half_m, lanes[-1].lateral_m + half_m
    our_left_m = plan.lane_middle_m(plan.lanes_left) + half_m
    markings = [LaneMarking(right_line_m, dashed=False), LaneMarking(left_line_m, dashed=False)]
    markings += [LaneMarking(lane.lateral_m - half_m, dashed=True) for lane in lanes[1 : len(ours)]]
    if theirs:
        markings += [LaneMarking(lane.lateral_m - half_m, dashed=True) for lane in lanes[len(ours) + 1 :]]
        markings.append(LaneMarking(our_left_m, dashed=False))
        if plan.median_m > 0:
            markings.append(LaneMarking(our_left_m + plan.median_m, dashed=False))
    return RoadProfile(
        lanes=lanes,
        markings=tuple(sorted(markings, key=lambda marking: marking.lateral_m)),
        right_edge_m=right_line_m - plan.shoulder_m,
        left_edge_m=left_line_m + plan.shoulder_m,
        bends=tuple(Swell(bend.start_m, bend.length_m, 1 / bend.radius_m) for bend in plan.bends),
        grades=tuple(Swell(grade.start_m, grade.length_m, grade.percent / 100) for grade in plan.grades),
    )


def make_roadside(scenario: Scenario, seed: int) -> tuple[RoadsideItem, ...]:
    """Trees, bushes, posts, barriers, bridges and signs, in the order of `s`."""
    plan, road = scenario.road, make_road(scenario.road)
    fastest_mps = (
        max(
            [scenario.ego.speed_kmh]
            + [max(a.speed_kmh or 0.0, a.follow_kmh or 0.0) for a in scenario.ego.actions]
        )
        / 3.6
    )
    end_m = scenario.duration_s * fastest_mps + AHEAD_M
    generator = random_stream(seed, "roadside")
    edges_m = {-1: road.right_edge_m, 1: road.left_edge_m}
    items: list[RoadsideItem] = []
    for _ in range(round(plan.trees_per_km * (end_m + BEHIND_M) / 1000)):
        side = int(generator.choice((-1, 1)))
        bush = generator.uniform() < BUSH_SHARE
        height_m = float(generator.uniform(1.0, 2.4) if bush else generator.uniform(4.5, 11.0))
        width_m = height_m * float(generator.uniform(1.0, 1.5) if bush else generator.uniform(0.55, 0.8))
        out_m = VERGE_M + width_m / 2 + (WOODS_M - VERGE_M) * float(generator.uniform()) ** 1.5
        items.append(
            RoadsideItem(
                kind=RoadsideKind.BUSH if bush else RoadsideKind.TREE,
                s_m=float(generator.uniform(-BEHIND_M, end_m)),
                lateral_m=edges_m[side] + side * out_m,
                width_m=width_m,
                height_m=height_m,
                seed=int(generator.integers(2**31)),
            )
        )
    for s_m in np.arange(0.0, end_m, POST_SPACING_M):
        items += [
            RoadsideItem(
                kind=RoadsideKind.POST,
                s_m=float(s_m),
                lateral_m=edge_m + side * 0.5,
                width_m=0.12,
                height_m=1.0,
            )
            for side, edge_m in edges_m.items()
        ]
    items += [_barrier(b.start_m, b.length_m, *_outside(edges_m, b.left)) for b in plan.barriers]
    if plan.opposing_lanes and plan.median_m > MEDIAN_WITH_BARRIER_M:
        ours_m = plan.lane_middle_m(plan.lanes_left) + plan.lane_width_m / 2
        items.append(_barrier(-BEHIND_M, end_m + BEHIND_M, ours_m + plan.median_m / 2, 0))
    middle_m = (road.left_edge_m + road.right_edge_m) / 2
    span_m = road.left_edge_m - road.right_edge_m + BRIDGE_SPAN_BEYOND_M
    items += [
        RoadsideItem(
            kind=RoadsideKind.BRIDGE,
            s_m=s_m,
            lateral_m=middle_m,
            width_m=span_m,
            height_m=BRIDGE_TOP_M,
            length_m=BRIDGE_DECK_M,
            clearance_m=BRIDGE_CLEARANCE_M,
            seed=int(generator.integers(2**31)),
        )
        for s_m in plan.bridges_m
    ]
    items += [
        RoadsideItem(
            kind=RoadsideKind.SIGN,
            s_m=s_m,
            lateral_m=road.right_edge_m - SIGN_FROM_EDGE_M,
            width_m=SIGN_WIDTH_M,
            height_m=SIGN_TOP_M,
            clearance_m=SIGN_CLEARANCE_M,
            seed=int(generator.integers(2**31)),
        )
        for s_m in plan.signs_m
    ]
    return tuple(sorted(items, key=lambda item: item.s_m))


def _outside(edges_m: dict[int, float], left: bool) -> tuple[float, int]:
    side = 1 if left else -1
    return edges_m[side], side


def _barrier(start_m: float, length_m: float, edge_m: float, side: int) -> RoadsideItem:
    return RoadsideItem(
        kind=RoadsideKind.BARRIER,
        s_m=start_m,
        lateral_m=edge_m + side * BARRIER_FROM_EDGE_M,
        width_m=0.3,
        height_m=BARRIER_HEIGHT_M,
        length_m=length_m,
    )
