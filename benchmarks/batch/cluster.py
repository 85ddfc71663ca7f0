"""What the benchmarks of a batch share: short drives, a cluster of one's own processes, and its commands."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.sources import open_source

DEMO = Path(__file__).parents[2] / "recordings" / "demo"
FCW = (sys.executable, "-m", "fcw_viz.cli")
DASK = (sys.executable, "-m", "dask")
SIZE, DEMO_RATE_HZ, DEMO_S = (640, 360), 30, 40.0


def write_drives(folder: Path, count: int, frames: int) -> None:
    """Parts of the demo drive's end at half its size, no two alike, with one calibration for the folder."""
    folder.mkdir(parents=True)
    pictures = []
    start_s = min(31.0, max(DEMO_S - (frames + count) / DEMO_RATE_HZ, 0.0))
    for frame in open_source(DEMO / "drive.mp4").frames(round(start_s * 1e9)):
        pictures.append(cv2.resize(frame.image, SIZE, interpolation=cv2.INTER_AREA))
        if len(pictures) == frames + count:
            break
    for number in range(count):
        _encode(folder / f"d{number:03d}.mp4", pictures[number : number + frames], DEMO_RATE_HZ)
    (folder / "calibration.yaml").write_bytes((DEMO / "drive.calibration.yaml").read_bytes())


def write_slower(path: Path, every: int) -> None:
    """The demo drive with one of so many pictures, as a camera of a lower rate would have taken it."""
    frames = open_source(DEMO / "drive.mp4").frames()
    _encode(path, (frame.image for frame in islice(frames, 0, None, every)), DEMO_RATE_HZ // every)


def _encode(path: Path, pictures: Iterable[NDArray[np.uint8]], rate_hz: int) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=rate_hz)
        stream.pix_fmt, stream.gop_size = "yuv420p", rate_hz
        stream.options = {"preset": "ultrafast", "bf": "0"}
        for number, picture in enumerate(pictures):
            if number == 0:
                stream.height, stream.width = picture.shape[:2]
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode(None))


@dataclass
class Cluster:
    """A Dask scheduler and workers, each a process of ours.

    Attributes:
        folder: for the address and the workers' files.
        workers: so many, each with a nanny that starts it anew.
    """

    folder: Path
    workers: int
    address: str = ""
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start all of them."""
        address_file = self.folder / "scheduler.json"
        address_file.unlink(missing_ok=True)
        common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(address_file)]
        self.processes = [self._process(*DASK, "scheduler", "--port", "0", *common)]
        while not address_file.exists():
            time.sleep(0.1)
        self.address = json.loads(address_file.read_text())["address"]
        of_workers = ["--nthreads", "1", "--nworkers", str(self.workers)]
        scratch = ["--local-directory", str(self.folder / "scratch")]
        self.processes.append(self._process(*DASK, "worker", *of_workers, *scratch, *common))

    def kill_scheduler(self) -> None:
        """As a machine that loses its power."""
        self.processes[0].kill()
        self.processes[0].wait()

    def worker_processes(self) -> list[int]:
        """The nannies' children."""
        return [pid for pid in children_of(self.processes[1].pid) if "spawn_main" in _command(pid)]

    def stop(self) -> None:
        """End all of them."""
        for process in reversed(self.processes):
            process.terminate()
        for process in self.processes:
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
        self.processes = []

    def _process(self, *command: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def children_of(parent: int) -> list[int]:
    """Processes that a process started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(stat.read_text().rpartition(")")[2].split()[1]) == parent:
                found.append(int(stat.parent.name))
        except OSError:
            continue
    return found


def _command(pid: int) -> str:
    try:
        return (Path("/proc") / str(pid) / "cmdline").read_bytes().decode(errors="replace")
    except OSError:
        return ""


def timed(command: list[str]) -> tuple[float, float]:
    """Run a command; wall time and processor time with that of all processes it waited for, in seconds."""
    start_s = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    return time.perf_counter() - start_s, usage.ru_utime + usage.ru_stime
