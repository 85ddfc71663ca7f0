"""The rounds of a benchmark: each runs every case once."""

import datetime
import platform
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path

from rich.console import Console

from fcw.camera.file import calibration_path
from fcw.detection.choice import DetectorModel
from fcw.detection.model import SHIPPED_MODEL_PATH, Model, model_sha256
from fcw.frame import Source
from fcw.job import DriveJob, load_calibration
from fcw.sources import is_mcap, open_source
from fcw.sources.mcap.facts import mcap_facts
from fcw.sources.straight import straightened
from fcw.sources.video import VideoSource
from fcw.threads import one_opencv_thread
from fcw.versions import machine, versions
from fcw_viz.benchmark.drive_cases import drive_cases, thread_cases
from fcw_viz.benchmark.figures import Figures
from fcw_viz.benchmark.long_drive import repeat_packets
from fcw_viz.benchmark.picture_cases import Picture, PictureCase, picture_cases
from fcw_viz.benchmark.stages import stage_times
from fcw_viz.console import progress

STAGES_S = 4.0
"""How much of the drive is run stage by stage: enough for the tracks to be believed."""


def measure(
    path: Path,
    calibration_path: Path | None,
    rounds: int,
    picture_count: int,
    console: Console,
    plugged_in: tuple[str, DetectorModel] | None = None,
    shortest_s: float = 0.0,
) -> Figures:
    """Measure every case on one drive, after a round that is not counted: kernels compile there.

    Args:
        path: the drive.
        calibration_path: its calibration; None looks beside it.
        rounds: that are counted.
        picture_count: pictures of a round, from all over the drive.
        console: where the progress is drawn; nothing is drawn unless it is a terminal.
        plugged_in: name and model of another detector to measure beside the own ones.
        shortest_s: a shorter video is repeated to about this duration for what is done with whole drives;
            opening and closing weigh in a short one as they never do on the road.
    """
    source = open_source(path)
    job = DriveJob(source=path, out=Path(), calibration=calibration_path)
    calibration = load_calibration(job, source, mcap_facts(path) if is_mcap(path) else None)
    source, calibration = straightened(source, calibration)
    model = Model.load(SHIPPED_MODEL_PATH)
    step = max((source.frame_count or picture_count) // picture_count, 1)
    pictures = [frame.image for frame in islice(source.frames(), 0, step * picture_count, step)]
    picture_ms: dict[str, list[float]] = defaultdict(list)
    drive_ms: dict[str, list[float]] = defaultdict(list)
    stages_ms: dict[str, list[float]] = defaultdict(list)
    preparing = "preparing (compiles once)"
    with progress(preparing, None, console) as bar, _long_enough(job, source, shortest_s) as drive:
        on_pictures = picture_cases(pictures[0], calibration, model, plugged_in)
        on_drive = drive_cases(drive) | thread_cases(pictures, calibration, model)
        frames_of_drive = open_source(drive.source).frame_count or 0
        bar.begin("measuring", (rounds + 1) * (len(on_drive) + 2))
        for measured_round in range(-1, rounds):
            for name, run in on_drive.items():
                start = time.perf_counter()
                frames = run()
                if measured_round >= 0:
                    drive_ms[name].append(1e3 * (time.perf_counter() - start) / frames)
                bar.advance()
            for name, value in _picture_round(on_pictures, pictures).items():
                if measured_round >= 0:
                    picture_ms[name].append(value)
            bar.advance()
            for name, value in stage_times(job, STAGES_S).items():
                if measured_round >= 0:
                    stages_ms[name].append(value)
            bar.advance()
    windows = {name: case.windows for name, case in on_pictures.items() if case.windows is not None}
    heading = _heading(source, rounds, len(pictures), frames_of_drive)
    return Figures(heading, picture_ms, drive_ms, stages_ms, windows)


@contextmanager
def _long_enough(job: DriveJob, source: Source, shortest_s: float) -> Iterator[DriveJob]:
    """The job on its drive, or on a file for as long as it is needed in which a video is repeated."""
    path, duration_s = job.source, (source.frame_count or 0) / source.frame_rate_hz
    if not isinstance(source, VideoSource) or duration_s >= shortest_s:
        yield job
        return
    with tempfile.TemporaryDirectory() as folder:
        long = Path(folder) / f"{path.stem}-repeated{path.suffix}"
        repeat_packets(path, long, shortest_s)
        yield replace(job, source=long, calibration=job.calibration or calibration_path(path))


def _picture_round(cases: Mapping[str, PictureCase], pictures: Sequence[Picture]) -> dict[str, float]:
    """Milliseconds of each case, the median over the pictures, on which they take turns.

    The thread's own time is counted, not that of others which the scheduler lets in between.
    """
    taken: dict[str, list[float]] = {name: [] for name in cases}
    with one_opencv_thread():
        for picture in pictures:
            for name, case in cases.items():
                start = time.thread_time()
                case.run(picture)
                taken[name].append(1e3 * (time.thread_time() - start))
    return {name: statistics.median(values) for name, values in taken.items()}


def _heading(source: Source, rounds: int, pictures: int, frames: int) -> str:
    libraries = ", ".join(f"{name} {value}" for name, value in versions().items())
    return (
        f"{source.name}, {source.image_size}; {rounds} rounds, {pictures} pictures and {frames} "
        f"frames of the whole drive in each; model {model_sha256(SHIPPED_MODEL_PATH)[:12]}\n"
        f"{machine()}, {platform.system()}; {datetime.date.today()}\n{libraries}"
    )
