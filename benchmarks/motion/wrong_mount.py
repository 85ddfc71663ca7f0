"""Own motion on clips whose calibration has a wrong pitch: its belief at the end, and how often it knows the
speed.

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/motion/wrong_mount.py

With looks where the drive leads to, and by steps alone. The right pitches are those of `calibrations.txt`.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from real_drives import data_folder

from fcw.camera.calibration import Calibration
from fcw.detection.training.own_data import read_calibration_table
from fcw.frame import Frame
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.sources import open_source

OFF_DEG = (0, -1, 1, -2, 2, -4, 4)
LONGEST_S = 15.0


def main() -> None:
    """Print a line for each error of the pitch, with looks and without."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    data = data_folder()
    table = read_calibration_table(data / "calibrations.txt")
    ends: dict[tuple[bool, int], list[tuple[float, float, float]]] = {}
    for path in sorted((data / "clips").glob("*.mp4")):
        source = open_source(path)
        frames = [frame for frame in source.frames() if frame.time_ns < LONGEST_S * 1e9]
        for off_deg in OFF_DEG:
            for looks in (True, False):
                end = end_of(frames, table[path.stem], off_deg, looks)
                ends.setdefault((looks, off_deg), []).append(end)
    sys.stdout.write(
        "looks, pitch off: error at the end, median and worst; inside 2 sigmas; speed known (mean of clips)\n"
    )
    for (looks, off_deg), of_clips in sorted(ends.items(), reverse=True):
        errors_deg, sigmas_deg, known = np.array(of_clips).T
        inside = int((np.abs(errors_deg) < 2 * sigmas_deg).sum())
        sys.stdout.write(
            f"{'looks' if looks else 'steps'}, {off_deg:+d}: {np.median(np.abs(errors_deg)):.2f}, "
            f"{np.abs(errors_deg).max():.2f}; {inside} of {len(of_clips)}; {100 * known.mean():.0f} %\n"
        )


def end_of(
    frames: Sequence[Frame], right: Calibration, off_deg: float, looks: bool
) -> tuple[float, float, float]:
    """Error and sigma of the pitch at the end in degrees, and the part of the frames whose speed is known."""
    camera = replace(right.camera, pitch_rad=right.camera.pitch_rad + math.radians(off_deg))
    wrong = Calibration.from_camera(camera, right.image_size)
    own = MotionEstimator(wrong, MotionSettings(asks_direction=looks))
    known = sum(own.update(frame.time_ns, frame.image).speed_mps is not None for frame in frames)
    mount = own.state.mount
    assert mount is not None
    error_rad = mount.pitch_rad - right.camera.pitch_rad
    return math.degrees(error_rad), math.degrees(mount.pitch_sigma_rad), known / len(frames)


if __name__ == "__main__":
    main()
