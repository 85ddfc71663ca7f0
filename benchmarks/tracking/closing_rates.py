"""How well the tracker knows how fast vehicles come nearer, and what other settings would make of it.

    python benchmarks/tracking/closing_rates.py [--scenario NAME ...] [--seeds 1]
        [--instead box_noise.edge_fraction=0.025,box_noise.correlation_s=0.035 ...]

Simulated dangers, and what only looks like one, are rendered and searched by the default detector. The
tracker as it is, and one with each of the settings given, see the same pictures and boxes. The rate is
closing speed by distance from the camera, one over the time to contact; errors beyond 0.5 a second count as
that. Counted is every vehicle in every frame in which all trackers follow it: a tracker that loses vehicles
beside us, of which most errors come, would pass for a better one otherwise. In our way is what has its middle
within 2.2 m of our path, near what is nearer than 8 m. Takes half a minute for each scenario and seed.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fcw.box import Box, iou
from fcw.camera.ground_plane import FloatArray
from fcw.detection.choice import load_model, make_detector
from fcw.evaluation.warning.threats import seen_in_pictures
from fcw.simulation.drive import render_drive, true_calibration
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth
from fcw.simulation.world.scenario import load_scenario, threat_names
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track

YOUNGEST_S = 0.5
"""A track is judged from this age on."""
LEAST_IOU = 0.3
NEAREST_M, NEAR_M, FARTHEST_M = 1.0, 8.0, 60.0
IN_WAY_M = 2.2
"""From our path to the middle of what can be in our way."""
MOST_PER_S = 0.5


class Error(NamedTuple):
    """Of one vehicle in one frame: its true place, and how far off its rate and log distance are."""

    true_m: float
    aside_m: float
    rate_per_s: float
    log_distance: float


def main() -> None:
    """Print a line for the tracker as it is, and one for each of the settings given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenario", nargs="+", choices=threat_names(), default=threat_names())
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--instead", nargs="+", default=[], help="FIELD=VALUE,... of TrackerSettings")
    given = parser.parse_args()
    names = ["as it is", *given.instead]
    try:
        settings = [TrackerSettings(), *map(with_values, given.instead)]
    except (AttributeError, TypeError, ValueError) as error:
        parser.error(f"--instead: {error}; expected FIELD=VALUE,... as in box_noise.edge_fraction=0.025")
    if given.seeds < 1:
        parser.error(f"--seeds {given.seeds}: expected 1 or more")
    runs = [run(name, seed, settings) for name in given.scenario for seed in range(given.seeds)]
    if not sum(len(errors[0]) for errors in runs):
        sys.exit("there is no vehicle that all of these trackers follow")
    sys.stdout.write("frames   rates off by, rms, in our way, near   distance off by, median, 9 of 10\n")
    for name, errors in zip(names, map(np.concatenate, zip(*runs, strict=True)), strict=True):
        true_m, aside_m, _, log_distance = errors.T
        off, parts = np.abs(log_distance), (slice(None), aside_m <= IN_WAY_M, true_m < NEAR_M)
        told = ", ".join(f"{rms(errors[part]):.4f}" for part in parts)
        sys.stdout.write(
            f"{len(errors):6}   {told} /s {np.median(off):26.1%} {np.quantile(off, 0.9):8.1%}   {name}\n"
        )


def with_values(text: str) -> TrackerSettings:
    """The usual settings but for some numbers, by path: `model.aspect_sigma=0.02,coast_s=1`.

    Raises:
        AttributeError, TypeError, ValueError: it is no such text, or there is no such field.
    """
    settings = TrackerSettings()
    for pair in text.split(","):
        path, value = pair.split("=")
        part, _, field = path.rpartition(".")
        changed = replace(getattr(settings, part), **{field: float(value)}) if part else float(value)
        settings = replace(settings, **{part or field: changed})
    return settings


def run(name: str, seed: int, settings: Sequence[TrackerSettings]) -> list[FloatArray]:
    """Errors of each setting's tracker in one scenario, (N, 4), of the same vehicles and frames."""
    sys.stderr.write(f"{name}, seed {seed}\n")
    scenario = load_scenario(name)
    calibration = true_calibration(scenario)
    detector = make_detector("net", load_model("net"), calibration, for_tracker=True)
    trackers = [Tracker(calibration, one) for one in settings]
    found: list[dict[tuple[int, str], Error]] = [{} for _ in settings]
    pictures = render_drive(scenario, seed)
    for image, truth, detections, ego, _ in seen_in_pictures(pictures, calibration, detector):
        for tracker, errors in zip(trackers, found, strict=True):
            for track in tracker.update(truth.time_ns, detections, ego, image):
                vehicle = vehicle_of(track, truth)
                if vehicle is not None:
                    error = error_of(track, vehicle, calibration.reference_offset_m)
                    errors[truth.time_ns, vehicle.name] = error
    common = sorted(set[tuple[int, str]].intersection(*map(set, found)))
    return [np.array([errors[key] for key in common]).reshape(-1, 4) for errors in found]


def vehicle_of(track: Track, truth: FrameTruth) -> VehicleTruth | None:
    """The vehicle that a track follows, by its near face or its whole body."""

    def shared(vehicle: VehicleTruth, box: Box = track.box) -> float:
        return max(iou(vehicle.box, box), iou(vehicle.body_box, box))

    best = max(truth.vehicles, key=shared, default=None)
    if best is None or track.age_s < YOUNGEST_S or shared(best) < LEAST_IOU:
        return None
    return best if NEAREST_M <= best.distance_m <= FARTHEST_M else None


def error_of(track: Track, vehicle: VehicleTruth, offset_m: float) -> Error:
    """Of a track; distances in the picture are from the camera, which is behind what they are told from."""
    told_m, true_m = track.distance_m + offset_m, vehicle.distance_m + offset_m
    rate_per_s = track.closing_speed_mps / told_m - vehicle.closing_speed_mps / true_m
    log_distance = float(np.log(told_m / true_m))
    return Error(vehicle.distance_m, abs(vehicle.path_lateral_m), rate_per_s, log_distance)


def rms(errors: FloatArray) -> float:
    """Root mean square of the errors of rates; not a number where there are none."""
    if not len(errors):
        return math.nan
    return float(np.sqrt(np.mean(np.minimum(np.abs(errors[:, 2]), MOST_PER_S) ** 2)))


if __name__ == "__main__":
    main()
