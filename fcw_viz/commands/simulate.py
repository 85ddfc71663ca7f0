"""`fcw simulate`: a drive with exact truth, rendered from a scenario."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class SimulateCommand:
    """Render a scenario: drive.mp4, its calibration and own speed, and its truth as CSV and MCAP."""

    scenario: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SCENARIO")]
    """braking, cut-in, demo or oncoming; a danger such as crossing (an unknown name lists them all); or the
    path of your own scenario file."""
    out: Annotated[Path, tyro.conf.arg(metavar="FOLDER")]
    """Folder for the files. An earlier simulated drive in it is replaced."""
    seed: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Changes vehicles, colours, roadside, light and timing. The same seed gives the same pictures."""


def run_simulate(command: SimulateCommand) -> int:
    """Run `fcw simulate`; returns the exit code."""
    from fcw.errors import UserError
    from fcw.simulation.world.scenario import load_scenario

    if command.seed < 0:
        raise UserError(f"--seed {command.seed}: expected a whole number of at least 0")
    scenario = load_scenario(command.scenario)
    from fcw.logs.names import TRUTH_LOG_NAME
    from fcw.simulation.drive import CALIBRATION_NAME, SPEED_NAME, VIDEO_NAME, write_drive
    from fcw_viz.console import RESULTS, progress

    with progress(command.scenario, scenario.frame_count) as bar:
        write_drive(scenario, command.out, command.seed, bar.advance, Path(command.scenario))
    marks = ", ".join(f"{distance_m:g}" for distance_m in scenario.road.marks_m)
    video = command.out / VIDEO_NAME
    RESULTS.print(
        f"{video}: {scenario.duration_s:g} s, {scenario.frame_count} frames\n"
        f"The white bars on the road in the first picture are {marks} m from the front bumper, which is "
        f"{scenario.camera.reference_offset_m:g} m ahead of the camera; the camera is "
        f"{scenario.camera.height_m:g} m high.\n\n"
        f"  {command.out / CALIBRATION_NAME}   its true calibration\n"
        f"  {command.out / TRUTH_LOG_NAME}   the truth as a log: open it like one of `fcw run`\n"
        f"  fcw run {quote(str(video))} --ego-speed {quote(str(command.out / SPEED_NAME))}",
        soft_wrap=True,
    )
    return 0
