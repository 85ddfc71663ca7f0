"""The whole job on one drive, as `fcw run` and `fcw demo` do it: open, detect, range, warn, log, sum up."""

import json
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from fcw.camera.calibration import Calibration
from fcw.camera.file import default_path, read_calibration
from fcw.detection.choice import load_model, make_detector, model_path
from fcw.detection.model import model_sha256
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.frame import Source
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult, Sink
from fcw.pipeline import FRAMES_IN_FLIGHT, Stages, run_pipeline
from fcw.sources import is_mcap, open_source
from fcw.summary import DriveSummary
from fcw.tracking.tracker import Tracker
from fcw.versions import versions
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.policies import DEFAULT_POLICY, make_policy, without_own_speed
from fcw_viz.rerun.log import RerunSink

if TYPE_CHECKING:
    from fcw.sources.mcap.facts import McapFacts

MCAP_NAME = "drive.mcap"
RRD_NAME = "drive.rrd"
SUMMARY_NAME = "summary.json"
DETECTION_THREADS = min(max((os.cpu_count() or 1) - 1, 1), 2)
"""Detection takes about as long as decoding. On two cores a second thread only gets in the way of decoding,
tracking and writing; a third has nothing left to do."""
LIVE_FRAMES_IN_FLIGHT = DETECTION_THREADS
"""One in each detector, and none that waits."""


@dataclass(frozen=True, slots=True)
class DriveJob:
    """What to run and how.

    Attributes:
        source: video file, MCAP file or folder of pictures.
        out: folder for the logs and the summary.
        calibration: its calibration file; None looks beside the source, then into an MCAP file.
        topic: of an MCAP file, whose pictures; None where it has one topic of them.
        detector: one of `fcw.detection.choice.DETECTOR_NAMES`.
        detector_classes: of an ONNX model, which are vehicles.
        ego_speed: metres per second, or a CSV or GPX file; None takes what an MCAP file knows.
        warning_policy: one of `fcw.warning.policies.POLICIES`.
        imperial: distances shown to a person in feet.
        frame_rate_hz: for folders of pictures without time stamps.
    """

    source: Path
    out: Path
    calibration: Path | None = None
    topic: str | None = None
    detector: str = "acf"
    detector_classes: tuple[str, ...] = ()
    ego_speed: str | None = None
    warning_policy: str = DEFAULT_POLICY
    imperial: bool = False
    frame_rate_hz: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class DriveOutcome:
    """What came of a job: the JSON summary, what to know of the source, and whether it was interrupted."""

    summary: dict[str, Any]
    notes: tuple[str, ...]
    interrupted: bool


def load_calibration(job: DriveJob, source: Source, facts: "McapFacts | None" = None) -> Calibration:
    """The calibration for a source, scaled to its image size.

    Args:
        job: what to run.
        source: its source.
        facts: what the source's file knows; its calibration counts where none was made beside it.

    Raises:
        UserError: there is none, or it is for another camera's image size.
    """
    path = job.calibration or default_path(job.source)
    if facts is not None and facts.calibration is not None and not _has_own_calibration(job):
        path, calibration = job.source, facts.calibration
    elif path.is_file():
        calibration = read_calibration(path)
    else:
        raise UserError(
            f"{path}: no calibration for {job.source}; make one with `fcw calibrate {job.source} "
            "--points ... --height ...`, or name an existing one with --calibration" + _field_of_view(facts)
        )
    try:
        return calibration.for_image_size(source.image_size)
    except UserError as error:
        raise error if str(path) in str(error) else UserError(f"{path}: {error}") from None


def _has_own_calibration(job: DriveJob) -> bool:
    """Whether a calibration was named, or made beside the source; either is preferred to one in its file."""
    return job.calibration is not None or default_path(job.source).is_file()


def _field_of_view(facts: "McapFacts | None") -> str:
    """What a camera info is good for: it tells the focal length, but not where the camera is."""
    if facts is None or facts.field_of_view_rad is None:
        return ""
    degrees = math.degrees(facts.field_of_view_rad)
    return (
        f"; {facts.camera_topic} does not say where the camera is, only its field of view: "
        f"add `--field-of-view {degrees:.1f}` to the points"
    )


def _ego_speed(job: DriveJob, source: Source, facts: "McapFacts | None") -> EgoSpeed | None:
    """The own speed that was given; else what the source's file knows of it."""
    if job.ego_speed is None:
        return None if facts is None else facts.ego_speed
    speed = EgoSpeed.parse(job.ego_speed)
    if facts is None or not job.ego_speed.lower().endswith(".gpx"):
        return speed
    start_s = next(source.frames()).time_ns / 1e9  # a track begins with the drive, not in 1970
    return EgoSpeed(tuple(time_s + start_s for time_s in speed.times_s), speed.speeds_mps)


def run_drive(
    job: DriveJob,
    console: Console,
    source: Source | None = None,
    watchers: Sequence[Sink] = (),
    stop: threading.Event | None = None,
) -> DriveOutcome:
    """Run a job with a progress bar on `console`; Ctrl-C ends it early with complete logs.

    Args:
        job: what to run.
        console: where the bar is drawn; nothing is drawn unless it is a terminal.
        source: the job's source where it is open already.
        watchers: who is told of every frame beside the logs; with any of them few frames are under way at
            once, so that results are as new as can be.
        stop: what Ctrl-C sets; an event of its own by default.
    """
    source = source or open_source(job.source, job.frame_rate_hz, job.topic)
    facts = None
    if is_mcap(job.source):
        from fcw.sources.mcap.facts import mcap_facts

        facts = mcap_facts(job.source, job.topic)
    calibration = load_calibration(job, source, facts)
    model = load_model(job.detector, job.detector_classes)
    ego_speed = _ego_speed(job, source, facts)
    policy = make_policy(job.warning_policy)
    notes = () if ego_speed is not None else (without_own_speed(job.warning_policy),)
    if facts is not None and job.ego_speed is None:
        notes = (*facts.notes, *notes)
    if facts is not None and facts.calibration is not None and not _has_own_calibration(job):
        notes = (f"{source.name}: calibration from the file itself", *notes)
    detectors = [make_detector(job.detector, model, calibration) for _ in range(DETECTION_THREADS)]
    header = DriveHeader(
        source=source.name,
        image_size=source.image_size,
        frame_rate_hz=source.frame_rate_hz,
        calibration=calibration,
        relays_video=source.relays_video,
        detector=detectors[0].name,
        model_sha256=model_sha256(model_path(job.detector)),
        versions=versions(),
        imperial=job.imperial,
    )
    summary = DriveSummary(source.name, header.versions)
    if job.source.resolve() == (job.out / MCAP_NAME).resolve():
        raise UserError(f"--out {job.out}: the new log would replace {job.source}; name another folder")
    try:
        job.out.mkdir(parents=True, exist_ok=True)
        for name in (MCAP_NAME, RRD_NAME, SUMMARY_NAME):  # an earlier run's must not stand beside this run's
            (job.out / name).unlink(missing_ok=True)
    except OSError as error:
        raise UserError(
            f"--out {job.out}: cannot be the folder of the logs ({error.strerror}); "
            "name one that can be written"
        ) from error
    sinks: tuple[Sink, ...] = (McapSink(job.out / MCAP_NAME), RerunSink(job.out / RRD_NAME))
    in_flight = LIVE_FRAMES_IN_FLIGHT if watchers else FRAMES_IN_FLIGHT
    # The noise of the own detector's boxes holds for a plugged-in one's too: against the boxes drawn by hand
    # on the training pictures, edges of YOLOv5n's and YOLOX-nano's scatter by 3 to 6 % of the height (the
    # model says 1 px and 4 %), heights are measured, and a visible side is taken in. Lower edges are 1 to 4 %
    # of the height lower than drawn, so that distances come out a little short.
    stages = Stages(detectors, Tracker(calibration), policy, ego_speed, (*sinks, *watchers), in_flight)

    start = time.perf_counter()
    with stop_on_interrupt(stop) as stop, _progress(console, source) as advance:

        def on_result(result: FrameResult) -> None:
            summary.add(result)
            advance()

        run_pipeline(source, stages, header, stop, on_result)
    if summary.frames == 0 and not stop.is_set():
        raise UserError(f"{job.source}: no frame could be read; " + "; ".join(source.notes))
    as_json = summary.as_json(time.perf_counter() - start)
    write_whole(job.out / SUMMARY_NAME, json.dumps(as_json, indent=2) + "\n")
    return DriveOutcome(as_json, (*notes, *source.notes, *summary.notes), stop.is_set())


@contextmanager
def stop_on_interrupt(event: threading.Event | None = None) -> Iterator[threading.Event]:
    """An event that the first Ctrl-C (or SIGTERM) sets; a second one interrupts at once."""
    stop = event or threading.Event()

    def on_signal(number: int, _stack: FrameType | None) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _progress(console: Console, source: Source) -> Iterator[Callable[[], None]]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]:.0f} frames/s"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        starting = "starting (the first time kernels are compiled)"
        task = progress.add_task(starting, total=source.frame_count, rate=0.0)
        start, frames = time.perf_counter(), 0

        def advance() -> None:
            nonlocal frames
            frames += 1
            rate = frames / (time.perf_counter() - start)
            progress.update(task, description=source.name, advance=1, rate=rate)

        yield advance
