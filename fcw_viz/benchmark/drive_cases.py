"""What is timed by the clock over many frames: decoding, the whole job, and one and two threads."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.detection.acf import AcfDetector
from fcw.detection.model import Model
from fcw.frame import Frame, Source
from fcw.job import DriveJob
from fcw.sources import open_source
from fcw.sources.forwarding import ForwardingSource
from fcw.threads import one_opencv_thread
from fcw_viz.benchmark.picture_cases import Picture
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console

DECODE, RELAYED, ENCODED = "decoding alone", "whole job, video relayed", "whole job, video encoded anew"
ONE_THREAD, TWO_THREADS = "detector acf, one thread", "detector acf, two threads over frames"


class _WithoutPackets(ForwardingSource):
    """A source whose video has to be encoded anew."""

    @property
    def relays_video(self) -> bool:
        """False."""
        return False

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in self._source.frames(start_ns):
            yield Frame(frame.index, frame.time_ns, frame.image)


def drive_cases(job: DriveJob) -> dict[str, Callable[[], int]]:
    """Decoding alone and the whole job with both logs, each from opening the file to closing the logs.

    Args:
        job: on the drive; its logs go to a folder of their own each time.

    Returns:
        By name what to run; it returns the number of frames.
    """
    path = job.source

    def decode() -> int:
        return sum(1 for _ in open_source(path).frames())

    def whole_job(source: Source) -> int:
        with tempfile.TemporaryDirectory() as folder:
            outcome = run_on_console(replace(job, out=Path(folder)), SILENT, source)
            return outcome.summary["frames"]

    cases = {DECODE: decode}
    if open_source(path).relays_video:
        cases[RELAYED] = lambda: whole_job(open_source(path))
    cases[ENCODED] = lambda: whole_job(_WithoutPackets(open_source(path)))
    return cases


def thread_cases(
    pictures: Sequence[Picture], calibration: Calibration, model: Model
) -> dict[str, Callable[[], int]]:
    """The detector `acf` over pictures in one and in two threads; what to run returns their number."""
    detectors = [AcfDetector(model, calibration) for _ in range(2)]

    def detect_all(threads: int) -> int:
        def work(number: int) -> int:
            return sum(
                1 for image in pictures[number::threads] if detectors[number].detect(image) is not None
            )

        with one_opencv_thread(), ThreadPoolExecutor(threads) as pool:
            return sum(pool.map(work, range(threads)))

    return {ONE_THREAD: lambda: detect_all(1), TWO_THREADS: lambda: detect_all(2)}
