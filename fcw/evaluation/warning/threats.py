"""Simulated dangers, and what only looks like one: whether each is warned of within its window.

Nobody acts in these scenarios: the vehicle that is named as the danger is hit. Its window ends when the
driver of 1.2 s and 0.4 g must be warned, or a second after it can be known, where that is later: a car that
pulls out right before us cannot be warned of before it does. It begins at a true time to collision of 4.5 s,
ISO 15623's 4 s and half a second. Where there is no danger no `warning` may come at all.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection, Detector
from fcw.evaluation.distance.kitti import tracker_settings
from fcw.evaluation.motion.measured import MeasuredMotion
from fcw.evaluation.simulated import vehicle_at
from fcw.evaluation.warning.sights import SEEN_FRACTION, USUAL_SIGHT, Eye, Sight, part_seen
from fcw.frame import Frame
from fcw.motion.aiming import Aims, take_aim
from fcw.motion.ego import NOTHING_KNOWN, Ego, EgoEstimator
from fcw.pipeline import FRAMES_IN_FLIGHT
from fcw.simulation.drive import render_drive, true_calibration
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth, frame_truth
from fcw.simulation.world.scenario import IMAGE_SIZE, Scenario
from fcw.simulation.world.state import WorldState
from fcw.simulation.world.world import World
from fcw.threat.of_tracker import threats_of
from fcw.threat.threat import OWN_WIDTH_M
from fcw.tracking.tracker import Tracker
from fcw.warning.driver import EXPECTED_DRIVER
from fcw.warning.types import WarningLevel, WarningPolicy

EARLIEST_TTC_S = 4.5
KNOWN_S = 1.0
"""From when it is seen to be on a collision course until it must be warned of."""
NEAREST_M = 0.3
"""From here on it is hit: the end of the trial."""
GHOST_BOX = Box(430.0, 380.0, 420.0, 330.0)
"""A box as a reflection makes one: where a car 3 m ahead of the bumper would be."""
GHOST_S = 2.0, 5.0

Picture = tuple[Frame, FrameTruth]
"""Rendered, and what is true of it."""


@dataclass(frozen=True, slots=True)
class Window:
    """When a warning of a danger is right, in seconds of the scenario."""

    earliest_s: float
    latest_s: float
    contact_s: float


@dataclass(frozen=True, slots=True)
class ThreatTrial:
    """One run.

    Attributes:
        window: None where there is no danger.
        warned_s: when `warning` was first shown of the danger; None where it never was.
        cautioned_s: when `caution` or more was.
        false_s: when `warning` was shown of anything else, or before the window.
    """

    window: Window | None
    warned_s: float | None
    cautioned_s: float | None
    false_s: tuple[float, ...]

    @property
    def passed(self) -> bool:
        """Whether the danger was warned of in its window, or there was none; and nothing else was."""
        if self.window is None:
            return not self.false_s
        return self.warned_s is not None and self.warned_s <= self.window.latest_s and not self.false_s


class Seen(NamedTuple):
    """One frame.

    Attributes:
        image: (height, width, 3) BGR; None where there are boxes alone.
        truth: of it.
        detections: in it.
        ego: own motion and path as the picture tells them.
        in_sight: names of the vehicles that were found; from a picture, that could be.
    """

    image: NDArray[np.uint8] | None
    truth: FrameTruth
    detections: tuple[Detection, ...]
    ego: Ego
    in_sight: frozenset[str]


def run_threat_trial(
    scenario: Scenario,
    seed: int,
    policy: WarningPolicy,
    detector: Detector | None = None,
    ghost: bool = False,
    sight: Sight = USUAL_SIGHT,
    calibration: Calibration | None = None,
    pictures: Iterable[Picture] | None = None,
) -> ThreatTrial:
    """Run one scenario, with own motion by the picture; nobody gives the own speed.

    Args:
        scenario: what happens.
        seed: of everything that varies.
        policy: a fresh one.
        detector: finds the vehicles in rendered pictures, by the calibration that is believed in; without one
            their true boxes have 2 px of noise, and own motion the errors it was measured to have.
        ghost: whether a box 3 m ahead is there for three seconds that is none.
        sight: how well vehicles are found where there are no pictures.
        calibration: the one that is believed in; None for the true one.
        pictures: the scenario's, where they are rendered already.
    """
    calibration = calibration or true_calibration(scenario)
    tracker = Tracker(
        sight.calibration(calibration),
        None if detector else tracker_settings(sight.noise_px, at_tyres=True),
    )
    aims = Aims(tracker.believed_mount, FRAMES_IN_FLIGHT)
    if detector is None:
        moments = _seen_as_boxes(scenario, seed, sight)
    else:
        pictures = pictures or render_drive(scenario, seed)
        moments = seen_in_pictures(pictures, calibration, detector, aims)
    seen: list[Seen] = []
    shown: list[tuple[float, WarningLevel, VehicleTruth | None]] = []
    for one in moments:
        seen.append(one._replace(image=None))
        time_ns, detections = one.truth.time_ns, one.detections
        time_s = time_ns / 1e9
        if ghost and GHOST_S[0] <= time_s < GHOST_S[1]:
            detections = (*detections, Detection(GHOST_BOX, 1.0))
        tracks = tracker.update(time_ns, detections, one.ego, one.image)
        aims.believe(tracker.believed_mount)
        state = policy.update(time_ns, threats_of(tracker, tracks, one.ego), one.ego.motion.speed_mps)
        if state.level >= WarningLevel.CAUTION:
            track = next((track for track in tracks if track.track_id == state.track_id), None)
            shown.append((time_s, state.level, None if track is None else _vehicle(track.box, one.truth)))
    return _judge(scenario.danger, seen, shown)


def seen_in_pictures(
    pictures: Iterable[Picture], calibration: Calibration, detector: Detector, aims: Aims | None = None
) -> Iterator[Seen]:
    """Rendered pictures, searched, and asked for our own motion.

    Args:
        pictures: of a scenario.
        calibration: the one that is believed in.
        detector: looks where the aims say, as in a drive.
        aims: told after each frame what is believed of the mount; None where the detector stays as it is.
    """
    estimator = EgoEstimator(calibration)
    for frame, truth in pictures:
        if aims is not None:
            take_aim(detector, aims.next())
        detections = detector.detect(frame.image)
        others = [found.box for found in detections if not found.faint]
        ego = estimator.update(frame.time_ns, frame.image, others)
        yield Seen(frame.image, truth, detections, ego, _could_be_found(truth))


def danger_window(name: str, moments: Sequence[tuple[FrameTruth, bool]]) -> Window | None:
    """When a warning of the named vehicle is right; None where it is not hit.

    Args:
        name: of the vehicle.
        moments: truth of every frame, and whether the vehicle is in sight, up to when it is hit or passed.
    """
    path = [(t.time_ns / 1e9, v, sighted) for t, sighted in moments for v in t.vehicles if v.name == name]
    hit_s = next((time_s for time_s, v, _ in path if v.distance_m <= NEAREST_M), None)
    if hit_s is None and path and path[-1][0] < moments[-1][0].time_ns / 1e9:
        # It vanished below the bonnet, or we are past it.
        hit_s = path[-1][0]
    if hit_s is None:
        return None
    earliest_s = due_s = known_s = hit_s
    for (before_s, before, _), (time_s, vehicle, sighted) in pairwise(path):
        if time_s >= hit_s:
            break
        dt_s = time_s - before_s
        ttc_s = vehicle.ttc_s
        across_mps = (vehicle.path_lateral_m - before.path_lateral_m) / dt_s
        width_m = (vehicle.box.w / 1000.0 * (vehicle.distance_m + 1.6) + OWN_WIDTH_M) / 2
        then_m = math.inf if ttc_s is None else vehicle.path_lateral_m + across_mps * min(ttc_s, 4.0)
        if abs(then_m) >= width_m:
            known_s = hit_s
        elif sighted:
            known_s = min(known_s, time_s)
        if ttc_s is not None and ttc_s <= EARLIEST_TTC_S:
            earliest_s = min(earliest_s, time_s)
        closing_mps = vehicle.closing_speed_mps
        if closing_mps > 0 and vehicle.distance_m <= EXPECTED_DRIVER.needed_distance_m(closing_mps):
            due_s = min(due_s, time_s)
    return Window(earliest_s, min(max(due_s, known_s + KNOWN_S), hit_s), hit_s)


def _judge(
    danger: str,
    seen: Sequence[Seen],
    shown: Sequence[tuple[float, WarningLevel, VehicleTruth | None]],
) -> ThreatTrial:
    window = danger_window(danger, [(s.truth, danger in s.in_sight) for s in seen]) if danger else None
    end_s = math.inf if window is None else window.contact_s
    of_danger = [
        (time_s, level)
        for time_s, level, vehicle in shown
        if window is not None and time_s <= end_s and vehicle is not None and vehicle.name == danger
    ]
    warned_s = next((time_s for time_s, level in of_danger if level == WarningLevel.WARNING), None)
    false_s = [
        time_s
        for time_s, level, vehicle in shown
        if level == WarningLevel.WARNING
        and time_s <= end_s
        and vehicle is not None
        and (vehicle.name != danger or (window is not None and time_s < window.earliest_s))
    ]
    false_s += [
        time_s
        for time_s, level, vehicle in shown
        if level == WarningLevel.WARNING and vehicle is None and window is None
    ]
    return ThreatTrial(window, warned_s, of_danger[0][0] if of_danger else None, tuple(false_s[:1]))


def _seen_as_boxes(scenario: Scenario, seed: int, sight: Sight) -> Iterator[Seen]:
    camera, eye = scenario.camera.camera(), Eye(sight, seed)
    measured = MeasuredMotion(camera.pitch_rad, 0.0, np.random.default_rng([seed, 1]))
    ego = NOTHING_KNOWN
    states = list(World(scenario, seed).states())
    steps = list(pairwise(states))
    for state, step in zip(states, steps[:1] + steps, strict=True):
        truth = frame_truth(state, camera, IMAGE_SIZE, scenario.camera.reference_offset_m)
        if sight.own_motion:
            ego = measured.at(truth.time_ns, truth.ego_speed_mps, _yaw_rate_radps(*step))
        found = eye.see(truth)
        yield Seen(None, truth, tuple(found.values()), ego, frozenset(found))


def _could_be_found(truth: FrameTruth) -> frozenset[str]:
    return frozenset(
        vehicle.name
        for vehicle in truth.vehicles
        if part_seen(vehicle) >= SEEN_FRACTION and vehicle.distance_m < USUAL_SIGHT.farthest_m
    )


def _yaw_rate_radps(before: WorldState, after: WorldState) -> float:
    """How fast we turn, along the road and across it."""
    turned_rad = [
        float(state.road.heading_at(state.ego.s_m)) + state.ego.heading_rad for state in (before, after)
    ]
    return (turned_rad[1] - turned_rad[0]) / ((after.time_ns - before.time_ns) / 1e9)


def _vehicle(box: Box, truth: FrameTruth) -> VehicleTruth | None:
    """The vehicle at a box, by its near face or its whole body."""
    by_face = vehicle_at(box, truth)
    if by_face is not None:
        return by_face

    def shared(vehicle: VehicleTruth) -> float:
        body = vehicle.body_box
        width = min(body.right, box.right) - max(body.x, box.x)
        height = min(body.bottom, box.bottom) - max(body.y, box.y)
        return max(width, 0.0) * max(height, 0.0) / (box.w * box.h)

    best = max(truth.vehicles, key=shared, default=None)
    return best if best is not None and shared(best) > 0.3 else None


@dataclass(frozen=True, slots=True)
class ThreatResult:
    """All trials of one scenario."""

    name: str
    danger: str
    trials: tuple[ThreatTrial, ...]

    @property
    def trials_passed(self) -> int:
        """How many went as they should."""
        return sum(trial.passed for trial in self.trials)

    @property
    def false_warnings(self) -> int:
        """In how many there was a `warning` that should not have come."""
        return sum(bool(trial.false_s) for trial in self.trials)

    @property
    def lead_s(self) -> float | None:
        """Median of the time from the first `warning` to contact; None where there was none."""
        leads = [t.window.contact_s - t.warned_s for t in self.trials if t.window and t.warned_s is not None]
        return float(np.median(leads)) if leads else None


def run_threats(
    scenarios: Sequence[tuple[str, Scenario]],
    make_policy: Callable[[], WarningPolicy],
    seeds: Sequence[int],
    detector_of: Callable[[Scenario], Detector | None] = lambda scenario: None,
    on_trial: Callable[[], None] = lambda: None,
    sight: Sight = USUAL_SIGHT,
) -> tuple[ThreatResult, ...]:
    """Run every scenario with every seed; see `run_threat_trial`."""
    results = []
    for name, scenario in scenarios:
        trials = []
        for seed in seeds:
            detector = detector_of(scenario)
            trials.append(run_threat_trial(scenario, seed, make_policy(), detector, sight=sight))
            on_trial()
        results.append(ThreatResult(name, scenario.danger, tuple(trials)))
    return tuple(results)
