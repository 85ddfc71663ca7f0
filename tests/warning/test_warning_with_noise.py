"""Tracker and policy together, on boxes with the errors that `BoxNoise` states, from a car that pitches."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration, matrix3
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker, TrackerSettings
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

pytestmark = pytest.mark.slow

FOCAL_PX = 740.0
CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.03, FOCAL_PX, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=1.5
)
SETTINGS = TrackerSettings()
MPS_PER_MPH = 0.44704
BOUNCE_SIGMA_RAD, BOUNCE_CORRELATION_S = math.radians(0.25), 0.3
"""Of a body on its springs, on an ordinary road."""


class NoisyView:
    """Boxes of a vehicle ahead, their edges and the pitch off by correlated noise."""

    def __init__(self, seed, dt_s):
        self.rng = np.random.default_rng(seed)
        self.keep_box = math.exp(-dt_s / SETTINGS.box_noise.correlation_s)
        self.keep_bounce = math.exp(-dt_s / BOUNCE_CORRELATION_S)
        self.edges, self.bounce = self.rng.standard_normal(4), self.rng.standard_normal()

    def see(self, distance_m):
        rng = self.rng
        self.edges = self.keep_box * self.edges + math.sqrt(1 - self.keep_box**2) * rng.standard_normal(4)
        self.bounce = (
            self.keep_bounce * self.bounce + math.sqrt(1 - self.keep_bounce**2) * rng.standard_normal()
        )
        box = CALIBRATION.ground_box(distance_m, 0.0, 1.8, 1.5)
        left, right, top, bottom = SETTINGS.box_noise.edge_sigma_px(box) * self.edges
        shift = FOCAL_PX * BOUNCE_SIGMA_RAD * self.bounce
        return Detection(
            Box(box.x + left, box.y + top + shift, box.w + right - left, box.h + bottom - top), 1.0
        )


def states(view, distances_m, dt_s, ego_mps, calibration=CALIBRATION):
    tracker, policy, ego = Tracker(calibration), make_policy(), assumed_ego(ego_mps)
    for frame, distance_m in enumerate(distances_m):
        time_ns = round(frame * dt_s * 1e9)
        tracks = tracker.update(time_ns, [view.see(distance_m)], ego)
        yield policy.update(time_ns, threats_of(tracker, tracks, ego), ego_mps)


@pytest.mark.slow
@pytest.mark.parametrize("distance_m", [10.0, 25.0, 60.0])
def test_following_at_a_constant_gap_raises_no_warning_an_hour_long(distance_m):
    # Twenty minutes at each of three gaps.
    dt_s = 0.1
    gaps = (distance_m for _ in range(12_000))
    levels = {state.level for state in states(NoisyView(5, dt_s), gaps, dt_s, 25.0)}
    assert WarningLevel.WARNING not in levels


def test_nhtsa_standing_lead_at_45_mph_seen_from_100_m_is_warned_of_in_time_in_5_of_7_trials():
    dt_s, ego_mps, trials = 1 / 30, 45 * MPS_PER_MPH, 21
    passed = 0
    for seed in range(trials):
        gaps = np.arange(100.0, 5.0, -ego_mps * dt_s)
        for gap_m, state in zip(gaps, states(NoisyView(seed, dt_s), gaps, dt_s, ego_mps), strict=True):
            if state.level == WarningLevel.WARNING:
                passed += gap_m / ego_mps >= 2.1
                break
    assert passed >= trials * 5 / 7


def test_the_first_second_of_a_track_raises_nothing_when_the_gap_is_constant():
    dt_s = 1 / 30
    for seed in range(100):
        gap_m = 8.0 + seed / 2
        levels = [state.level for state in states(NoisyView(seed, dt_s), [gap_m] * 30, dt_s, 10.0)]
        assert max(levels) == WarningLevel.NONE


@pytest.mark.parametrize("gap_m", [15.0, 30.0])
def test_a_lead_braking_at_0_4_g_is_warned_of_before_a_crash_every_time(gap_m):
    dt_s, braking_mps2 = 1 / 30, 0.4 * 9.80665
    times_s = np.arange(0.0, math.sqrt(2 * (gap_m - 1) / braking_mps2), dt_s)
    gaps = [gap_m] * 60 + [gap_m - braking_mps2 * time_s**2 / 2 for time_s in times_s]
    for seed in range(10):
        levels = [state.level for state in states(NoisyView(seed, dt_s), gaps, dt_s, 20.0)]
        assert max(levels[:60]) <= WarningLevel.ADVISORY
        assert WarningLevel.WARNING in levels


def rough(scale):
    """The same camera with another lens than it has, known to 40 %."""
    camera = CALIBRATION.camera
    assumed = replace(camera, focal_y_px=scale * FOCAL_PX, pitch_rad=math.atan(math.tan(0.03) / scale))
    calibration = Calibration.from_camera(assumed, CALIBRATION.image_size, reference_offset_m=1.5)
    depths_m = np.array(calibration.support_distances_m) + 1.5 + assumed.pole_m
    below_px = assumed.row_scale_m_px / depths_m
    return replace(calibration, covariance=matrix3(0.4**2 * np.outer(below_px, below_px) + 2.0**2))


@pytest.mark.parametrize("seed", [3, 4, 5])
@pytest.mark.parametrize("scale", [0.7, 1.0, 1.4])
def test_a_standing_lead_is_warned_of_as_soon_however_little_is_known_of_the_lens(scale, seed):
    """The lens makes distance and closing speed wrong alike: the time to contact stays what it is."""
    dt_s, own_mps = 1 / 30, 25.0
    gaps = np.arange(75.0, 3.0, -own_mps * dt_s)

    def warned_at_s(calibration):
        shown = states(NoisyView(seed, dt_s), gaps, dt_s, None, calibration)
        levels = (state.level for state in shown)
        return next(
            gap_m / own_mps
            for gap_m, level in zip(gaps, levels, strict=True)
            if level == WarningLevel.WARNING
        )

    assert warned_at_s(rough(scale)) == pytest.approx(warned_at_s(CALIBRATION), abs=0.25)
