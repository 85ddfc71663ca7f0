"""Speed measured side by side in one run, through the public interfaces only."""

import datetime
import platform
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from fcw.detection.acf import AcfDetector, FullAcfDetector
from fcw.detection.model import SHIPPED_MODEL_PATH, Model
from fcw.sources import open_source
from fcw.sources.frame import Frame, ImageSize, Source
from fcw.versions import machine, versions
from fcw_viz.drive_job import DriveJob, load_calibration, run_drive

DECODE, RELAYED, ENCODED = "decode alone", "whole job, video relayed", "whole job, video encoded anew"
PRIOR, FULL = "detector acf (distance prior)", "detector acf-full (whole picture)"


@dataclass(frozen=True, slots=True)
class Figures:
    """Milliseconds a frame of each case, a value a round.

    Attributes:
        heading: machine, date, versions and what it was measured on.
        ms_per_frame: by case.
        windows_per_frame: by detector case.
    """

    heading: str
    ms_per_frame: dict[str, list[float]]
    windows_per_frame: dict[str, int]

    def median_ratio(self, case: str, to: str) -> float:
        """Median over the rounds of the time of one case over that of another in the same round."""
        pairs = zip(self.ms_per_frame[case], self.ms_per_frame[to], strict=True)
        return statistics.median(a / b for a, b in pairs)

    def table_rows(self) -> Iterator[tuple[str, str, str, str]]:
        """Case, median, minimum and ratio as text."""
        for case, values in self.ms_per_frame.items():
            base = PRIOR if case in (PRIOR, FULL) else DECODE
            median_ms = statistics.median(values)
            rate = f" ({1e3 / median_ms:.0f}/s)"
            windows = f", {self.windows_per_frame[case]} windows" if case in self.windows_per_frame else ""
            yield (
                case + windows,
                f"{median_ms:.2f} ms{rate}",
                f"{min(values):.2f} ms",
                f"{self.median_ratio(case, base):.2f}",
            )

    def as_json(self) -> dict[str, Any]:
        """The same figures for scripts."""
        return {
            "heading": self.heading,
            "ms_per_frame": self.ms_per_frame,
            "windows_per_frame": self.windows_per_frame,
            "rate_of_whole_job_to_decoding": {
                case: 1 / self.median_ratio(case, DECODE)
                for case in (RELAYED, ENCODED)
                if case in self.ms_per_frame
            },
            "acf_time_to_acf_full": self.median_ratio(PRIOR, FULL),
        }


class _WithoutPackets:
    """A source whose video has to be encoded anew."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self.relays_video = False

    @property
    def name(self) -> str:
        return self._source.name

    @property
    def image_size(self) -> ImageSize:
        return self._source.image_size

    @property
    def frame_count(self) -> int | None:
        return self._source.frame_count

    @property
    def frame_rate_hz(self) -> float:
        return self._source.frame_rate_hz

    @property
    def notes(self) -> tuple[str, ...]:
        return self._source.notes

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in self._source.frames(start_ns):
            yield Frame(frame.index, frame.time_ns, frame.image)


def measure(
    path: Path, calibration_path: Path | None, rounds: int, detector_frames: int, console: Console
) -> Figures:
    """Measure decoding, the whole job and both detectors on one drive.

    The whole job is timed from the opened source to the closed logs, after a warm-up round that is not
    counted (kernels compile there). Detectors run on one thread, alternating frame by frame.
    """
    source = open_source(path)
    job = DriveJob(source=path, out=Path(), calibration=calibration_path)
    calibration = load_calibration(job, source)
    model = Model.load(SHIPPED_MODEL_PATH)
    prior, full = AcfDetector(model, calibration), FullAcfDetector(model)
    images = [frame.image for frame in islice(source.frames(), detector_frames)]
    silent = Console(quiet=True)

    def decode() -> int:
        return sum(1 for _ in open_source(path).frames())

    def whole_job(opened: Source) -> int:
        with tempfile.TemporaryDirectory() as folder:
            timed_job = DriveJob(source=path, out=Path(folder), calibration=calibration_path)
            return run_drive(timed_job, silent, opened).summary["frames"]

    cases: dict[str, Callable[[], int]] = {DECODE: decode}
    if source.relays_video:
        cases[RELAYED] = lambda: whole_job(open_source(path))
    cases[ENCODED] = lambda: whole_job(_WithoutPackets(open_source(path)))

    ms_per_frame: dict[str, list[float]] = {case: [] for case in (*cases, PRIOR, FULL)}
    detectors = {PRIOR: prior, FULL: full}
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("measuring", total=(rounds + 1) * (len(cases) + 1))
        for measured_round in range(-1, rounds):
            for case, work in cases.items():
                start = time.perf_counter()
                frames = work()
                if measured_round >= 0:
                    ms_per_frame[case].append(1e3 * (time.perf_counter() - start) / frames)
                progress.advance(task)
            spent = dict.fromkeys(detectors, 0.0)
            for image in images:
                for case, detector in detectors.items():
                    start = time.perf_counter()
                    detector.detect(image)
                    spent[case] += time.perf_counter() - start
            if measured_round >= 0:
                for case, seconds in spent.items():
                    ms_per_frame[case].append(1e3 * seconds / len(images))
            progress.advance(task)
    return Figures(
        _heading(source, rounds),
        ms_per_frame,
        {PRIOR: prior.windows_per_frame, FULL: full.windows_per_frame},
    )


def _heading(source: Source, rounds: int) -> str:
    libraries = ", ".join(f"{name} {value}" for name, value in versions().items())
    return (
        f"{source.name}, {source.image_size}; {rounds} rounds, medians\n"
        f"{machine()}, {platform.system()}; {datetime.date.today()}\n{libraries}"
    )
