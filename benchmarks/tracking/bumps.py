"""Distances over bumps, with and without what own motion tells of the body's pitch.

    python benchmarks/tracking/bumps.py [--scenario demo] [--seed 0]

A simulated drive whose nose goes down or up every four seconds, by 1.3 degrees over 0.6 s, seen from pixels,
the own speed unknown. Counted are all tracks of vehicles between 5 and 60 m; "in bumps" are the 1.2 s from
the beginning of each. Takes about five minutes.
"""

import argparse
import math
import sys
import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import patch

import numpy as np

import fcw
from fcw.camera.file import read_calibration
from fcw.camera.ground_plane import FloatArray
from fcw.evaluation.simulated import FARTHEST_M, NEAREST_M, vehicle_at
from fcw.logs.records import FrameResult
from fcw.motion.estimator import MotionEstimator
from fcw.simulation.drive import CALIBRATION_NAME, TRUTH_NAME, VIDEO_NAME, write_drive
from fcw.simulation.truth.file import read_truth
from fcw.simulation.world.motion import RoadShake
from fcw.simulation.world.scenario import load_scenario

BUMP_RAD, BUMP_S, EVERY_S, FIRST_S = math.radians(1.3), 0.6, 4.0, 5.5
IN_BUMP_S = 1.2


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenario", default="demo")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        drive = Path(folder)
        with patch.object(RoadShake, "at", bumpy(RoadShake.at)):
            write_drive(load_scenario(given.scenario), drive, given.seed)
        say("                distances off by, median, 9 of 10   closing speeds, mean, 9 of 10")
        untold = patch.object(MotionEstimator, "body_pitch", lambda *_: None)
        for name, how in (("not told", untold), ("told", nullcontext())):
            with how:
                for where, (off, off_mps) in zip(
                    ("", ", in bumps"), errors(drive, drive / name), strict=True
                ):
                    say(
                        f"{name + where:18} {np.median(off):23.1%} {np.quantile(off, 0.9):8.1%}"
                        f" {np.mean(off_mps):17.2f} {np.quantile(off_mps, 0.9):8.2f} m/s"
                    )


def bumpy(
    even: Callable[[RoadShake, float, float], tuple[float, float]],
) -> Callable[..., tuple[float, float]]:
    """Pitch and bounce of a road, with bumps in it."""

    def at(shake: RoadShake, time_s: float, speed_mps: float) -> tuple[float, float]:
        pitch_rad, bounce_m = even(shake, time_s, speed_mps)
        number, since_s = divmod(time_s - FIRST_S, EVERY_S)
        if number >= 0 and since_s < BUMP_S:
            pitch_rad += (-BUMP_RAD if number % 2 else BUMP_RAD) * math.sin(math.pi * since_s / BUMP_S)
        return pitch_rad, bounce_m

    return at


def errors(drive: Path, out: Path) -> tuple[FloatArray, FloatArray]:
    """Relative errors of all distances of a run, and errors of closing speeds in m/s, all without sign.

    Returns:
        (2, N) of all tracks, and (2, B) of those in bumps.
    """
    results: list[FrameResult] = []
    calibration = read_calibration(drive / CALIBRATION_NAME)
    job = fcw.DriveJob(source=drive / VIDEO_NAME, out=out, calibration=calibration)
    fcw.run_drive(job, on_result=results.append)
    every: list[tuple[float, float, bool]] = []
    for result, truth in zip(results, read_truth(drive / TRUTH_NAME), strict=True):
        since_s = result.time_ns / 1e9 - FIRST_S
        in_bump = since_s >= 0 and since_s % EVERY_S < IN_BUMP_S
        for track in result.tracks:
            vehicle = vehicle_at(track.box, truth)
            if vehicle is not None and NEAREST_M <= vehicle.distance_m <= FARTHEST_M:
                off = abs(track.distance_m / vehicle.distance_m - 1)
                off_mps = abs(track.closing_speed_mps - vehicle.closing_speed_mps)
                every.append((off, off_mps, in_bump))
    table = np.array(every).T
    return table[:2], table[:2, table[2] > 0]


def say(text: str) -> None:
    """A line of the report."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
