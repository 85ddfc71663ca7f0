"""`fcw evaluate motion`: own speed, yaw rate and mount by the picture against true poses."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from fcw.errors import UserError


@dataclass(frozen=True, slots=True)
class EvaluateMotionCommand:
    """Measure own speed, yaw rate and camera angles, as estimated from the picture, against true poses."""

    frames: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="FRAMES")] = None
    """Video or MCAP file, or folder of pictures. Not with --bends."""
    poses: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """True poses, one line per picture: a 3x4 matrix, row by row, from this camera to the first (KITTI)."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file. Default: `<name>.calibration.yaml` beside the pictures."""
    frame_rate: Annotated[float | None, tyro.conf.arg(metavar="HZ")] = None
    """Frames per second, for a folder of pictures without time stamps."""
    bends: bool = False
    """Measure the own path 30 m ahead on rendered bends of 150 to 800 m radius."""
    json: bool = False
    """Print the result as JSON, and nothing else on stdout."""


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

    if command.bends:
        if command.frames is not None or command.poses is not None:
            raise UserError("--bends makes its own pictures and poses; leave out FRAMES and --poses")
        return _bends(command.json)
    if command.frames is None or command.poses is None:
        raise UserError("fcw evaluate motion: give FRAMES and --poses FILE, or --bends")
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

    def degrees(angle_rad: float, pattern: str) -> str:
        return _said(math.degrees(angle_rad), pattern)

    RESULTS.print(
        f"{result.frames} pictures, speed known in {result.known_part:.1%}\n"
        f"speed above 2 m/s: median error {_said(result.speed_median, '.1%')}, "
        f"9 of 10 within {_said(result.speed_p90, '.1%')}, bias {_said(result.speed_bias, '+.1%')}, "
        f"inside the 1-sigma interval {_said(result.speed_coverage, '.0%')}\n"
        f"yaw rate in deg/s: median error {degrees(result.yaw_rate_median_radps, '.2f')}\n"
        f"camera below the direction of travel, degrees: {degrees(result.camera_pitch_rad, '+.2f')} "
        f"(by the poses {degrees(result.true_pitch_rad, '+.2f')})\n"
        f"camera to the left of it, degrees: {degrees(result.camera_yaw_rad, '+.2f')} "
        f"(by the poses {degrees(result.true_yaw_rad, '+.2f')})\n"
        f"time a picture after the first second, ms: {_said(result.ms_per_frame, '.2f')}",
        highlight=False,
    )
    return 0


def _said(value: float, pattern: str) -> str:
    """A figure in words; a clip of a second has not all of them."""
    import math

    return "unknown" if math.isnan(value) else format(value, pattern)


def _bends(as_json: bool) -> int:
    from dataclasses import asdict

    from rich.table import Table

    from fcw.evaluation.motion.bends import RADII_M, evaluate_bends, picture_count
    from fcw_viz.console import RESULTS, print_json, progress

    with progress("bends", sum(picture_count(radius_m) for radius_m in RADII_M)) as bar:
        results = evaluate_bends(on_frame=bar.advance)
    if as_json:
        print_json({"bends": [asdict(result) for result in results]})
        return 0
    table = Table(
        "radius", "own speed", "30 m ahead, median", "9 of 10", "without lines", "9 of 10", box=None
    )
    for result in results:
        table.add_row(
            f"{result.radius_m:g} m",
            f"{result.speed_mps * 3.6:.0f} km/h",
            f"{result.median_m:.2f} m",
            f"{result.p90_m:.2f} m",
            f"{result.without_lines_median_m:.2f} m",
            f"{result.without_lines_p90_m:.2f} m",
        )
    RESULTS.print(table)
    return 0
