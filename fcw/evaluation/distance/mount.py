"""Whether a mount that turns in mid-drive is told, and one that does not is left alone.

Simulated traffic at the level of boxes, three vehicles in sight, each for 5 s and more: the road, the
vehicles and the clicks of `fcw.evaluation.distance.simulation`, and every drive with a calibration anew.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from fcw.box import Box
from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import FloatArray
from fcw.camera.solve import calibrate
from fcw.detection.detector import Detection
from fcw.evaluation.distance.kitti import BOTTOM_NOISE_RATIO, tracker_settings
from fcw.evaluation.distance.kitti_tracking import CALIBRATION_POINTS_M
from fcw.evaluation.distance.simulation import FRAME_S, IMAGE_SIZE, SimulatedRoad
from fcw.tracking.tracker import Tracker

LANES_M = (0.0, 3.5, -3.5)
"""One vehicle straight ahead and one in each lane beside."""
DISTANCE_M = (10.0, 45.0)
SHORTEST_STAY_S, MEAN_STAY_S = 5.0, 30.0
"""A vehicle stays in sight for the first and an exponential time of the second in the mean."""
GAP_S = 1.5
"""Then nothing is there for so long: the next one is another vehicle to the tracker too."""
LENGTH_M = 4.2
TURNED_RAD = math.radians(0.5)
BEFORE_S, AFTER_S = 300.0, 300.0
SILENT_DRIVE_S = 1800.0


@dataclass(frozen=True, slots=True)
class MountResult:
    """What was said of mounts.

    Attributes:
        delays_s: after how long a turned mount was said, a trial each; None where it was not in 5 minutes.
        said_too_early: trials in which it was said before it turned.
        silent_hours: driven without a turn.
        false_alarms: drives of half an hour among them in which a turn was said.
    """

    delays_s: tuple[float | None, ...]
    said_too_early: int
    silent_hours: float
    false_alarms: int


def watch_mounts(
    trials: int,
    silent_hours: float,
    box_noise_px: float,
    seed: int,
    on_hours: Callable[[float], None] = lambda hours: None,
) -> MountResult:
    """Turn the mount by half a degree in mid-drive, up and down in turn; and drive without."""
    delays_s: list[float | None] = []
    too_early = false_alarms = 0
    for number in range(trials):
        turned_rad = TURNED_RAD * (1 if number % 2 else -1)
        rng = np.random.default_rng([seed, 0, number])
        said_s = first_said_s(rng, BEFORE_S + AFTER_S, box_noise_px, turned_rad, BEFORE_S)
        early = said_s is not None and said_s < BEFORE_S
        too_early += early
        delays_s.append(None if said_s is None or early else said_s - BEFORE_S)
        on_hours((BEFORE_S + AFTER_S) / 3600)
    drives = math.ceil(silent_hours * 3600 / SILENT_DRIVE_S)
    for number in range(drives):
        rng = np.random.default_rng([seed, 1, number])
        false_alarms += first_said_s(rng, SILENT_DRIVE_S, box_noise_px) is not None
        on_hours(SILENT_DRIVE_S / 3600)
    return MountResult(tuple(delays_s), too_early, drives * SILENT_DRIVE_S / 3600, false_alarms)


def first_said_s(
    rng: np.random.Generator,
    duration_s: float,
    box_noise_px: float,
    turned_rad: float = 0.0,
    turned_at_s: float = math.inf,
) -> float | None:
    """When a moved mount is first said in one drive; None where it is not.

    Args:
        rng: of everything drawn.
        duration_s: of the drive.
        box_noise_px: sigma of the edges, 1.5 times that of the lower one.
        turned_rad: how much lower the camera looks after the turn.
        turned_at_s: when.
    """
    road, size = SimulatedRoad(), IMAGE_SIZE
    count = round(duration_s / FRAME_S)
    times_s = np.arange(count) * FRAME_S
    axis_px = (size.height - 1) / 2 + road.principal_row_sigma * size.height * rng.standard_normal()
    pitch_rad = road.pitch_rad * rng.standard_normal()

    def rows(
        distance_m: FloatArray, above_m: FloatArray | float, moved_rad: FloatArray | float
    ) -> FloatArray:
        below_rad = np.arctan2(road.height_m - above_m, distance_m)
        return axis_px + road.focal_px * np.tan(below_rad - pitch_rad - moved_rad)

    off_px = road.click_sigma_px * rng.standard_normal(len(CALIBRATION_POINTS_M))
    clicked = rows(np.array(CALIBRATION_POINTS_M), 0.0, 0.0) + off_px
    points = [GroundPoint(d, float(row)) for d, row in zip(CALIBRATION_POINTS_M, clicked, strict=True)]
    calibration = calibrate(points, size, road.height_m, row_sigma_px=road.click_sigma_px, tape_error=0.0)
    common_rad = _wandering(rng, road.slow_pitch_rad, count) + _wandering(rng, road.fast_pitch_rad, count)
    common_rad -= np.where(times_s >= turned_at_s, turned_rad, 0.0)
    noise = np.array([1.0, 1.0, 1.0, BOTTOM_NOISE_RATIO]) * box_noise_px
    boxes = []
    for lane_m in LANES_M:
        distance_m, width_m, height_m = _vehicles(rng, road, count)
        moved_rad = -common_rad - _wandering(rng, road.bump_rad, count)
        depth_m = distance_m * math.cos(pitch_rad) + road.height_m * math.sin(pitch_rad)
        half_m = width_m * np.exp(_wandering(rng, road.turned, count)) / 2
        middle_px = (size.width - 1) / 2
        left = middle_px - road.focal_px * (lane_m + half_m) / depth_m
        right = middle_px - road.focal_px * (lane_m - half_m) / depth_m
        # A vehicle beside our path shows its inner side, which ends farther away.
        if lane_m > 0:
            right = middle_px - road.focal_px * (lane_m - half_m) / (depth_m + LENGTH_M)
        elif lane_m < 0:
            left = middle_px - road.focal_px * (lane_m + half_m) / (depth_m + LENGTH_M)
        edges = np.column_stack(
            (left, rows(distance_m, height_m, moved_rad), right, rows(distance_m, 0.0, moved_rad))
        )
        edges += noise * rng.standard_normal(edges.shape)
        boxes.append(np.clip(edges, 0.0, (size.width - 1.0, size.height - 1.0) * 2))
    tracker = Tracker(calibration, tracker_settings(box_noise_px))
    for frame, edges in enumerate(np.stack(boxes, axis=1).tolist()):
        found = [
            Detection(Box(x0, y0, x1 - x0, y1 - y0), 1.0)
            for x0, y0, x1, y1 in edges
            if x1 - x0 >= 2 and y1 - y0 >= 2
        ]
        tracker.update(round(frame * FRAME_S * 1e9), found)
        if tracker.mount.moved:
            return frame * FRAME_S
    return None


def _wandering(rng: np.random.Generator, sigma_and_time: tuple[float, float], count: int) -> FloatArray:
    """A first-order Markov process about zero, at every frame."""
    sigma, time_s = sigma_and_time
    lasting = math.exp(-FRAME_S / time_s)
    steps = sigma * math.sqrt(1 - lasting**2) * rng.standard_normal(count)
    steps[0] = sigma * rng.standard_normal()
    return np.asarray(lfilter([1.0], [1.0, -lasting], steps))


def _vehicles(
    rng: np.random.Generator, road: SimulatedRoad, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distance, width and height of the vehicle in sight at every frame, one after the other."""
    rows: list[FloatArray] = []
    frames = 0
    while frames < count:
        stay = round((SHORTEST_STAY_S + rng.exponential(MEAN_STAY_S)) / FRAME_S)
        width_m = road.width_m * math.exp(road.width_sigma * rng.standard_normal())
        height_m = road.rear_height_m * math.exp(road.rear_height_sigma * rng.standard_normal())
        rows.append(np.tile((rng.uniform(*DISTANCE_M), width_m, height_m), (stay, 1)))
        gap = round(GAP_S / FRAME_S)
        rows.append(np.tile((math.inf, width_m, height_m), (gap, 1)))
        frames += stay + gap
    distance_m, width_m, height_m = np.concatenate(rows)[:count].T
    return distance_m, width_m, height_m
