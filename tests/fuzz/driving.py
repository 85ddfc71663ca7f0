"""A drive over and over in one process: memory, handles and threads stay as they are.

    python tests/fuzz/driving.py [--hours 10] [--source VIDEO]

The drive is the shipped one, or a video with its calibration beside it: one of a slower camera takes less
time. Prints a line for each round, and JSON at the end; the exit code is 1 where something grew by over 5 %.
"""

import argparse
import gc
import json
import resource
import statistics
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path

from fcw.job import DriveJob
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console

DRIVE = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
WARM_UP_ROUNDS = 3
"""Kernels, models and caches come in these; they are not looked at."""
MOST_GROWTH = 0.05


@dataclass(frozen=True)
class Held:
    """What the process holds after a round.

    Attributes:
        memory_mb: resident.
        handles: open files.
        threads: of Python and of every library.
    """

    memory_mb: int
    handles: int
    threads: int


def drive_for(
    hours: float, say: Callable[[str], object] = lambda text: None, source: Path = DRIVE
) -> dict[str, object]:
    """Drive so long; `grown` in the result names what grew."""
    rounds: list[Held] = []
    driven_s = 0.0
    stop = threading.Event()  # by Ctrl-C, or a request to end
    with tempfile.TemporaryDirectory() as folder:
        while driven_s < hours * 3600 and not stop.is_set():
            job = DriveJob(source, Path(folder) / "out")
            driven_s += run_on_console(job, SILENT, stop=stop).summary["duration_s"]
            gc.collect()
            rounds.append(held())
            say(f"{driven_s / 3600:.2f} h: {rounds[-1]}")
    figures = [astuple(one) for one in rounds]
    grown = growth(rounds[WARM_UP_ROUNDS:])
    return {
        "hours": round(driven_s / 3600, 2),
        "rounds": len(rounds),
        "first_rounds": figures[:5],
        "last_rounds": figures[-5:],
        "grown": grown,
    }


def held() -> Held:
    """What this process holds now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    handles = len(list(Path("/proc/self/fd").iterdir()))
    threads = len(list(Path("/proc/self/task").iterdir()))
    return Held(pages * resource.getpagesize() >> 20, handles, threads)


def growth(rounds: list[Held]) -> dict[str, tuple[float, float]]:
    """What is larger in the last third of the rounds than in the first, by more than it may be."""
    third = len(rounds) // 3
    if third == 0:
        return {}
    medians = {
        name: (
            statistics.median(getattr(one, name) for one in rounds[:third]),
            statistics.median(getattr(one, name) for one in rounds[-third:]),
        )
        for name in Held.__dataclass_fields__
    }
    return {
        name: (first, last) for name, (first, last) in medians.items() if last > first * (1 + MOST_GROWTH)
    }


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--hours", type=float, default=10.0)
    parser.add_argument("--source", type=Path, default=DRIVE)
    arguments = parser.parse_args()
    result = drive_for(arguments.hours, lambda text: sys.stderr.write(f"{text}\n"), arguments.source)
    sys.stdout.write(json.dumps(result, indent=1) + "\n")
    return 1 if result["grown"] else 0


if __name__ == "__main__":
    sys.exit(main())
