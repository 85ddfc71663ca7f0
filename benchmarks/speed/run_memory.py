"""Memory of `fcw run` over a long drive, made by repeating the packets of a short one.

    python benchmarks/speed/run_memory.py CLIP --calibration FILE [--minutes 20]

Prints the resident memory over the frames read; the peak is that of the whole process. A run whose memory
does not grow is as good for a day as for a minute.
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from fcw.frame import Frame, Source
from fcw.job import DriveJob
from fcw.sources import open_source
from fcw.sources.forwarding import ForwardingSource
from fcw.versions import machine
from fcw_viz.benchmark.long_drive import repeat_packets
from fcw_viz.console import MESSAGES, RESULTS
from fcw_viz.jobs.drive import run_on_console

ROWS = 20
MEGABYTE = 1e6


class Watched(ForwardingSource):
    """A source that notes the resident memory every so many frames."""

    def __init__(self, source: Source, every: int) -> None:
        super().__init__(source)
        self._every = every
        self.resident: list[tuple[int, float]] = []

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in self._source.frames(start_ns):
            if frame.index % self._every == 0:
                self.resident.append((frame.index, resident_mb()))
            yield frame


def resident_mb() -> float:
    """Resident memory of this process now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / MEGABYTE


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--calibration", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=20.0)
    arguments = parser.parse_args()
    console = RESULTS
    with tempfile.TemporaryDirectory() as folder:
        long = Path(folder) / "long.mp4"
        repeat_packets(arguments.clip, long, arguments.minutes * 60)
        opened = open_source(long)
        count = opened.frame_count or 0
        source = Watched(opened, max(count // ROWS, 1))
        job = DriveJob(source=long, out=Path(folder) / "out", calibration=arguments.calibration)
        start = time.perf_counter()
        outcome = run_on_console(job, MESSAGES, source)
        seconds = time.perf_counter() - start
    console.print(
        f"{machine()}; {arguments.clip.name} repeated to {outcome.summary['duration_s'] / 60:.1f} min, "
        f"{outcome.summary['frames']} frames of {source.image_size} in {seconds:.0f} s"
    )
    table = Table("frame", "resident MB", box=None)
    for index, megabytes in source.resident:
        table.add_row(str(index), f"{megabytes:.0f}")
    console.print(table)
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / MEGABYTE
    console.print(f"peak of the process {peak_mb:.0f} MB")


if __name__ == "__main__":
    main()
