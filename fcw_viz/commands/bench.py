"""`fcw bench`: the whole job beside decoding alone, the distance prior beside plain ACF, in one run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class BenchCommand:
    """Measure speed side by side: every round runs each case once, so that a noisy machine hits all alike."""

    source: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SOURCE]")] = None
    """Video to measure on; by default the shipped drive."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Its calibration file; by default `<name>.calibration.yaml` beside the source."""
    rounds: int = 3
    """How often each case is run; medians are reported."""
    detector_frames: int = 60
    """Frames on which the detectors are compared in each round, one thread."""
    json: bool = False
    """Print the figures as JSON on stdout, alone."""


def run_bench(command: BenchCommand) -> int:
    """Run `fcw bench`; returns the exit code."""
    import json
    import sys

    from rich.console import Console
    from rich.table import Table

    from fcw.errors import UserError
    from fcw_viz.benchmark import measure
    from fcw_viz.commands.demo import demo_folder

    if command.rounds < 1 or command.detector_frames < 1:
        raise UserError("--rounds and --detector-frames: expected at least 1")
    source = command.source or demo_folder() / "drive.mp4"
    figures = measure(
        source, command.calibration, command.rounds, command.detector_frames, Console(stderr=True)
    )
    if command.json:
        sys.stdout.write(json.dumps(figures.as_json(), indent=2) + "\n")
        return 0
    console = Console()
    console.print(figures.heading, highlight=False)
    table = Table("case", "median", "minimum", "ratio to the first of its kind", box=None)
    for row in figures.table_rows():
        table.add_row(*row)
    console.print(table)
    return 0
