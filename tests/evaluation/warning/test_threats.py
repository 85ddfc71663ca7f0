"""Simulated dangers: their windows follow from exact motion, and a policy is judged by them."""

import math
from dataclasses import replace

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.evaluation.warning import threats
from fcw.evaluation.warning.sights import SIGHTS, WORSE_SIGHTS
from fcw.evaluation.warning.threats import danger_window, run_threat_trial, run_threats
from fcw.evaluation.warning.variants import half_in_the_way
from fcw.motion.ego import NOTHING_KNOWN
from fcw.simulation.drive import render_drive
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth
from fcw.simulation.world.scenario import (
    IMAGE_SIZE,
    Action,
    EgoPlan,
    RoadPlan,
    Scenario,
    VehiclePlan,
    load_scenario,
    threat_names,
)
from fcw.simulation.world.state import VehicleKind
from fcw.tracking.tracker import Tracker
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel, WarningState

FRAME_NS = 33_333_333


def truth(time_s, distance_m, lateral_m, closing_mps, name="car"):
    box = Box(600, 300, 1800 / (distance_m + 1.6), 1400 / (distance_m + 1.6))
    vehicle = VehicleTruth(
        name=name,
        distance_m=distance_m,
        lateral_m=lateral_m,
        path_lateral_m=lateral_m,
        closing_speed_mps=closing_mps,
        ttc_s=distance_m / closing_mps,
        box=box,
        body_box=box,
        visible_fraction=1.0,
        oncoming=False,
        in_path=abs(lateral_m) < 1.75,
    )
    return FrameTruth(round(time_s * 1e9), closing_mps, 0.0, 0.0, 350.0, (vehicle,))


def test_the_window_of_a_standing_car_ends_when_the_driver_of_1_2_s_and_0_4_g_must_be_warned():
    # 70 m at 10 m/s: 12 m of reaction and 12.75 m of braking are needed, 45 m are 4.5 s.
    frames = [truth(k / 30, 70 - k / 3, 0.0, 10.0) for k in range(211)]
    window = danger_window("car", [(frame, True) for frame in frames])
    assert window is not None
    assert window.earliest_s == pytest.approx(2.5, abs=0.05)
    assert window.latest_s == pytest.approx(7.0 - 2.475, abs=0.05)
    assert window.contact_s == pytest.approx(6.97, abs=0.05)


def test_the_window_of_a_car_that_pulls_out_ends_a_second_after_it_can_be_known():
    # It moves from 3 m aside towards us from 5 s on, 1.5 m/s, when the driver should long have been warned.
    frames = [truth(k / 30, 70 - k / 3, -3.0 + max(k / 30 - 5.0, 0.0) * 1.5, 10.0) for k in range(211)]
    window = danger_window("car", [(frame, True) for frame in frames])
    assert window is not None
    assert window.latest_s == pytest.approx(6.03, abs=0.05)


class Fixed:
    """Warns of the nearest vehicle from a time on."""

    name = "fixed"

    def __init__(self, from_s):
        self.from_s = from_s

    def update(self, time_ns, threats, ego_speed_mps):
        if time_ns / 1e9 < self.from_s or not threats:
            return WarningState(WarningLevel.NONE)
        return WarningState(WarningLevel.WARNING, threats[0].track.track_id, "fixed")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("from_s", "passed", "false"), [(1.0, False, True), (3.0, True, False), (5.0, False, False)]
)
def test_too_early_is_false_and_too_late_is_missed(from_s, passed, false):
    trial = run_threat_trial(load_scenario("overlap-75"), 0, Fixed(from_s))
    assert trial.window is not None
    window = trial.window
    assert (window.earliest_s, window.latest_s, window.contact_s) == pytest.approx((2.35, 3.9, 6.8), abs=0.1)
    assert (trial.passed, bool(trial.false_s)) == (passed, false)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "crossing",
        "cut-out",
        "half-cut-in",
        "leaving-slowly",
        "oncoming-in-lane",
        "pulling-out",
        "slow-cut-in",
    ],
)
def test_dangers_are_warned_of_in_their_windows(name):
    (result,) = run_threats([(name, load_scenario(name))], make_policy, (0, 1))
    assert (result.trials_passed, result.false_warnings) == (2, 0)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "most_early_s"), [("overlap-50", 0.101), ("overlap-75", 0.201)])
def test_partial_overlaps_are_warned_of_in_time_and_not_long_before(name, most_early_s):
    (result,) = run_threats([(name, load_scenario(name))], make_policy, range(4))
    too_early_s = []
    for trial in result.trials:
        assert trial.window is not None
        assert trial.warned_s is not None
        assert trial.warned_s <= trial.window.latest_s
        too_early_s.append(max(trial.window.earliest_s - trial.warned_s, 0.0))
    # With own motion as the picture measures it one of four comes a moment before the window.
    assert sorted(too_early_s)[:3] == [0.0, 0.0, 0.0]
    assert max(too_early_s) <= most_early_s


@pytest.mark.slow
def test_a_van_that_is_found_at_15_m_half_in_our_way_is_warned_of():
    late = next(sight for sight in SIGHTS if sight.name == "found at 15 m")
    for scenario in dict(half_in_the_way()).values():
        if scenario.danger == "coming in":
            assert run_threat_trial(scenario, 0, make_policy(), sight=late).passed


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "sight_name"),
    [
        ("cut-out", "at 15 m, for 0.6 s"),
        ("cut-out", "found at 10 m"),
        ("slow-cut-in", "a part boxed"),
        ("leaving-slowly", "lost in 60 %"),
    ],
)
def test_a_worse_detector_still_gives_the_warning(name, sight_name):
    sight = next(sight for sight in WORSE_SIGHTS if sight.name == sight_name)
    assert run_threat_trial(load_scenario(name), 100, make_policy(), sight=sight).passed


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["cut-out-free", "overtaking", "bonnet-and-logo", "bend-parked", "drifting-neighbour"]
)
def test_what_only_looks_like_a_danger_is_not_warned_of(name):
    (result,) = run_threats([(name, load_scenario(name))], make_policy, (0,))
    assert (result.trials_passed, result.false_warnings) == (1, 0)


def standing_across(tail_m: float, speed_kmh: float) -> Scenario:
    """A car that stands across the road 75 m ahead, its nose to the left, its tail there."""
    scenario = load_scenario("crossing")
    (plan,) = scenario.vehicles
    later = replace(plan.actions[-1], at_s=60.0)
    vehicle = replace(plan, offset_m=tail_m, actions=(later,))
    return replace(scenario, ego=replace(scenario.ego, speed_kmh=speed_kmh), vehicles=(vehicle,))


@pytest.mark.slow
@pytest.mark.parametrize("speed_kmh", [40.0, 60.0, 90.0])
@pytest.mark.parametrize("tail_m", [-4.6, -4.0, -0.3, 0.3], ids=["nose", "front", "rear", "tail"])
def test_a_car_that_stands_across_with_one_end_in_our_way_is_warned_of(tail_m, speed_kmh):
    # It is 4.3 m long: 0.6 or 1.2 m of it is in our way.
    trial = run_threat_trial(standing_across(tail_m, speed_kmh), 0, make_policy())
    assert trial.window is not None
    assert trial.warned_s is not None
    # A second before its tail's middle would be reached, which is half a width beyond its side.
    assert trial.window.contact_s - trial.warned_s >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize("tail_m", [-6.2, 1.9], ids=["nose", "tail"])
def test_a_car_that_waits_across_a_metre_beside_our_way_is_not_warned_of(tail_m):
    trial = run_threat_trial(standing_across(tail_m, 60.0), 0, make_policy())
    assert trial.warned_s is None


def crossing_at(own_kmh: float, across_kmh: float, side: int, later_s: float) -> Scenario:
    """A car that crosses at nearly one speed, and is in our way so long before we are."""
    crosses_s = 1.875 * 80.0 * 3.6 / across_kmh  # its speed is the greatest in the middle, before our path
    gap_m = own_kmh / 3.6 * (crosses_s / 2 + later_s)
    scenario = load_scenario("crossing")
    (plan,) = scenario.vehicles
    crosses = Action(at_s=0.0, offset_m=40.0 * side, over_s=crosses_s)
    vehicle = replace(plan, gap_m=gap_m, offset_m=-40.0 * side, actions=(crosses,))
    return replace(
        scenario,
        duration_s=crosses_s / 2 + later_s + 1.0,
        ego=replace(scenario.ego, speed_kmh=own_kmh),
        vehicles=(vehicle,),
        danger=plan.name if later_s == 0 else "",
    )


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("own_kmh", "across_kmh"), [(40, 30), (50, 20), (60, 20), (60, 30), (70, 30)])
def test_a_car_that_crosses_far_aside_is_warned_of_two_seconds_before_contact(own_kmh, across_kmh, side):
    # By its place alone, whose error was taken for a motion, 1.8 to 2.7 s.
    trial = run_threat_trial(crossing_at(own_kmh, across_kmh, side, 0.0), 0, make_policy())
    assert trial.window is not None
    assert trial.warned_s is not None
    assert trial.window.earliest_s <= trial.warned_s <= trial.window.contact_s - 2.0


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("own_kmh", "across_kmh"), [(50, 20), (70, 30)])
def test_a_car_that_crosses_well_before_us_is_not_warned_of(own_kmh, across_kmh, side):
    assert run_threat_trial(crossing_at(own_kmh, across_kmh, side, 1.8), 0, make_policy()).passed


def braking_at_a_crossing(room_m: float, side: int) -> Scenario:
    """A car of 4.3 m brakes from 20 km/h in a side road and stops so far beside us; below 0 in our way."""
    scenario = load_scenario("crossing-stops")
    (plan,) = scenario.vehicles
    tail_m = (0.9 + room_m + 4.3) * side
    stops = replace(plan.actions[-1], offset_m=tail_m)
    vehicle = replace(plan, offset_m=tail_m + 14.3 * side, actions=(stops,))
    return replace(scenario, vehicles=(vehicle,), danger="" if room_m > 0 else plan.name)


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("room_m", [1.0, 3.0])
def test_a_car_that_stops_at_a_crossing_is_mostly_not_warned_of(room_m, side):
    # As fast as it is three seconds before we pass, it would be in our way then.
    trials = [run_threat_trial(braking_at_a_crossing(room_m, side), seed, make_policy()) for seed in range(6)]
    assert sum(trial.passed for trial in trials) >= 4


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
def test_a_car_that_brakes_too_late_and_stops_with_its_front_in_our_way_is_warned_of(side):
    for seed in range(2):
        trial = run_threat_trial(braking_at_a_crossing(-1.2, side), seed, make_policy())
        assert trial.window is not None
        assert trial.warned_s is not None
        assert trial.window.contact_s - trial.warned_s >= 2.0


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("faster_kmh", [20.0, 30.0])
def test_a_lorry_behind_which_we_pull_out_is_not_warned_of(faster_kmh, side):
    # We are aside of it before its 4.5 s are over, by a change of lane of 3 s, in which we turn by ourselves.
    closing_mps = faster_kmh / 3.6
    lorry = VehiclePlan(
        name="lorry", gap_m=4 + 5.5 * closing_mps, speed_kmh=90.0 - faster_kmh, kind=VehicleKind.TRUCK
    )
    scenario = Scenario(
        description="We pull out behind a slower lorry.",
        duration_s=6.0,
        road=RoadPlan(lanes_left=1, lanes_right=1),
        ego=EgoPlan(speed_kmh=90.0, actions=(Action(at_s=1.0, lane=side, over_s=3.0),)),
        vehicles=(lorry,),
    )
    assert run_threat_trial(scenario, 0, make_policy()).passed


@pytest.mark.slow
def test_a_ghost_in_the_boxes_is_not_warned_of():
    trial = run_threat_trial(load_scenario("bonnet-and-logo"), 0, make_policy(), ghost=True)
    assert trial.passed


def test_from_pictures_the_tracker_is_told_how_we_nod_as_in_a_drive(monkeypatch):
    told = []

    class ToldTracker(Tracker):
        def update(self, time_ns, detections, ego=NOTHING_KNOWN, image=None):
            told.append(ego.body_pitch_rad)
            return super().update(time_ns, detections, ego, image)

    class Blind:
        name = "blind"

        def detect(self, image):
            return ()

    monkeypatch.setattr(threats, "Tracker", ToldTracker)
    run_threat_trial(replace(load_scenario("overlap-75"), duration_s=2.0), 0, make_policy(), Blind())
    assert any(told)


def test_from_pictures_a_detector_is_aimed_by_what_is_believed_of_the_mount_as_in_a_drive():
    class Aimed:
        name = "aimed"

        def __init__(self):
            self.aims = []

        def aim(self, aim):
            self.aims.append(aim.pitch_rad)

        def detect(self, image):
            return ()

    scenario, detector = replace(load_scenario("overlap-75"), duration_s=3.0), Aimed()
    camera = scenario.camera.camera()
    wrong_rad = camera.pitch_rad + math.radians(3.0)
    wrong = Calibration.from_camera(replace(camera, pitch_rad=wrong_rad), IMAGE_SIZE)
    pictures = list(render_drive(scenario, 0))
    run_threat_trial(scenario, 0, make_policy(), detector, calibration=wrong, pictures=pictures)
    assert len(detector.aims) == len(pictures)
    assert detector.aims[0] == wrong_rad
    assert camera.pitch_rad < detector.aims[-1] < wrong_rad - math.radians(0.5)


def test_every_danger_names_its_vehicle_and_every_scenario_says_what_happens():
    for name in threat_names():
        scenario = load_scenario(name)
        assert scenario.description.endswith(".")
        assert scenario.danger in {"", *(vehicle.name for vehicle in scenario.vehicles)}
