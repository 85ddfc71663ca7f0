"""When the warning comes: the scenarios of `ncap` run through the tracker and a policy.

The lead's rear is projected by a camera behind the windscreen, its box is given the noise of a detector,
and the tracker works with a calibration made from three noisy clicks. No pictures: what is measured is
ranging and warning, at the level of boxes.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.detection.detector import Detection
from fcw.evaluation.distance.kitti import BOTTOM_NOISE_RATIO, tracker_settings
from fcw.evaluation.distance.kitti_tracking import CALIBRATION_POINTS_M
from fcw.evaluation.warning.ncap import TRIALS, Scenario
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.warning.driver import SLOWEST_DRIVER
from fcw.warning.types import WarningLevel, WarningPolicy, WarningState

FRAME_RATE_HZ = 30.0
IMAGE_SIZE = ImageSize(1242, 375)
CAMERA = GroundPlaneCamera(
    pitch_rad=0.0, focal_y_px=721.5, principal_row_px=172.9, height_m=1.65, principal_column_px=620.5
)
"""KITTI's: the noise of the boxes is stated for its pictures."""
REFERENCE_OFFSET_M = 1.7
"""From the camera forward to the bumper: gaps and TTC are from there."""
CLICK_SIGMA_PX = 1.0
CAR_WIDTH_M = (1.65, 1.90)
"""Each trial's lead is somewhere between."""
CAR_HEIGHT_M = 1.45
SIGHT_M = 120.0
"""From the camera: farther vehicles are not detected."""
NEAREST_M = 2.0
"""Gap at which a trial ends: too late for any warning."""

LONGEST_TTC_S = 4.0
"""ISO 15623 needs no warning above this TTC."""

PolicyMaker = Callable[[], WarningPolicy]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxLevel:
    """How vehicles are seen at the level of boxes.

    Attributes:
        box_noise_px: 1-sigma of the sides and the upper edge, 1.5 times that of the lower one.
        sight_m: the farthest vehicle that is detected, from the camera.
        frame_rate_hz: pictures a second.
        own_speed_known: whether the own speed is known.
    """

    box_noise_px: float = 2.0
    sight_m: float = SIGHT_M
    frame_rate_hz: float = FRAME_RATE_HZ
    own_speed_known: bool = True

    def calibration(self, rng: np.random.Generator) -> Calibration:
        """What a person makes of the camera with three clicks, measured from the bumper."""
        points = []
        for distance_m in CALIBRATION_POINTS_M:
            row_px = CAMERA.row_at(distance_m + REFERENCE_OFFSET_M) + CLICK_SIGMA_PX * rng.standard_normal()
            points.append(GroundPoint(distance_m, row_px))
        return calibrate(
            points, IMAGE_SIZE, CAMERA.height_m, REFERENCE_OFFSET_M, CLICK_SIGMA_PX, tape_error=0.0
        )

    def tracker(self, rng: np.random.Generator) -> Tracker:
        """A tracker told of the noise, with a calibration of its own."""
        return Tracker(self.calibration(rng), tracker_settings(self.box_noise_px))

    def see(
        self, gap_m: float, width_m: float, rng: np.random.Generator, lateral_m: float = 0.0
    ) -> tuple[Detection, ...]:
        """The rear of a vehicle as a detector sees it, cut at the picture's border; none beyond sight."""
        distance_m = gap_m + REFERENCE_OFFSET_M
        noise_px = self.box_noise_px * np.array([1.0, 1.0, 1.0, BOTTOM_NOISE_RATIO]) * rng.standard_normal(4)
        if distance_m > self.sight_m:
            return ()
        box = CAMERA.ground_box(distance_m, lateral_m, width_m, CAR_HEIGHT_M)
        left, top, right, bottom = (np.array([box.x, box.y, box.right, box.bottom]) + noise_px).tolist()
        left, right = max(left, 0.0), min(right, IMAGE_SIZE.width - 1.0)
        top, bottom = max(top, 0.0), min(bottom, IMAGE_SIZE.height - 1.0)
        if right - left < 2 or bottom - top < 2:
            return ()
        return (Detection(Box(left, top, right - left, bottom - top), 1.0),)


def warning_states(
    gaps: Iterable[tuple[float, float]],
    own_mps: float | None,
    width_m: float,
    policy: WarningPolicy,
    tracker: Tracker,
    view: BoxLevel,
    rng: np.random.Generator,
    lateral_m: float = 0.0,
) -> Iterator[tuple[float, WarningState]]:
    """Time and the warning shown, for pairs of time and gap of one vehicle ahead, `lateral_m` to the left."""
    ego = assumed_ego(own_mps if view.own_speed_known else None)
    for time_s, gap_m in gaps:
        time_ns = round(time_s * 1e9)
        tracks = tracker.update(time_ns, view.see(gap_m, width_m, rng, lateral_m), ego)
        yield time_s, policy.update(time_ns, threats_of(tracker, tracks, ego), ego.motion.speed_mps)


@dataclass(frozen=True, slots=True)
class Trial:
    """One run of a scenario.

    Attributes:
        warned_s: when `warning` was shown first; None where it never was.
        ttc_s: true TTC then; None where not warned, or not closing.
        gap_m: true gap then.
        impact_mps: speed of impact of the driver who is warned then, 0 where the crash is avoided.
        passed: whether the warning came in time.
        needless: whether it came before even ISO's slowest and gentlest driver needed it, and above the
            TTC of 4 s from which ISO needs no warning.
    """

    warned_s: float | None
    ttc_s: float | None
    gap_m: float | None
    impact_mps: float
    passed: bool
    needless: bool


def run_trial(scenario: Scenario, make_policy: PolicyMaker, view: BoxLevel, seed: int, number: int) -> Trial:
    """Run a scenario until the first `warning`."""
    rng = np.random.default_rng([seed, number, *scenario.name.encode()])
    tracker, policy = view.tracker(rng), make_policy()
    width_m = float(rng.uniform(*CAR_WIDTH_M))
    times_s = np.arange(0.0, scenario.crash_s, 1 / view.frame_rate_hz)
    gaps_m = scenario.gap_at(times_s)
    times_s, gaps_m = times_s[gaps_m > NEAREST_M], gaps_m[gaps_m > NEAREST_M]
    pairs = zip(times_s.tolist(), gaps_m.tolist(), strict=True)
    states = warning_states(pairs, scenario.own_mps, width_m, policy, tracker, view, rng, scenario.offset_m)
    for time_s, state in states:
        if state.level == WarningLevel.WARNING:
            return judge(scenario, time_s)
    return judge(scenario, None)


def judge(scenario: Scenario, warned_s: float | None) -> Trial:
    """What a first `warning` at that time is worth."""
    impact_mps = scenario.impact_mps(warned_s)
    if warned_s is None:
        return Trial(None, None, None, impact_mps, passed=False, needless=False)
    gap_m = float(scenario.gap_at(np.array([warned_s]))[0])
    closing_mps = float(scenario.closing_at(np.array([warned_s]))[0])
    ttc_s = gap_m / closing_mps if closing_mps > 0 else None
    if scenario.required_ttc_s is None:
        passed = impact_mps == 0
    else:
        # Not closing yet is earlier than any TTC.
        passed = ttc_s is None or ttc_s >= scenario.required_ttc_s
    return Trial(warned_s, ttc_s, gap_m, impact_mps, passed, _needless(scenario, warned_s, ttc_s))


def _needless(scenario: Scenario, warned_s: float, ttc_s: float | None) -> bool:
    latest_s = scenario.latest_warning_s(SLOWEST_DRIVER)
    early = warned_s < (scenario.danger_s if latest_s is None else latest_s)
    return early and (ttc_s is None or ttc_s > LONGEST_TTC_S)


@dataclass(frozen=True, slots=True)
class ScenarioResult:
    """The trials of one scenario.

    Attributes:
        scenario: which.
        trials: `TRIALS` of them.
    """

    scenario: Scenario
    trials: tuple[Trial, ...]

    @property
    def trials_passed(self) -> int:
        """How many were warned in time."""
        return sum(trial.passed for trial in self.trials)

    def median(self, name: str) -> float | None:
        """Median of a field of the trials that were warned; None where none was."""
        values = [value for trial in self.trials if (value := getattr(trial, name)) is not None]
        return float(np.median(values)) if values else None


def run_scenarios(
    scenarios: Sequence[Scenario],
    make_policy: PolicyMaker,
    view: BoxLevel,
    seed: int,
    on_trial: Callable[[], None] = lambda: None,
) -> tuple[ScenarioResult, ...]:
    """Run every scenario `TRIALS` times; the noise of a trial depends on its seed, number and name only."""
    results = []
    for scenario in scenarios:
        trials = []
        for number in range(TRIALS):
            trials.append(run_trial(scenario, make_policy, view, seed, number))
            on_trial()
        results.append(ScenarioResult(scenario, tuple(trials)))
    return tuple(results)
