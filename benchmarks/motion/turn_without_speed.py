"""How well the picture tells how we turn where it tells no speed, against true poses.

    python benchmarks/motion/turn_without_speed.py DRIVE --poses FILE --calibration FILE

The search for a speed is switched off, as if the road were plain from the first picture to the last. Prints
in how many pictures the yaw rate is known, its error, and the same with the search on.
"""

import argparse
import math
import sys
from pathlib import Path

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.evaluation.motion.poses import read_poses, true_motion
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.sources import open_source

CASES = {"speed known": MotionSettings(), "no speed": MotionSettings(first_evidence=math.inf)}


def compare(drive: Path, poses: Path, calibration: Calibration) -> None:
    """Print one line for each of `CASES`."""
    estimators = {name: MotionEstimator(calibration, settings) for name, settings in CASES.items()}
    said: dict[str, list[float]] = {name: [] for name in CASES}
    times_s = []
    for frame in open_source(drive).frames():
        times_s.append(frame.time_ns / 1e9)
        for name, estimator in estimators.items():
            rate_radps = estimator.update(frame.time_ns, frame.image).yaw_rate_radps
            said[name].append(math.nan if rate_radps is None else rate_radps)
    true_radps = true_motion(read_poses(poses)[: len(times_s)], np.array(times_s)).yaw_rates_radps
    for name, rates_radps in said.items():
        errors = np.degrees(np.abs(np.array(rates_radps) - true_radps))
        known = np.isfinite(errors)
        median, most = np.quantile(errors[known], (0.5, 0.9))
        sys.stdout.write(
            f"{name:12} known in {known.mean():6.1%} of {len(errors)} pictures, "
            f"error {median:.2f} deg/s in the median, {most:.2f} for nine of ten\n"
        )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("drive", type=Path)
    parser.add_argument("--poses", type=Path, required=True)
    parser.add_argument("--calibration", type=Path, required=True)
    options = parser.parse_args()
    compare(options.drive, options.poses, read_calibration(options.calibration))
    return 0


if __name__ == "__main__":
    sys.exit(main())
