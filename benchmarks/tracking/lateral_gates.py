"""The constants of the lateral filter chosen on all sequences of KITTI tracking but one, for each in turn.

    python benchmarks/tracking/lateral_gates.py $FCW_DATA/kitti-tracking [--seed 0]

A choice is the best by the interval score (Gneiting & Raftery 2007, eq. 43) of the lateral speed of every
vehicle between 5 and 40 m, each vehicle counting as much as any other. The true one is the slope of the
labelled places half a second before and after. Prints the score of every candidate over all sequences, and
what is chosen when a sequence is left out.
"""

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from unittest.mock import patch

import numpy as np

from fcw.evaluation.distance.kitti import TRUE_SPEED_HALF_WINDOW_S
from fcw.evaluation.distance.kitti_tracking import KittiSequence, read_sequence, sequence_names, time_ns
from fcw.evaluation.distance.leave_one_out import OUTSIDE_PART
from fcw.evaluation.warning.false_alarms import SAME_EDGES_PX, kitti_threats
from fcw.tracking.across import lateral_filter, place_filter

JUMPS_SIGMAS = (3.0, 4.0, 6.0)
SETTLINGS_S = (0.25, 0.5, 1.0)
WRONG_BEFORE_PARTS = (0.5, 0.75, 0.85, 1.0)
BOX_NOISE_PX = 2.0
NEAREST_M, FARTHEST_M = 5.0, 40.0
FEWEST_PLACES = 5

Constants = tuple[float, float, float]
"""JUMP_SIGMAS, SETTLING_S and WRONG_BEFORE_PART."""


def true_speeds(sequence: KittiSequence) -> dict[tuple[int, int], float]:
    """Speed to the left by vehicle and frame, as seen from ours, where it is labelled for long enough."""
    places: dict[int, list[tuple[float, float]]] = defaultdict(list)
    for frame, vehicles in enumerate(sequence.frames):
        for vehicle in vehicles:
            places[vehicle.track_id].append((time_ns(frame) / 1e9, vehicle.lateral_m))
    speeds = {}
    for track_id, pairs in places.items():
        times_s, laterals_m = np.array(pairs).T
        for time_s in times_s:
            near = np.abs(times_s - time_s) <= TRUE_SPEED_HALF_WINDOW_S
            if near.sum() >= FEWEST_PLACES:
                slope_mps = float(np.polyfit(times_s[near] - time_s, laterals_m[near], 1)[0])
                speeds[track_id, round(time_s * 1e9)] = slope_mps
    return speeds


def scores(folder: Path, sequence: KittiSequence, seed: int) -> Iterator[float]:
    """Interval score of the lateral speed of each vehicle of a sequence."""
    true_mps, by_vehicle = true_speeds(sequence), defaultdict(list)
    for moment in kitti_threats(folder, sequence.name, BOX_NOISE_PX, seed):
        for track in moment.tracks:
            if track.coasting or not NEAREST_M <= track.distance_m <= FARTHEST_M:
                continue
            off_px = {
                v.track_id: (abs(v.box.x - track.box.x) + abs(v.box.right - track.box.right)) / 2
                for v in sequence.frames[moment.frame]
            }
            vehicle = min(off_px, key=off_px.__getitem__, default=None)
            if vehicle is None or off_px[vehicle] > SAME_EDGES_PX:
                continue
            truth_mps = true_mps.get((vehicle, time_ns(moment.frame)))
            if truth_mps is not None:
                sigma_mps = track.lateral_speed_sigma_mps
                outside_mps = max(abs(track.lateral_speed_mps - truth_mps) - sigma_mps, 0.0)
                by_vehicle[vehicle].append(2 * sigma_mps + 2 / OUTSIDE_PART * outside_mps)
    for values in by_vehicle.values():
        yield float(np.mean(values))


def main() -> None:
    """Score every candidate on every sequence, and choose."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    names = sequence_names(arguments.folder)
    sequences = {name: read_sequence(arguments.folder, name) for name in names}
    found: dict[tuple[Constants, str], list[float]] = {}
    jump_sigmas, settling_s = place_filter.JUMP_SIGMAS, place_filter.SETTLING_S
    part = lateral_filter.WRONG_BEFORE_PART
    gates = [(*pair, part) for pair in product(JUMPS_SIGMAS, SETTLINGS_S)]
    parts = [(jump_sigmas, settling_s, other) for other in WRONG_BEFORE_PARTS]
    candidates = list(dict.fromkeys(gates + parts))
    for constants in candidates:
        with (
            patch.object(place_filter, "JUMP_SIGMAS", constants[0]),
            patch.object(place_filter, "SETTLING_S", constants[1]),
            patch.object(lateral_filter, "WRONG_BEFORE_PART", constants[2]),
        ):
            for name in names:
                found[constants, name] = list(scores(arguments.folder, sequences[name], arguments.seed))
        pooled = [score for name in names for score in found[constants, name]]
        score_mps = float(np.mean(pooled))
        sys.stdout.write(f"{in_words(constants)}: {score_mps:.4f} m/s, {len(pooled)} vehicles\n")
    for left_out in names:

        def others(constants: Constants, left_out: str = left_out) -> float:
            return float(np.mean([s for name in names if name != left_out for s in found[constants, name]]))

        best = min(candidates, key=others)
        sys.stdout.write(f"without {left_out}: {in_words(best)}\n")


def in_words(constants: Constants) -> str:
    """For the report."""
    return "{:g} sigma, {:g} s, {:g} of what is wrong".format(*constants)


if __name__ == "__main__":
    main()
