"""How well the road as a whole tells the speed where none of its points does, against true poses.

    python benchmarks/motion/road_alone.py DRIVE --poses FILE --calibration FILE

The search for a speed by points is switched off, as if the road had no corner from the first picture to the
last. The first line is with it.
"""

import argparse
import math
import sys
from pathlib import Path

from fcw.camera.file import read_calibration
from fcw.evaluation.motion.motion import evaluate_motion
from fcw.evaluation.motion.poses import read_poses
from fcw.motion.settings import MotionSettings
from fcw.sources import open_source

CASES = {"points": MotionSettings(), "road alone": MotionSettings(first_evidence=math.inf)}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("drive", type=Path)
    parser.add_argument("--poses", type=Path, required=True)
    parser.add_argument("--calibration", type=Path, required=True)
    options = parser.parse_args()
    calibration, poses = read_calibration(options.calibration), read_poses(options.poses)
    for name, settings in CASES.items():
        result = evaluate_motion(open_source(options.drive), calibration, poses, settings=settings)
        sys.stdout.write(
            f"{name:10} known in {result.known_part:.0%}, error {result.speed_median:.1%} in the median, "
            f"{result.speed_p90:.1%} for nine of ten, bias {result.speed_bias:+.1%}, "
            f"inside 1 sigma {result.speed_coverage:.0%}, {result.ms_per_frame:.2f} ms a picture\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
