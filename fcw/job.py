"""The whole job on one drive: open, calibrate, detect, range, track, warn, log, sum up."""

import json
import math
import shlex
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fcw.bounded.gpx import gpx_bytes
from fcw.bounded.pictures import check_drive_size
from fcw.camera.calibration import Calibration
from fcw.camera.file import calibration_path, default_path, read_calibration
from fcw.camera.plausibility import plausibility
from fcw.detection.choice import DEFAULT_DETECTOR, DETECTOR_NAMES, load_model, make_detector, model_path
from fcw.detection.detector import Detection, Detector
from fcw.detection.model import model_sha256
from fcw.detection.schedule import DEFAULT_SEARCH_HZ
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.frame import DatedSource, Frame, Source, is_recorded
from fcw.logs.drive_folder import drive_folder
from fcw.logs.mcap.check import check_log
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import MCAP_NAME, SUMMARY_NAME
from fcw.logs.records import DriveHeader, FrameResult, Sink
from fcw.motion.ego import EgoEstimator
from fcw.pipeline import FRAMES_IN_FLIGHT, Stages, run_pipeline
from fcw.sources import is_mcap, open_source
from fcw.sources.bars import for_pictures
from fcw.sources.checked import CheckedSource
from fcw.sources.straight import straightened
from fcw.summary import DriveSummary
from fcw.threads import available_cores
from fcw.tracking.tracker import Tracker
from fcw.versions import versions
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.policies import DEFAULT_POLICY, DEFAULT_TIMING, POLICIES, make_policy, without_own_speed
from fcw.warning.types import WarningPolicy

if TYPE_CHECKING:
    from fcw.sources.mcap.facts import McapFacts

DETECTION_THREADS = min(available_cores(), 2)
"""On two cores, a second thread saves two fifths of the time with a plugged-in YOLOv5n. It costs `net`, whose
threads wait for the interpreter's lock, 3 to 6 %, and `acf` nothing."""


@dataclass(frozen=True, slots=True)
class DriveJob:
    """What to run, and how. Paths may be given as `Path` or `str`.

    Attributes:
        source: video file, MCAP file or folder of pictures.
        out: folder for the log and the summary; those of an earlier run are replaced.
        calibration: a calibration or its file; None looks for one beside the source, then in an MCAP source.
        topic: the image topic of an MCAP file; may be None if there is only one.
        detector: one of `fcw.detection.choice.DETECTOR_NAMES`, or your own detector object, which is then
            called from one thread only.
        detector_classes: names of the classes of an ONNX model that are vehicles.
        model: file of `fcw train` for the detectors `net`, `acf` and `acf-full`; None for the shipped one.
        ego_speed: own speed in metres per second, or a CSV or GPX file. None uses what an MCAP file has.
        warning_policy: one of `fcw.warning.policies.POLICIES`, or your own policy object.
        warning_timing: one of `fcw.warning.policies.TIMINGS_S`; ignored with your own policy.
        imperial: whether distances are shown in feet.
        frame_rate_hz: frame rate of a folder of pictures without timestamps.
        own_motion: whether own speed, yaw rate, mount and lane lines are estimated from the picture.
        detection_threads: how many frames are searched at once, while others are decoded and written. 0 does
            everything in the calling thread, which is best if many processes run side by side.
        search_hz: see `SearchSchedule`. With 0, or with your own detector, every frame is searched.

    Raises:
        UserError: a value is not valid for its field.
    """

    source: Path
    out: Path
    calibration: Path | Calibration | None = None
    topic: str | None = None
    detector: str | Detector = DEFAULT_DETECTOR
    detector_classes: tuple[str, ...] = ()
    model: Path | None = None
    ego_speed: str | float | Path | EgoSpeed | None = None
    warning_policy: str | WarningPolicy = DEFAULT_POLICY
    warning_timing: str = DEFAULT_TIMING
    imperial: bool = False
    frame_rate_hz: float | None = None
    own_motion: bool = True
    detection_threads: int = DETECTION_THREADS
    search_hz: float = DEFAULT_SEARCH_HZ

    def __post_init__(self) -> None:
        """Turn strings into paths, and check the types, as callers need not use a type checker."""
        for field in ("source", "out", "calibration", "model"):
            if isinstance(text := getattr(self, field), str):
                object.__setattr__(self, field, Path(text))
        speed, rate_hz, camera = self.ego_speed, self.frame_rate_hz, self.calibration
        speed_fits = isinstance(speed, str | Path | EgoSpeed | None) or _is_number(speed)
        named = isinstance(self.detector, str)
        fits_model = self.model is None or (isinstance(self.model, Path) and named)
        detectors = f"{', '.join(DETECTOR_NAMES)}, or an object with `name` and `detect`"
        policies = f"{', '.join(POLICIES)}, or an object with `update`"
        for field, fits, expected in (
            ("source", isinstance(self.source, Path), "a path"),
            ("out", isinstance(self.out, Path), "a path"),
            ("calibration", isinstance(camera, Path | Calibration | None), "a path, or a Calibration"),
            ("detector", _can_be(self.detector, "name", "detect"), detectors),
            ("detector_classes", not isinstance(self.detector_classes, str), "a tuple of names"),
            ("model", fits_model, "a path, beside a detector of the program's by its name"),
            ("ego_speed", speed_fits, "metres per second, the path of a CSV or GPX file, or an EgoSpeed"),
            ("warning_policy", _can_be(self.warning_policy, "update"), policies),
            ("search_hz", _is_number(self.search_hz) and self.search_hz >= 0, "pictures a second, or 0"),
            ("frame_rate_hz", rate_hz is None or _is_number(rate_hz), "a number of pictures a second"),
        ):
            if not fits:
                raise UserError(f"DriveJob({field}={getattr(self, field)!r:.80}): expected {expected}")


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _can_be(value: object, *needs: str) -> bool:
    """Whether it is a name, or an object with the attributes that its kind needs."""
    return isinstance(value, str) or (not isinstance(value, type) and all(hasattr(value, n) for n in needs))


@dataclass(frozen=True, slots=True, eq=False)
class DriveOutcome:
    """The result of a job.

    Attributes:
        summary: the contents of `summary.json`.
        notes: sentences about the source and the drive that the user should read.
        interrupted: whether the job was stopped before the end of the source.
    """

    summary: dict[str, Any]
    notes: tuple[str, ...]
    interrupted: bool


@dataclass(frozen=True, slots=True, eq=False)
class PreparedDrive:
    """A job with everything that it needs found and loaded. `run` runs it, once.

    Attributes:
        job: what to run.
        source: the job's source, opened.
        header: what the logs begin with.
        detectors: equal detectors, one for each thread.
        policy: decides the warning.
        ego_speed: own speed; None if it is not given.
        notes: sentences that the user should read before it runs.
    """

    job: DriveJob
    source: Source
    header: DriveHeader
    detectors: Sequence[Detector]
    policy: WarningPolicy
    ego_speed: EgoSpeed | None
    notes: tuple[str, ...]

    def run(
        self,
        sinks: Sequence[Sink] = (),
        watchers: Sequence[Sink] = (),
        stop: threading.Event | None = None,
        on_result: Callable[[FrameResult], None] = lambda result: None,
        known: Callable[[Frame], tuple[Detection, ...] | None] = lambda frame: None,
    ) -> DriveOutcome:
        """Run the drive to its end and write its log and summary; see `run_drive` and `Stages`."""
        out, stop = self.job.out, stop or threading.Event()
        pitch_rad, recorded = self.header.calibration.camera.pitch_rad, is_recorded(self.source)
        summary = DriveSummary(self.source.name, self.header.versions, pitch_rad, recorded)
        with drive_folder(out, self._inputs()):
            return self._run(summary, sinks, watchers, stop, on_result, known)

    def _run(
        self,
        summary: DriveSummary,
        sinks: Sequence[Sink],
        watchers: Sequence[Sink],
        stop: threading.Event,
        on_result: Callable[[FrameResult], None],
        known: Callable[[Frame], tuple[Detection, ...] | None],
    ) -> DriveOutcome:
        """Run the job; the output folder exists and is locked."""
        out = self.job.out
        # The tracker models the box noise of our own detectors for plugged-in ones too. Compared with boxes
        # drawn by hand on the training pictures, edges of YOLOv5n's and YOLOX-nano's boxes scatter by 3 to 6
        # % of the height (the model says 1 px and 4 %), heights are right, and a visible side is included.
        # Lower edges are 1 to 4 % of the height too low, so that distances come out a little short.
        stages = Stages(
            self.detectors,
            Tracker(self.header.calibration),
            self.policy,
            self.ego_speed,
            (McapSink(out / MCAP_NAME), *sinks, *watchers),
            # With watchers, one frame in each detector and none that waits, to keep the delay short.
            len(self.detectors) if watchers else FRAMES_IN_FLIGHT,
            EgoEstimator(self.header.calibration) if self.job.own_motion else None,
            known,
            one_thread=self.job.detection_threads == 0,
            search_hz=self.job.search_hz,
        )

        def add(result: FrameResult) -> None:
            summary.add(result)
            on_result(result)

        start = time.perf_counter()
        run_pipeline(self.source, stages, self.header, stop, add)
        if summary.frames == 0 and not stop.is_set():
            raise UserError("; ".join((f"{self.job.source}: no frame could be read", *self.source.notes)))
        check_log(out / MCAP_NAME, summary.frames)
        given = summary.notes_on(self.ego_speed)
        notes = (*self.notes, *self.source.notes, *given, *summary.all_notes)
        as_json = summary.as_json(time.perf_counter() - start) | {"notes": [*notes]}
        write_whole(out / SUMMARY_NAME, json.dumps(as_json, indent=2) + "\n")
        return DriveOutcome(as_json, notes, stop.is_set())

    def _inputs(self) -> list[Path]:
        """The files that the run reads, which its output must not replace."""
        job = self.job
        texts = [job.detector.removeprefix("onnx:")] if isinstance(job.detector, str) else []
        texts += [str(job.ego_speed)] if isinstance(job.ego_speed, str | Path) else []
        named = [job.calibration] if isinstance(job.calibration, Path) else [calibration_path(job.source)]
        return [job.source, *named, *filter(None, [job.model]), *map(Path, texts)]


def run_drive(
    job: DriveJob,
    source: Source | None = None,
    sinks: Sequence[Sink] = (),
    watchers: Sequence[Sink] = (),
    stop: threading.Event | None = None,
    on_result: Callable[[FrameResult], None] = lambda result: None,
) -> DriveOutcome:
    """Run the whole job on a drive and write `drive.mcap` and `summary.json` to its folder.

    Args:
        job: what to run.
        source: the job's source if it is open already, or your own source object.
        sinks: other logs, written beside the MCAP log.
        watchers: sinks that need every frame with little delay. If there are any, fewer frames are in flight
            at once.
        stop: once set, the frames in flight are finished and the logs closed.
        on_result: called after each frame has been written.

    Raises:
        UserError: the source, the calibration or an option is wrong, or the logs cannot be written.
    """
    return prepare_drive(job, source).run(sinks, watchers, stop, on_result)


def prepare_drive(job: DriveJob, source: Source | None = None) -> PreparedDrive:
    """Open and load all that a job needs. Nothing is written yet.

    Args:
        job: what to run.
        source: the job's source if it is open already.

    Raises:
        UserError: the source, the calibration or an option is wrong, or the pictures are too large.
    """
    source = CheckedSource(source) if source else open_source(job.source, job.frame_rate_hz, job.topic)
    check_drive_size(job.source, source.image_size.width, source.image_size.height)
    facts = None
    if is_mcap(job.source):
        from fcw.sources.mcap.facts import mcap_facts

        facts = mcap_facts(job.source, job.topic)
    zero_utc_ns = source.zero_utc_ns if isinstance(source, DatedSource) else None
    calibration = load_calibration(job, source, facts)
    doubts = _doubts(calibration) + (() if facts is None else facts.notes_on_lens(calibration))
    source, calibration = straightened(source, calibration)
    detector = job.detector
    model = load_model(detector, job.detector_classes, job.model) if isinstance(detector, str) else None
    ego_speed = _ego_speed(job, facts)
    policy, notes = job.warning_policy, ()
    if isinstance(policy, str):
        name, policy = policy, make_policy(policy, job.warning_timing)
        if ego_speed is None and not job.own_motion:
            notes = (without_own_speed(name),)
    if facts is not None and job.ego_speed is None:
        notes = (*facts.notes, *notes)
    if facts is not None and facts.calibration is not None and not _has_own_calibration(job):
        notes = (f"{source.name}: calibration from the file itself", *notes)
    elif facts is not None and job.calibration is None:
        notes = (*facts.notes_on_calibration(calibration_path(job.source)), *notes)
    if job.calibration is None and (beside := calibration_path(job.source)) != default_path(job.source):
        notes = (f"{source.name}: calibration from {beside}", *notes)
    notes = (*doubts, *notes)
    if isinstance(detector, str):
        assert model is not None
        sha256 = model_sha256(model_path(detector, job.model))
        count = max(job.detection_threads, 1)
        detectors = [make_detector(detector, model, calibration, for_tracker=True) for _ in range(count)]
    else:
        sha256, detectors, job = "", [detector], replace(job, search_hz=0.0)
    header = DriveHeader(
        source=source.name,
        image_size=source.image_size,
        frame_rate_hz=source.frame_rate_hz,
        calibration=calibration,
        relays_video=source.relays_video,
        detector=detectors[0].name,
        model_sha256=sha256,
        versions=versions(),
        imperial=job.imperial,
        zero_utc_ns=zero_utc_ns,
        gpx=_gpx(job),
    )
    return PreparedDrive(job, source, header, detectors, policy, ego_speed, notes)


def _doubts(calibration: Calibration) -> tuple[str, ...]:
    """A note if the calibration looks wrong; whoever made it may have saved it despite the warning."""
    against = [finding.text for finding in plausibility(calibration) if finding.speaks_against]
    if not against:
        return ()
    more = f" ({len(against) - 1} more in its file)" if len(against) > 1 else ""
    return (f"the calibration looks wrong, so distances and warnings may be wrong too: {against[0]}{more}",)


def load_calibration(job: DriveJob, source: Source, facts: "McapFacts | None" = None) -> Calibration:
    """The calibration for a source, scaled to its image size.

    Args:
        job: what to run.
        source: the job's source.
        facts: what an MCAP source's file says. Its calibration is used if there is none beside the source.

    Raises:
        UserError: there is none, or it is for another image size.
    """
    if isinstance(job.calibration, Calibration):
        return for_pictures(job.calibration, source)
    path = job.calibration or calibration_path(job.source)
    if facts is not None and facts.calibration is not None and not _has_own_calibration(job):
        path, calibration = job.source, facts.calibration
    elif path.is_file():
        calibration = read_calibration(path)
    else:
        raise UserError(
            f"{path}: no calibration for {job.source}; `{_calibrating(job)}` opens a page for one, "
            "--from-clip makes a rough one from the drive alone; or name one with --calibration"
            + _field_of_view(facts)
        )
    try:
        return for_pictures(calibration, source)
    except UserError as error:
        raise error if str(path) in str(error) else UserError(f"{path}: {error}") from None


def _calibrating(job: DriveJob) -> str:
    """The command that calibrates the job's source, quoted for a shell."""
    topic = () if job.topic is None else ("--topic", job.topic)
    return shlex.join(("fcw", "calibrate", str(job.source), *topic))


def _has_own_calibration(job: DriveJob) -> bool:
    """Whether one was given or lies beside the source; either takes precedence over one in an MCAP file."""
    return job.calibration is not None or calibration_path(job.source).is_file()


def _field_of_view(facts: "McapFacts | None") -> str:
    """Advice on the field of view in a camera info message, which does not say how the camera is mounted."""
    if facts is None or facts.field_of_view_rad is None:
        return ""
    degrees = math.degrees(facts.field_of_view_rad)
    return (
        f"; {facts.camera_topic} does not say where the camera is, only its field of view: "
        f"add `--field-of-view {degrees:.1f}` to the points"
    )


def _gpx(job: DriveJob) -> bytes:
    """The GPX file that the own speed comes from, to be logged; empty if there is none."""
    return gpx_bytes(Path(str(job.ego_speed))) if _is_track(job) else b""


def _is_track(job: DriveJob) -> bool:
    """Whether the own speed is given as a GPX track."""
    return isinstance(job.ego_speed, str | Path) and str(job.ego_speed).lower().endswith(".gpx")


def _ego_speed(job: DriveJob, facts: "McapFacts | None") -> EgoSpeed | None:
    """The own speed that was given, else the one in the source's file."""
    if isinstance(job.ego_speed, EgoSpeed):
        return job.ego_speed
    if job.ego_speed is None:
        return None if facts is None else facts.ego_speed
    return EgoSpeed.parse(str(job.ego_speed))
