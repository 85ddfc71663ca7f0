"""Own motion by how fast we are, in rendered drives on an empty straight road.

    python benchmarks/motion/by_speed.py

After 1.5 s of each drive: the median of speed over true speed less one, how sure it was said to be, and in
how many of the pictures it was known. The calibration is the true one.
"""

import argparse
import sys
from collections.abc import Iterator

import numpy as np

from fcw.frame import Frame
from fcw.motion.estimator import MotionEstimator
from fcw.simulation.drive import render_drive, true_calibration
from fcw.simulation.world.scenario import FRAMES_PER_SECOND, EgoPlan, RoadPlan, Scenario

SPEEDS_KMH = (30, 70, 100, 130, 150, 170)
RATES_HZ = (30, 10)
SEEDS = (2, 3)
DURATION_S, BEGINS_S = 5.0, 1.5
ROAD = RoadPlan(lanes_left=1, lanes_right=1, opposing_lanes=2, trees_per_km=100)


def main() -> None:
    """Print a line for each speed and frame rate."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    sys.stdout.write("km/h, pictures a second: error; 1 sigma; known\n")
    for speed_kmh in SPEEDS_KMH:
        scenario = Scenario(
            description="an empty road",
            duration_s=DURATION_S,
            ego=EgoPlan(speed_kmh=speed_kmh),
            road=ROAD,
            vehicles=(),
        )
        drives = [tuple(_pictures(scenario, seed)) for seed in SEEDS]
        for rate_hz in RATES_HZ:
            told = [_told(scenario, drive[:: round(FRAMES_PER_SECOND / rate_hz)]) for drive in drives]
            errors, sigmas = np.concatenate(told).T
            known = np.isfinite(errors)
            sys.stdout.write(
                f"{speed_kmh}, {rate_hz}: {100 * np.median(errors[known]):+.1f} %; "
                f"{100 * np.median(sigmas[known]):.1f} %; {100 * known.mean():.0f} %\n"
                if known.any()
                else f"{speed_kmh}, {rate_hz}: never known\n"
            )
            sys.stdout.flush()


def _pictures(scenario: Scenario, seed: int) -> Iterator[tuple[Frame, float]]:
    """Each frame, and the true speed in m/s."""
    for frame, truth in render_drive(scenario, seed):
        yield frame, truth.ego_speed_mps


def _told(scenario: Scenario, drive: tuple[tuple[Frame, float], ...]) -> np.ndarray:
    """(N, 2) error and sigma of the speed as parts of the true one; NaN where it is unknown."""
    own, told = MotionEstimator(true_calibration(scenario)), []
    for frame, true_mps in drive:
        motion = own.update(frame.time_ns, frame.image)
        if frame.time_ns < BEGINS_S * 1e9:
            continue
        speed_mps, sigma_mps = motion.speed_mps, motion.speed_sigma_mps
        if speed_mps is None or sigma_mps is None:
            told.append((np.nan, np.nan))
        else:
            told.append((speed_mps / true_mps - 1, sigma_mps / true_mps))
    return np.array(told)


if __name__ == "__main__":
    main()
