"""`fcw evaluate motion`: own speed, yaw rate and mount by the picture against true poses."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class EvaluateMotionCommand:
    """Measure own speed, yaw rate and the camera's mount, as the picture tells them, against true poses."""

    frames: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FRAMES")]
    """Video or MCAP file, or folder of pictures."""
    poses: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """True poses, one line a picture: the rows of a 3x4 matrix, camera to the first camera (KITTI)."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file; by default `<name>.calibration.yaml` beside the pictures."""
    frame_rate: Annotated[float | None, tyro.conf.arg(metavar="HZ")] = None
    """Frames per second of a folder of pictures without time stamps."""
    json: bool = False
    """Print the result as JSON on stdout, alone."""


def run_evaluate_motion(command: EvaluateMotionCommand) -> int:
    """Run `fcw evaluate motion`; returns the exit code."""
    import math
    from dataclasses import asdict

    from fcw.evaluation.motion.motion import evaluate_motion
    from fcw.evaluation.motion.poses import read_poses
    from fcw.job import DriveJob, load_calibration
    from fcw.sources import open_source
    from fcw.sources.straight import straightened
    from fcw_viz.console import RESULTS, print_json, progress

    poses = read_poses(command.poses)
    source = open_source(command.frames, command.frame_rate, None)
    calibration = load_calibration(
        DriveJob(source=command.frames, out=Path(), calibration=command.calibration), source
    )
    source, calibration = straightened(source, calibration)
    with progress(source.name, source.frame_count) as bar:
        result = evaluate_motion(source, calibration, poses, bar.advance)
    if command.json:
        print_json(asdict(result))
        return 0
    RESULTS.print(
        f"{result.frames} pictures, speed known in {result.known_part:.1%}\n"
        f"speed above 2 m/s: median error {result.speed_median:.1%}, 9 of 10 within {result.speed_p90:.1%}, "
        f"bias {result.speed_bias:+.1%}, inside the 1-sigma interval {result.speed_coverage:.0%}\n"
        f"yaw rate: median error {math.degrees(result.yaw_rate_median_radps):.2f} deg/s\n"
        f"camera below the direction of travel: {math.degrees(result.camera_pitch_rad):+.2f} degrees "
        f"(by the poses {math.degrees(result.true_pitch_rad):+.2f})\n"
        f"camera to the left of it: {math.degrees(result.camera_yaw_rad):+.2f} degrees "
        f"(by the poses {math.degrees(result.true_yaw_rad):+.2f})\n"
        f"{result.ms_per_frame:.2f} ms a picture",
        highlight=False,
    )
    return 0
