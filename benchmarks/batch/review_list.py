"""How soon the review page lists and filters the drives of a large batch, in a real Chromium.

    PYTHONPATH=benchmarks python benchmarks/batch/review_list.py [--drives 1000] [--pictures DIR]

Writes one log with so many warnings, lays it under so many names, and writes the batch's tables as
`fcw batch` does. Prints how long it takes from the page's address to the list that knows all drives, from a
key in the search field to the row that is asked for, and the largest memory of the server; with its
processor time, for on a machine that others use wall time lies. At last the same of the list of moments.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from chromium import READY, SEES_LIST, WINDOW, chromium, option_parser
from rich import print  # noqa: A004

from fcw.batch.ledger import Record, State
from fcw.batch.moments import write_moments
from fcw.batch.tables import write_tables
from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration
from fcw.frame import ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import MCAP_NAME
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources import open_source
from fcw.tracking.types import SeenBy, Track
from fcw.versions import machine
from fcw.warning.types import WarningLevel, WarningState

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
EVENT_FRAMES = 6
"""Half of them with the warning."""
WAIT_MS = 300_000
MOMENT_WORDS = "more moments"
"""On the button under the list of moments."""


def write_drive(path: Path, events: int) -> DriveLog:
    """The demo's pictures with made warnings about a vehicle that comes nearer from one to the next."""
    source = open_source(DEMO / "drive.mp4")
    calibration: Calibration = read_calibration(DEMO / "drive.calibration.yaml")
    size = ImageSize(source.image_size.width, source.image_size.height)
    header = DriveHeader("made.mp4", size, 30.0, calibration, False, "none", "", {"fcw": "made"})
    path.parent.mkdir(parents=True)
    sink, encoder = McapSink(path), VideoEncoder(size, 30.0)
    sink.open(header)
    for frame in source.frames():
        number = frame.index // EVENT_FRAMES
        if number == events:
            break
        near_m, box = 40.0 - number, Box(600.0, 380.0, 90.0, 70.0)
        track = Track(1, box, 9.0, near_m, near_m - 1, near_m + 1, 0.0, 8.0, 0.5, near_m / 8, 3.0,
                      SeenBy.DETECTOR, True)  # fmt: skip
        warned = frame.index % EVENT_FRAMES < EVENT_FRAMES // 2
        state = WarningState(WarningLevel.WARNING, 1, "ttc", near_m / 8) if warned else WarningState(
            WarningLevel.NONE
        )  # fmt: skip
        result = FrameResult(frame.index, frame.time_ns, (), (track,), 1, state, 20.0)
        sink.write(result, encoder.encode(replace(frame, packets=())))
    encoder.close()
    sink.close()
    return DriveLog(path)


def write_batch(out: Path, drives: int, events: int) -> None:
    """The same drive under many names."""
    log = write_drive(out / "d0000" / MCAP_NAME, events)
    write_moments(log.path.parent)
    for number in range(1, drives):
        shutil.copytree(log.path.parent, out / f"d{number:04d}", copy_function=os.link)
    seconds = log.series().duration_s
    records = [
        Record(f"d{number:04d}", f"/drives/{number}.mp4", "van", State.DONE, duration_s=seconds,
               frames=len(log.series()), warnings=events)
        for number in range(drives)
    ]  # fmt: skip
    start_s = time.process_time()
    found, _ = write_tables(out, records)
    taken_s = time.process_time() - start_s
    print(f"tables of {drives} drives and {found} events: {taken_s:.1f} s of processor time")


def processor_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100


def memory_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1000


def main() -> None:
    parser = option_parser(__doc__)
    parser.add_argument("--drives", type=int, default=1000)
    parser.add_argument("--events", type=int, default=20)
    parser.add_argument("--port", type=int, default=8620)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "batch"
        write_batch(out, options.drives, options.events)
        command = [sys.executable, "-m", "fcw_viz.cli", "review", str(out), "--no-open"]
        command += ["--port", str(options.port)]
        start_s = time.perf_counter()
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            try:
                url = next(line.split(" at ")[1].split()[0] for line in server.stdout if "http://" in line)
                print(
                    f"command to address: {time.perf_counter() - start_s:.1f} s, "
                    f"{processor_s(server.pid):.1f} s of processor time"
                )
                look(url, server.pid, options)
            finally:
                server.terminate()


def look(url: str, pid: int, options: Namespace) -> None:
    """List and filter."""
    with chromium(options) as browser:
        page = browser.new_page(viewport=WINDOW)
        start_s, start_cpu_s = time.perf_counter(), processor_s(pid)
        page.add_init_script(SEES_LIST)
        page.goto(f"{url}/?fixedDpr=1", wait_until="commit")
        page.wait_for_function("window.listSeenAt", timeout=WAIT_MS)
        rows_s = page.evaluate("listSeenAt") / 1000
        page.wait_for_function(
            f"document.body.innerText.includes('{options.drives} drives') "
            "&& !document.body.innerText.includes('reading ')",
            timeout=WAIT_MS,
        )
        all_s = time.perf_counter() - start_s
        print(
            f"address to rows: {rows_s:.1f} s ({page.evaluate('listWords')!r}); "
            f"{all_s:.1f} s until all drives are read and a script of ours can ask; "
            f"server {processor_s(pid) - start_cpu_s:.1f} s of processor time"
        )
        page.wait_for_function(READY, timeout=WAIT_MS)
        page.wait_for_selector(".fcw-row", timeout=WAIT_MS)
        print(f"to what can be filtered at once: {time.perf_counter() - start_s:.1f} s")
        page.wait_for_timeout(2000)
        if options.pictures:
            page.screenshot(path=options.pictures / "list.png")
        for name in (f"d{options.drives - 1:04d}", "d0007"):
            field = page.locator(".fcw-filter input[type=search]")
            field.fill("")
            page.wait_for_function("document.querySelectorAll('.fcw-row').length > 1", timeout=WAIT_MS)
            start_s, start_cpu_s = time.perf_counter(), processor_s(pid)
            field.fill(name)
            page.wait_for_function("document.querySelectorAll('.fcw-row').length === 1", timeout=WAIT_MS)
            print(
                f"filter {name}: {time.perf_counter() - start_s:.2f} s; "
                f"server {processor_s(pid) - start_cpu_s:.2f} s of processor time"
            )
        page.locator(".fcw-filter input[type=search]").fill("")
        page.wait_for_function("document.querySelectorAll('.fcw-row').length > 1", timeout=WAIT_MS)
        start_s, start_cpu_s = time.perf_counter(), processor_s(pid)
        page.locator("select[data-fcw-choice=listed]").select_option("MOMENTS")
        page.wait_for_function(f"document.body.innerText.includes({MOMENT_WORDS!r})", timeout=WAIT_MS)
        print(
            f"moments of all drives: {time.perf_counter() - start_s:.2f} s; "
            f"server {processor_s(pid) - start_cpu_s:.2f} s of processor time"
        )
        print(f"largest memory of the server: {memory_mb(pid):.0f} MB")


if __name__ == "__main__":
    main()
