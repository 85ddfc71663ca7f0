"""Simulated vehicles at the level of boxes, to see whether the tracker's intervals are honest.

Everything random that ranging has to live with is drawn here by this module's own numbers and equations:
clicks, the lens, pitch, the road below the vehicle, its size and motion, and the edges of its boxes. A
1-sigma interval is honest when it holds the true distance in 68 % of the tracks.
"""

import math
from dataclasses import dataclass

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.solve import calibrate
from fcw.detection.detector import Detection
from fcw.errors import UserError
from fcw.evaluation.distance.kitti import BOTTOM_NOISE_RATIO
from fcw.evaluation.distance.kitti_tracking import CALIBRATION_POINTS_M
from fcw.frame import ImageSize
from fcw.tracking.tracker import Tracker, TrackerSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedRoad:
    """What is drawn for a track; each sigma is of a normal distribution.

    Attributes:
        focal_px: focal length.
        height_m: of the camera.
        principal_row_sigma: of the lens's axis about the picture's middle, as a part of its height.
        pitch_rad: of the camera below the horizontal, sigma.
        click_sigma_px: of a clicked row.
        mount_off_rad: how far the camera looks elsewhere in the drive than when it was calibrated, sigma:
            people park on ramps, load the boot, bump the mount.
        slow_pitch_rad: pitch by slopes and load, sigma, and for how long.
        fast_pitch_rad: pitch of the body, sigma, and for how long.
        bump_rad: road below the vehicle, sigma, and for how long.
        fleet_sigma: of the logarithm by which all vehicles of the place are wider.
        width_m: median width of a car's rear.
        width_sigma: of its logarithm.
        rear_height_m: median height of it.
        rear_height_sigma: of its logarithm.
        overhang_m: from the rear to where its tyres meet the road, mean and sigma.
        turned: sigma of the logarithm of the apparent width as vehicles turn, and for how long.
        acceleration_mps2: of the gap, sigma, and for how long.
    """

    focal_px: float = 720.0
    height_m: float = 1.5
    principal_row_sigma: float = 0.05
    pitch_rad: float = 0.02
    click_sigma_px: float = 1.0
    mount_off_rad: float = math.radians(0.5)
    slow_pitch_rad: tuple[float, float] = (math.radians(0.05), 20.0)
    fast_pitch_rad: tuple[float, float] = (math.radians(0.2), 0.5)
    bump_rad: tuple[float, float] = (math.radians(0.1), 0.5)
    fleet_sigma: float = 0.05
    width_m: float = 1.70
    width_sigma: float = 0.08
    rear_height_m: float = 1.50
    rear_height_sigma: float = 0.12
    overhang_m: tuple[float, float] = (0.75, 0.25)
    turned: tuple[float, float] = (0.03, 5.0)
    acceleration_mps2: tuple[float, float] = (1.5, 2.0)


IMAGE_SIZE = ImageSize(1280, 720)
FRAME_S = 0.1
TRACK_S = 6.0
START_M = (10.0, 60.0)
CLOSING_SIGMA_MPS = 5.0
NEAREST_M, FARTHEST_M = 4.0, 80.0


@dataclass(frozen=True, slots=True)
class SimulatedCoverage:
    """How honest the intervals of simulated tracks are.

    Attributes:
        tracks: that were followed to their end.
        part: of them with the true distance inside the 1-sigma interval at their end.
        median_error: median relative error there.
        closing_speed_mae_mps: mean absolute error of the closing speed there.
    """

    tracks: int
    part: float
    median_error: float
    closing_speed_mae_mps: float


def simulate_coverage(
    tracks: int,
    seed: int,
    settings: TrackerSettings,
    box_noise_px: float,
    road: SimulatedRoad | None = None,
) -> SimulatedCoverage:
    """Follow simulated vehicles, each with a camera, a calibration and a road of its own.

    Args:
        tracks: how many.
        seed: of everything drawn.
        settings: of the tracker, told of the noise of the boxes.
        box_noise_px: sigma of the edges, 1.5 times that of the lower one.
        road: what is drawn.
    """
    rng, road = np.random.default_rng(seed), road or SimulatedRoad()
    inside: list[bool] = []
    relative: list[float] = []
    closing: list[float] = []
    while len(inside) < tracks:
        outcome = _follow_one(rng, settings, box_noise_px, road)
        if outcome is not None:
            inside.append(outcome[0])
            relative.append(outcome[1])
            closing.append(outcome[2])
    return SimulatedCoverage(
        len(inside), float(np.mean(inside)), float(np.median(relative)), float(np.mean(closing))
    )


class _Wandering:
    """A first-order Markov process about zero."""

    def __init__(self, rng: np.random.Generator, sigma_and_time: tuple[float, float]) -> None:
        self._rng = rng
        self._sigma, time_s = sigma_and_time
        self._lasting = math.exp(-FRAME_S / time_s)
        self.value = self._sigma * rng.standard_normal()

    def step(self) -> None:
        """Move on by a frame."""
        fresh = self._sigma * math.sqrt(1 - self._lasting**2) * self._rng.standard_normal()
        self.value = self._lasting * self.value + fresh


def _follow_one(
    rng: np.random.Generator, settings: TrackerSettings, box_noise_px: float, road: SimulatedRoad
) -> tuple[bool, float, float] | None:
    """Inside or not, relative error and error of the closing speed at the end; None for one that got away."""
    middle_px = (IMAGE_SIZE.height - 1) / 2
    axis_px = middle_px + road.principal_row_sigma * IMAGE_SIZE.height * rng.standard_normal()
    pitch_rad = road.pitch_rad * rng.standard_normal()

    def row(distance_m: float, above_m: float, moved_rad: float) -> float:
        """Row of a point at a height above the road, the camera pitched down by a little more."""
        below_rad = math.atan2(road.height_m - above_m, distance_m)
        return axis_px + road.focal_px * math.tan(below_rad - pitch_rad - moved_rad)

    clicks = [
        GroundPoint(d, row(d, 0.0, 0.0) + road.click_sigma_px * rng.standard_normal())
        for d in CALIBRATION_POINTS_M
    ]
    try:
        calibration: Calibration = calibrate(
            clicks, IMAGE_SIZE, road.height_m, row_sigma_px=road.click_sigma_px, tape_error=0.0
        )
    except UserError:  # clicks that no camera could see: the person would click again
        return None
    slow, fast = _Wandering(rng, road.slow_pitch_rad), _Wandering(rng, road.fast_pitch_rad)
    bump, turned = _Wandering(rng, road.bump_rad), _Wandering(rng, road.turned)
    acceleration = _Wandering(rng, road.acceleration_mps2)
    log_width = road.width_sigma * rng.standard_normal() + road.fleet_sigma * rng.standard_normal()
    width_m = road.width_m * math.exp(log_width)
    rear_height_m = road.rear_height_m * math.exp(road.rear_height_sigma * rng.standard_normal())
    overhang_m = road.overhang_m[0] + road.overhang_m[1] * rng.standard_normal()
    mount_off_rad = road.mount_off_rad * rng.standard_normal()
    distance_m, closing_mps = rng.uniform(*START_M), CLOSING_SIGMA_MPS * rng.standard_normal()
    tracker, tracks = Tracker(calibration, settings), ()
    for frame in range(round(TRACK_S / FRAME_S) + 1):
        if frame:
            for process in (slow, fast, bump, turned, acceleration):
                process.step()
            distance_m -= closing_mps * FRAME_S + acceleration.value * FRAME_S**2 / 2
            closing_mps += acceleration.value * FRAME_S
        if not NEAREST_M <= distance_m <= FARTHEST_M:
            return None
        moved_rad = mount_off_rad - (slow.value + fast.value + bump.value)
        depth_m = distance_m * math.cos(pitch_rad) + road.height_m * math.sin(pitch_rad)
        half_px = road.focal_px * width_m * math.exp(turned.value) / depth_m / 2
        center_px = (IMAGE_SIZE.width - 1) / 2
        left, top, right, bottom = (
            np.array(
                [
                    center_px - half_px,
                    row(distance_m, rear_height_m, moved_rad),
                    center_px + half_px,
                    row(distance_m + overhang_m, 0.0, moved_rad),
                ]
            )
            + box_noise_px * np.array([1.0, 1.0, 1.0, BOTTOM_NOISE_RATIO]) * rng.standard_normal(4)
        ).tolist()
        bottom = min(bottom, IMAGE_SIZE.height - 1.0)
        box = Box(left, top, max(right - left, 2.0), max(bottom - top, 2.0))
        tracks = tracker.update(round(frame * FRAME_S * 1e9), [Detection(box, 1.0)])
    if len(tracks) != 1:
        return None
    track = tracks[0]
    return (
        track.distance_low_m <= distance_m <= track.distance_high_m,
        abs(track.distance_m / distance_m - 1),
        abs(track.closing_speed_mps - closing_mps),
    )
