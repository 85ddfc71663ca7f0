"""The world: what its scenarios ask for happens, nobody drives through anybody, and a seed repeats it."""

import itertools

import numpy as np
import pytest

from fcw.simulation.world.scenario import (
    FRAMES_PER_SECOND,
    Action,
    CameraPlan,
    EgoPlan,
    RoadPlan,
    Scenario,
    VehiclePlan,
    load_scenario,
    scenario_names,
)
from fcw.simulation.world.state import RoadsideKind, VehicleKind
from fcw.simulation.world.surroundings import make_road, make_roadside
from fcw.simulation.world.world import EGO_LENGTH_M, World

KMH = 1 / 3.6


def drive(*vehicles: VehiclePlan, ego: EgoPlan | None = None, duration_s: float = 6.0, **road):
    scenario = Scenario(
        description="a test",
        duration_s=duration_s,
        ego=ego or EgoPlan(speed_kmh=72),
        road=RoadPlan(roughness=0.0, **road),
        vehicles=vehicles,
        timing_jitter_s=0.0,
    )
    return list(World(scenario, 0).states())


def series(states, name):
    return [next(v for v in state.vehicles if v.name == name) for state in states]


def test_without_actions_speeds_and_gaps_stay():
    states = drive(VehiclePlan(name="a", gap_m=30, speed_kmh=72))
    assert {round(state.ego.speed_mps, 9) for state in states} == {20.0}
    assert states[-1].ego.s_m == pytest.approx(20 * (len(states) - 1) / FRAMES_PER_SECOND)
    gaps = [v.s_m - state.ego.s_m for state, v in zip(states, series(states, "a"), strict=True)]
    assert gaps == pytest.approx([30 + CameraPlan().reference_offset_m] * len(gaps))


def test_braking_takes_the_distance_of_physics_and_lights_the_lamps():
    brake = Action(at_s=1.0, speed_kmh=0.0, rate_mps2=5.0)
    vehicles = series(drive(VehiclePlan(name="a", gap_m=50, speed_kmh=72, actions=(brake,))), "a")
    stopped = vehicles[-1]
    assert stopped.speed_mps == 0
    # v^2 / (2 a) after one second at 20 m/s; the pedal's lag of 0.15 s costs 20 * 0.15 m more.
    way_m = stopped.s_m - vehicles[0].s_m
    assert way_m == pytest.approx(20 + 20**2 / 10 + 20 * 0.15, abs=1.5)
    assert not any(v.brake_lamps for v in vehicles[:30])
    assert all(v.brake_lamps for v in vehicles[35:])


def test_position_is_the_integral_of_speed():
    states = drive(
        VehiclePlan(name="a", gap_m=40, speed_kmh=50, actions=(Action(at_s=2, speed_kmh=20, rate_mps2=3),)),
        ego=EgoPlan(speed_kmh=60, actions=(Action(at_s=0, follow_kmh=80),)),
    )
    for s_m, speed_mps in (
        ([s.ego.s_m for s in states], [s.ego.speed_mps for s in states]),
        ([v.s_m for v in series(states, "a")], [v.speed_mps for v in series(states, "a")]),
    ):
        mean = (np.array(speed_mps[1:]) + np.array(speed_mps[:-1])) / 2
        np.testing.assert_allclose(np.diff(s_m), mean / FRAMES_PER_SECOND, atol=1e-3)


def test_a_late_driver_brakes_later_and_comes_nearer():
    def nearest(reaction_s):
        brake = Action(at_s=1, speed_kmh=30, rate_mps2=4)
        follow = Action(at_s=0, follow_kmh=120, headway_s=1.2, reaction_s=reaction_s)
        states = drive(
            VehiclePlan(name="a", gap_m=25, speed_kmh=72, actions=(brake,)),
            ego=EgoPlan(speed_kmh=72, actions=(follow,)),
            duration_s=10,
        )
        return min(v.s_m - s.ego.s_m for s, v in zip(states, series(states, "a"), strict=True))

    assert nearest(2.0) < nearest(1.0) < nearest(0.0)


def test_a_cut_in_ends_in_our_lane_and_points_along_its_path():
    change = Action(at_s=1, lane=0, over_s=3)
    vehicles = series(drive(VehiclePlan(name="a", lane=1, gap_m=20, speed_kmh=72, actions=(change,)),
                            lanes_left=1), "a")  # fmt: skip
    assert vehicles[0].lateral_m == pytest.approx(3.5, abs=0.13)
    assert vehicles[-1].lateral_m == pytest.approx(0.0, abs=0.13)
    for before, now, after in zip(vehicles, vehicles[1:], vehicles[2:], strict=False):
        slope = (after.lateral_m - before.lateral_m) / (after.s_m - before.s_m)
        assert now.heading_rad == pytest.approx(np.arctan(slope), abs=2e-3)


@pytest.mark.parametrize(("to_m", "oncoming"), [(22.0, False), (-40.0, False), (22.0, True)])
def test_who_only_crosses_the_road_faces_where_he_goes_from_the_start(to_m, oncoming):
    cross = Action(at_s=1, offset_m=to_m, over_s=3)
    plan = VehiclePlan(name="a", gap_m=60, offset_m=-22, oncoming=oncoming, actions=(cross,))
    vehicles = series(drive(plan, duration_s=3), "a")
    moved_m = vehicles[-1].lateral_m - vehicles[0].lateral_m
    # An oncoming one shows its front, from which its axis runs backwards.
    ahead = -1 if oncoming else 1
    assert {ahead * v.heading_rad for v in vehicles} == {np.copysign(np.pi / 2, moved_m)}


def test_oncoming_vehicles_come_and_parked_ones_stand():
    states = drive(
        VehiclePlan(name="oncoming", lane=1, oncoming=True, gap_m=300, speed_kmh=90),
        VehiclePlan(name="parked", gap_m=60, offset_m=-3, parked=True),
        opposing_lanes=1,
    )
    oncoming, parked = series(states, "oncoming"), series(states, "parked")
    assert oncoming[-1].s_m - oncoming[0].s_m == pytest.approx(-25 * (len(states) - 1) / 30, rel=1e-6)
    assert all(v.oncoming and v.speed_mps == pytest.approx(-25) for v in oncoming)
    assert {(v.s_m, v.lateral_m, v.brake_lamps) for v in parked} == {(parked[0].s_m, -3.0, False)}


def test_the_own_nose_dives_when_braking_and_the_camera_is_level_while_standing():
    stop = Action(at_s=1, speed_kmh=0, rate_mps2=6)
    states = drive(ego=EgoPlan(speed_kmh=72, actions=(stop,)), duration_s=10)
    assert states[75].ego.pitch_deviation_rad > 0.005
    assert abs(states[-1].ego.pitch_deviation_rad) < 1e-4
    assert states[0].ego.pitch_deviation_rad == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", scenario_names())
@pytest.mark.parametrize("seed", [0, 1, 7])
def test_nobody_drives_through_anybody(name, seed):
    scenario = load_scenario(name)
    offset_m = scenario.camera.reference_offset_m
    for state in itertools.islice(World(scenario, seed).states(), 0, None, 3):
        ego = state.ego
        bodies = [(ego.s_m + offset_m - EGO_LENGTH_M, ego.s_m + offset_m, ego.lateral_m, 1.8)]
        bodies += [(v.s_m, v.s_m + v.size.length_m, v.lateral_m, v.size.width_m) for v in state.vehicles]
        for (rear, front, lateral, width), (rear2, front2, lateral2, width2) in itertools.combinations(
            bodies, 2
        ):
            beside = abs(lateral - lateral2) >= (width + width2) / 2
            assert beside or front < rear2 or front2 < rear, f"collision at {state.time_ns / 1e9:.2f} s"


@pytest.mark.parametrize("name", scenario_names())
def test_a_seed_repeats_a_drive_bit_for_bit_and_another_does_not(name):
    scenario = load_scenario(name)
    first, again, other = (
        list(itertools.islice(World(scenario, seed).states(), 100, 105)) for seed in (5, 5, 6)
    )
    assert first == again
    assert first != other


def test_a_seed_varies_looks_but_what_the_scenario_fixes_stays():
    scenario = load_scenario("demo")
    states = [next(World(scenario, seed).states()) for seed in range(6)]
    looks = {tuple((v.color, v.size) for v in state.vehicles) for state in states}
    assert len(looks) == len(states)
    for state in states:
        kinds = [v.kind for v in state.vehicles]
        assert kinds == [plan.kind for plan in scenario.vehicles]
    free = Scenario(description="", duration_s=1, ego=EgoPlan(), vehicles=(VehiclePlan(name="a", gap_m=30),))
    assert len({next(World(free, seed).states()).vehicles[0].kind for seed in range(30)}) == 3


def test_marks_lie_at_their_distances_from_the_bumper_of_the_standing_car():
    scenario = load_scenario("demo")
    states = list(itertools.islice(World(scenario, 0).states(), 55))
    assert all(state.ego.s_m == 0 and state.ego.lateral_m == 0 for state in states)
    offset_m = scenario.camera.reference_offset_m
    assert [mark.s_m - offset_m for mark in states[0].marks] == pytest.approx([6, 15, 30])


def test_the_road_has_the_lanes_and_lines_of_its_plan():
    road = make_road(RoadPlan(lanes_left=1, lanes_right=1, opposing_lanes=1, median_m=1.0, lane_width_m=3.5))
    assert [lane.lateral_m for lane in road.lanes] == [-3.5, 0.0, 3.5, 8.0]
    assert [lane.oncoming for lane in road.lanes] == [False, False, False, True]
    lines = [(marking.lateral_m, marking.dashed) for marking in road.markings]
    assert lines == [(-5.25, False), (-1.75, True), (1.75, True), (5.25, False), (6.25, False), (9.75, False)]
    assert (road.right_edge_m, road.left_edge_m) == pytest.approx((-6.45, 10.95))


def test_nothing_stands_on_the_asphalt_and_bridges_span_it():
    for name in scenario_names():
        scenario = load_scenario(name)
        road = make_road(scenario.road)
        for item in make_roadside(scenario, 3):
            left_m, right_m = item.lateral_m + item.width_m / 2, item.lateral_m - item.width_m / 2
            if item.kind is RoadsideKind.BRIDGE:
                assert left_m > road.left_edge_m
                assert right_m < road.right_edge_m
                assert item.clearance_m > 4.5
            else:
                assert right_m > road.left_edge_m or left_m < road.right_edge_m, item


def test_trucks_are_asked_for_and_never_drawn_by_chance():
    plans = tuple(VehiclePlan(name=str(k), gap_m=20 * k) for k in range(60))
    scenario = Scenario(description="", duration_s=1, ego=EgoPlan(), vehicles=plans)
    assert VehicleKind.TRUCK not in {v.kind for v in next(World(scenario, 1).states()).vehicles}
