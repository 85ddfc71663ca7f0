"""How much faster a batch is with two workers, than `fcw run` in a loop, and with a long drive in pieces.

    python benchmarks/batch/rates.py [--drives 20] [--frames 150] [--rounds 3] [--long-s 60] [--long-every 1]
        [--detector acf]

Rounds are interleaved, and medians printed: on a machine that others use, wall time lies. So the processor
time of each is printed too; where one drive costs as much with two workers as with one, two idle cores
are nearly twice as fast. Tables and logs are compared byte for byte.
"""

import argparse
import filecmp
import shutil
import statistics
import tempfile
from collections import defaultdict
from pathlib import Path

from cluster import DEMO, FCW, timed, write_drives, write_slower
from rich import print  # noqa: A004

from fcw.versions import machine
from fcw_viz.benchmark.long_drive import repeat_packets


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--frames", type=int, default=150)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--long-s", type=float, default=60.0)
    parser.add_argument("--long-every", type=int, default=1, help="of 30 pictures a second, one of so many")
    parser.add_argument("--piece-minutes", help="of the long drive; by default an eighth of it")
    parser.add_argument("--detector", default="acf")
    arguments = parser.parse_args()
    print(machine())
    taken: dict[str, list[tuple[float, float]]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drives, long = folder / "drives", folder / "long" / "long.mp4"
        write_drives(drives, arguments.drives, arguments.frames)
        long.parent.mkdir()
        demo = DEMO / "drive.mp4"
        if arguments.long_every > 1:
            demo = folder / "slower.mp4"
            write_slower(demo, arguments.long_every)
        repeat_packets(demo, long, arguments.long_s)
        shutil.copy(DEMO / "drive.calibration.yaml", long.with_name("calibration.yaml"))
        common = ["--detector", arguments.detector]

        def batch(label: str, source: Path, *options: str) -> None:
            out = folder / label
            shutil.rmtree(out, ignore_errors=True)
            command = [*FCW, "batch", str(source), "--out", str(out), *common, *options]
            taken[label].append(timed(command))

        for _ in range(arguments.rounds):
            batch("1 worker", drives, "--workers", "1")
            batch("2 workers", drives, "--workers", "2")
            loop = [
                timed([*FCW, "run", str(drive), "--out", str(folder / "run" / drive.stem), *common,
                       "--calibration", str(drives / "calibration.yaml"), "--json"])
                for drive in sorted(drives.glob("*.mp4"))
            ]  # fmt: skip
            taken["fcw run in a loop"].append((sum(wall for wall, _ in loop), sum(cpu for _, cpu in loop)))
            batch("long, whole, 1 worker", long, "--workers", "1", "--piece-minutes", "0")
            minutes = arguments.piece_minutes or str(arguments.long_s / 60 / 8)
            batch("long, in pieces, 2 workers", long, "--workers", "2", "--piece-minutes", minutes)

        def same(one: str, other: str, *files: str) -> bool:
            return all(filecmp.cmp(folder / one / f, folder / other / f, shallow=False) for f in files)

        tables = "events.parquet", "drives.parquet"
        print("tables of 1 and 2 workers byte-equal:", same("1 worker", "2 workers", *tables))
        of_long = "long, whole, 1 worker", "long, in pieces, 2 workers"
        print("log and tables of the long drive byte-equal:", same(*of_long, "long/drive.mcap", *tables))
    median = {
        label: (statistics.median(wall for wall, _ in times), statistics.median(cpu for _, cpu in times))
        for label, times in taken.items()
    }
    for label, (wall_s, cpu_s) in median.items():
        print(f"{label:30} {wall_s:8.1f} s  {cpu_s:8.1f} s of processor time")
    for one, other in (
        ("1 worker", "2 workers"),
        ("fcw run in a loop", "1 worker"),
        of_long,
    ):
        wall, cpu = (median[one][at] / median[other][at] for at in (0, 1))
        print(f"{other} to {one}: {wall:.2f} times the rate; processor time {1 / cpu:.2f} times")


if __name__ == "__main__":
    main()
