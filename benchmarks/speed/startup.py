"""What a start takes: `fcw --help`, and the detector alone from process start to its first result.

    python benchmarks/speed/startup.py [--repeats 10]

The kernels are cached by a run that is not counted. Beside the time by the clock stands that of the
processor, which other work on the machine changes less.
"""

import argparse
import os
import statistics
import subprocess
import sys
import time
from datetime import date

from rich.console import Console
from rich.table import Table

from fcw.versions import machine
from fcw_viz.commands.demo import demo_folder

FIRST_RESULT = """
import numpy as np
from fcw.camera.file import read_calibration
from fcw.detection.acf import AcfDetector
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from pathlib import Path
detector = AcfDetector(Model.load(SHIPPED_MODEL_PATH), read_calibration(Path({calibration!r})))
detector.detect(np.full((720, 1280, 3), 99, np.uint8))
"""


def run(command: list[str]) -> tuple[float, float]:
    """Seconds by the clock and by the processor of one process."""
    before, start = os.times(), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    wall_s, after = time.perf_counter() - start, os.times()
    return wall_s, after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeats", type=int, default=10)
    arguments = parser.parse_args()
    calibration = str(demo_folder() / "drive.calibration.yaml")
    commands = {
        "fcw --help": [sys.executable, "-m", "fcw_viz.cli", "--help"],
        "detector, first result": [sys.executable, "-c", FIRST_RESULT.format(calibration=calibration)],
    }
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
    for repeat in range(-1, arguments.repeats):
        for name, command in commands.items():
            seconds = run(command)
            if repeat >= 0:
                taken[name].append(seconds)
    console = Console()
    console.print(f"{machine()}; {date.today()}; {arguments.repeats} starts each, taking turns")
    table = Table("process", "median s", "minimum s", "processor, median s", box=None)
    for name, values in taken.items():
        walls, processors = zip(*values, strict=True)
        table.add_row(
            name,
            f"{statistics.median(walls):.2f}",
            f"{min(walls):.2f}",
            f"{statistics.median(processors):.2f}",
        )
    console.print(table)


if __name__ == "__main__":
    main()
