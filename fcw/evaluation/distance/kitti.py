"""Distances and closing speeds of the tracker against KITTI's 3D boxes, beside two plain methods.

The tracker gets every labelled vehicle of a frame as a detection, with noise, as a detector would see it;
only those in the own path, from behind and in full sight are measured. The camera is calibrated as a person
does it, from three points with a pixel of noise.

Few tracks hold most samples, so a sample counts by one over the number of its track's samples in the range,
and intervals are by bootstrap over tracks.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fcw.box import Box, iou
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import FloatArray
from fcw.detection.detector import Detection
from fcw.evaluation.distance.ablation import without_cues
from fcw.evaluation.distance.cues import Cue
from fcw.evaluation.distance.kitti_tracking import (
    KittiSequence,
    KittiVehicle,
    read_own_motion,
    read_sequence,
    time_ns,
)
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise
from fcw.tracking.tracker import Tracker, TrackerSettings
from fcw.tracking.types import Track
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

BOTTOM_NOISE_RATIO = 1.5
"""The lower edge, in shadow and tyres, is found less well than the others."""
CONSTANT_WIDTH_M = 1.70
"""Of every vehicle, by the plain method of widths."""
MATCH_IOU = 0.5
CLOSING_AGE_S = 1.0
"""Closing speeds count from this age of a track."""
TRUE_SPEED_HALF_WINDOW_S = 0.5
"""The true closing speed is the slope of a parabola through the true distances this near in time: the 3D
boxes are set by hand and shake by centimetres."""
RANGES_M = {
    "all": (4.0, 80.0),
    "5-15": (5.0, 15.0),
    "15-30": (15.0, 30.0),
    "30-50": (30.0, 50.0),
    "50-80": (50.0, 80.0),
}
BOOTSTRAP_DRAWS = 1000


@dataclass(frozen=True, slots=True)
class DistanceSample:
    """One measured vehicle in one frame.

    Attributes:
        sequence: name of the drive.
        frame: its number there.
        track: the vehicle's true identity in the drive.
        true_m: true distance.
        estimated_m: distance by the tracker.
        low_m: 16th percentile by the tracker.
        high_m: 84th percentile by the tracker.
        true_closing_mps: true closing speed.
        estimated_closing_mps: closing speed by the tracker.
        age_s: how long the tracker has followed it.
        row_m: distance by the lower edge of the same box alone.
        width_m: distance by the width of the same box alone, every vehicle being 1.70 m wide.
    """

    sequence: str
    frame: int
    track: int
    true_m: float
    estimated_m: float
    low_m: float
    high_m: float
    true_closing_mps: float
    estimated_closing_mps: float
    age_s: float
    row_m: float
    width_m: float


@dataclass(frozen=True, slots=True)
class RangeErrors:
    """Relative distance errors of one method in one range, as fractions, weighted by track.

    Attributes:
        n: samples.
        tracks: vehicles they belong to.
        median: median error.
        median_low: 2.5 % of the bootstrap over tracks.
        median_high: 97.5 % of it.
        mean: mean error; inf where a method gave no distance.
        p90: nine of ten errors are smaller.
    """

    n: int
    tracks: int
    median: float
    median_low: float
    median_high: float
    mean: float
    p90: float


def detections_of(
    vehicles: Iterable[KittiVehicle], image_size: ImageSize, box_noise_px: float, rng: np.random.Generator
) -> list[Detection]:
    """The labelled boxes with noise on their edges, cut at the picture's border, as a detector gives them."""
    sigmas = box_noise_px * np.array([1.0, 1.0, 1.0, BOTTOM_NOISE_RATIO])
    found = []
    for vehicle in vehicles:
        box = vehicle.box
        left, top, right, bottom = (
            np.array([box.x, box.y, box.right, box.bottom]) + sigmas * rng.standard_normal(4)
        ).tolist()
        left, right = max(left, 0.0), min(right, image_size.width - 1.0)
        top, bottom = max(top, 0.0), min(bottom, image_size.height - 1.0)
        # A detector has a smallest window.
        found.append(Detection(Box(left, top, max(right - left, 2.0), max(bottom - top, 2.0)), 1.0))
    return found


def tracker_settings(box_noise_px: float, at_tyres: bool = False) -> TrackerSettings:
    """The tracker's own settings, told how good this detector's boxes are.

    Args:
        box_noise_px: 1-sigma of the edges, 1.5 times that of the lower one.
        at_tyres: whether boxes end where tyres meet the road. KITTI's show the 3D boxes to a pixel, and so
            end at the rear.
    """
    side_px = max(box_noise_px, 0.5)
    return TrackerSettings(
        box_noise=BoxNoise(
            edge_floor_px=side_px,
            edge_fraction=0.0,
            bottom_ratio=BOTTOM_NOISE_RATIO,
            correlation_s=0.0,
            width_bias_sigma=0.0,
            at_tyres=at_tyres,
        )
    )


def sample_sequence(
    sequence: KittiSequence,
    speeds_mps: FloatArray,
    rng: np.random.Generator,
    box_noise_px: float,
    without: Sequence[Cue] = (),
    pitch_error_rad: float = 0.0,
    model: RangeModel | None = None,
) -> tuple[list[DistanceSample], list[tuple[str, int, int]]]:
    """Calibrate, run the tracker over a sequence, and compare it with the truth.

    Args:
        sequence: the labels and the camera.
        speeds_mps: own speed at each frame.
        rng: of the clicks and the boxes.
        box_noise_px: 1-sigma of the edges, 1.5 times that of the lower one.
        without: cues that the tracker does without.
        pitch_error_rad: of the calibration; see `KittiSequence.calibration`.
        model: beliefs of the tracker; None for its own.

    Returns:
        The samples; and sequence, frame and true track of each frame with a `warning` by the default policy
        that is about a measured vehicle.
    """
    policy, warnings = make_policy(), []
    calibration = sequence.calibration(rng, pitch_error_rad=pitch_error_rad)
    settings = tracker_settings(box_noise_px)
    if model is not None:
        settings = replace(settings, model=model)
    tracker = Tracker(calibration, without_cues(settings, without))
    closing = _true_closing_speeds(sequence.frames)
    samples = []
    for frame, vehicles in enumerate(sequence.frames):
        detections = detections_of(vehicles, sequence.image_size, box_noise_px, rng)
        own_mps = float(speeds_mps[frame]) if frame < len(speeds_mps) else None
        ego = assumed_ego(None if "ego-speed" in without else own_mps)
        tracks = tracker.update(time_ns(frame), detections, ego)
        warning = policy.update(time_ns(frame), threats_of(tracker, tracks, ego), ego.motion.speed_mps)
        for vehicle, detection in zip(vehicles, detections, strict=True):
            track = _track_of(vehicle, tracks) if vehicle.is_measured else None
            if track is None:
                continue
            if warning.level == WarningLevel.WARNING and warning.track_id == track.track_id:
                warnings.append((sequence.name, frame, vehicle.track_id))
            box = detection.box
            samples.append(
                DistanceSample(
                    sequence=sequence.name,
                    frame=frame,
                    track=vehicle.track_id,
                    true_m=vehicle.rear_m,
                    estimated_m=track.distance_m,
                    low_m=track.distance_low_m,
                    high_m=track.distance_high_m,
                    true_closing_mps=closing[vehicle.track_id, frame],
                    estimated_closing_mps=track.closing_speed_mps,
                    age_s=track.age_s,
                    row_m=float(calibration.distance_at(box.bottom)),
                    width_m=distance_by_width_m(calibration, box, CONSTANT_WIDTH_M),
                )
            )
    return samples, warnings


def measured_vehicles(sequence: KittiSequence) -> int:
    """How many vehicles count, over all frames."""
    return sum(vehicle.is_measured for vehicles in sequence.frames for vehicle in vehicles)


@dataclass(frozen=True, slots=True)
class DistanceEvaluation:
    """What the tracker is worth on a set of sequences.

    Attributes:
        samples: one for each measured vehicle that was followed in a frame.
        warnings: sequence, frame and true track of each frame with a `warning` about a measured vehicle.
        measured: how many there were, followed or not.
        box_noise_px: noise of the boxes' sides.
        seed: of everything random.
    """

    samples: tuple[DistanceSample, ...]
    warnings: tuple[tuple[str, int, int], ...]
    measured: int
    box_noise_px: float
    seed: int

    def errors(self, method: str = "estimated_m") -> dict[str, RangeErrors]:
        """Errors by range; `method` is the field of `DistanceSample` with the distance."""
        by_range = {}
        for name, (low_m, high_m) in RANGES_M.items():
            chosen = [sample for sample in self.samples if low_m <= sample.true_m <= high_m]
            relative = np.array([abs(getattr(s, method) / s.true_m - 1) for s in chosen])
            by_range[name] = range_errors(relative, track_numbers(chosen), self.seed)
        return by_range

    def closing_speed_mae_mps(self, by_track: bool = True) -> float:
        """Mean absolute error of the closing speed of tracks older than 1 s; nan where there are none.

        Args:
            by_track: each track counts as much as any other; otherwise each sample.
        """
        chosen = [
            sample
            for sample in self.samples
            if sample.age_s > CLOSING_AGE_S and math.isfinite(sample.true_closing_mps)
        ]
        errors = np.array([abs(s.estimated_closing_mps - s.true_closing_mps) for s in chosen])
        if not len(errors):
            return math.nan
        return float(errors @ track_weights(track_numbers(chosen)) if by_track else errors.mean())

    def coverage(self) -> tuple[float, float, float]:
        """Part of the true distances inside the 1-sigma interval, with its 95 % interval."""
        inside = np.array([s.low_m <= s.true_m <= s.high_m for s in self.samples], float)
        tracks = track_numbers(self.samples)
        if not len(inside):
            return math.nan, math.nan, math.nan
        means = np.array([inside[tracks == track].mean() for track in range(tracks.max() + 1)])
        rng = np.random.default_rng(self.seed)
        draws = means[rng.integers(len(means), size=(BOOTSTRAP_DRAWS, len(means)))].mean(axis=1)
        low, high = np.quantile(draws, (0.025, 0.975))
        return float(means.mean()), float(low), float(high)


def evaluate_distance(
    folder: Path,
    names: Sequence[str],
    box_noise_px: float,
    seed: int,
    without: Sequence[Cue] = (),
    pitch_error_rad: float = 0.0,
    model: RangeModel | None = None,
) -> DistanceEvaluation:
    """Run the tracker over sequences of KITTI tracking, also without some of its cues, or wrongly calibrated.

    Raises:
        UserError: a file is missing or not as expected.
    """
    samples: list[DistanceSample] = []
    warnings: list[tuple[str, int, int]] = []
    measured = 0
    for name in names:
        sequence = read_sequence(folder, name)
        speeds_mps, _ = read_own_motion(folder, name)
        # A stream of its own for each sequence: leaving one out changes nothing in the others.
        rng = np.random.default_rng([seed, *name.encode()])
        found, warned = sample_sequence(
            sequence, speeds_mps, rng, box_noise_px, without, pitch_error_rad, model
        )
        samples += found
        warnings += warned
        measured += measured_vehicles(sequence)
    return DistanceEvaluation(tuple(samples), tuple(warnings), measured, box_noise_px, seed)


def track_numbers(samples: Sequence[DistanceSample]) -> np.ndarray:
    """(N,) a number from 0 for each sample's vehicle."""
    numbers: dict[tuple[str, int], int] = {}
    return np.array([numbers.setdefault((s.sequence, s.track), len(numbers)) for s in samples], int)


def track_weights(tracks: np.ndarray) -> FloatArray:
    """(N,) weights that sum to 1 and give each track as much as any other."""
    if not len(tracks):
        return np.zeros(0)
    counts = np.bincount(tracks)
    return 1 / (counts[tracks] * np.count_nonzero(counts))


def weighted_quantile(values: FloatArray, weights: FloatArray, part: float) -> float:
    """The value that `part` of the weight does not exceed; there is at least one."""
    return float(np.quantile(values, part, weights=weights, method="inverted_cdf"))


def range_errors(relative: FloatArray, tracks: np.ndarray, seed: int) -> RangeErrors:
    """Statistics of relative errors, each with the number of its track."""
    weights = track_weights(tracks)
    if not len(relative):
        return RangeErrors(0, 0, *(math.nan,) * 5)
    rng, count = np.random.default_rng(seed), int(tracks.max()) + 1
    medians = [
        weighted_quantile(relative, weights * np.bincount(drawn, minlength=count)[tracks], 0.5)
        for drawn in rng.integers(count, size=(BOOTSTRAP_DRAWS, count))
    ]
    low, high = np.quantile(medians, (0.025, 0.975))
    return RangeErrors(
        n=len(relative),
        tracks=count,
        median=weighted_quantile(relative, weights, 0.5),
        median_low=float(low),
        median_high=float(high),
        mean=float(relative @ weights),
        p90=weighted_quantile(relative, weights, 0.9),
    )


def _track_of(vehicle: KittiVehicle, tracks: Sequence[Track]) -> Track | None:
    best = max(tracks, key=lambda track: iou(track.box, vehicle.box), default=None)
    return best if best is not None and iou(best.box, vehicle.box) >= MATCH_IOU else None


def distance_by_width_m(calibration: Calibration, box: Box, width_m: float) -> float:
    """Distance of a rear of known width that fills a box, by the calibrated focal length."""
    camera = calibration.camera
    depth_m = camera.focal_y_px * width_m / box.w
    return depth_m / math.cos(camera.pitch_rad) - camera.pole_m - calibration.reference_offset_m


def _true_closing_speeds(frames: Sequence[Sequence[KittiVehicle]]) -> dict[tuple[int, int], float]:
    """Closing speed by track and frame; nan where a vehicle was labelled too briefly to tell."""
    seen: dict[int, list[tuple[int, float]]] = {}
    for frame, vehicles in enumerate(frames):
        for vehicle in vehicles:
            seen.setdefault(vehicle.track_id, []).append((frame, vehicle.rear_m))
    closing = {}
    for track, pairs in seen.items():
        times_s = np.array([time_ns(frame) / 1e9 for frame, _ in pairs])
        distances_m = np.array([rear_m for _, rear_m in pairs])
        for (frame, _), time_s in zip(pairs, times_s, strict=True):
            near = np.abs(times_s - time_s) <= TRUE_SPEED_HALF_WINDOW_S
            powers = (times_s[near] - time_s)[:, None] ** np.arange(3)
            fit = np.linalg.lstsq(powers, distances_m[near])[0] if near.sum() > 3 else (0, math.nan)
            closing[track, frame] = -float(fit[1])
    return closing
