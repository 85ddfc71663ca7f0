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
"""On two cores a second thread saves a plugged-in YOLOv5n two fifths of the time, and costs `net`, whose
threads wait for the interpreter's lock, 3 to 6 % of it; `acf` nothing."""


@dataclass(frozen=True, slots=True)
class DriveJob:
    """What to run and how.

    Attributes:
        source: video file, MCAP file or folder of pictures; a path or its text, as all paths here.
        out: folder for the log and the summary; an earlier run's are replaced.
        calibration: the camera's, or its file; None looks beside the source, then into an MCAP file.
        topic: of an MCAP file, whose pictures; None where it has one topic of them.
        detector: one of `fcw.detection.choice.DETECTOR_NAMES`, or a detector of one's own, which one thread
            then uses.
        detector_classes: of an ONNX model, which are vehicles.
        model: file of `fcw train` for a detector named `net`, `acf` or `acf-full`; None: the shipped one.
        ego_speed: own speed: metres per second, or a CSV or GPX file; None takes what an MCAP file knows.
        warning_policy: one of `fcw.warning.policies.POLICIES`, or a policy of one's own.
        warning_timing: one of `fcw.warning.policies.TIMINGS_S`; not for a policy of one's own.
        imperial: distances shown to a person in feet.
        frame_rate_hz: for folders of pictures without time stamps.
        own_motion: whether own speed, yaw rate, mount and lane lines are taken from the picture.
        detection_threads: how many frames are searched at once, while others are decoded and written. 0 does
            everything in the thread that runs the job, as is best for one process of many.
        search_hz: see `SearchSchedule`; with 0, or a detector of one's own, every picture is searched.

    Raises:
        UserError: a value is none of its field's.
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
        """Make paths of texts, and look at what no type checker need have looked at."""
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
    """Whether it names a part of the program's, or is one of one's own."""
    return isinstance(value, str) or (not isinstance(value, type) and all(hasattr(value, n) for n in needs))


@dataclass(frozen=True, slots=True, eq=False)
class DriveOutcome:
    """What came of a job.

    Attributes:
        summary: what `summary.json` holds.
        notes: what a person should know of the source and of the drive.
        interrupted: whether it was stopped before the source's end.
    """

    summary: dict[str, Any]
    notes: tuple[str, ...]
    interrupted: bool


@dataclass(frozen=True, slots=True, eq=False)
class PreparedDrive:
    """A job with everything found and loaded that it needs; `run` runs it, once.

    Attributes:
        job: what to run.
        source: its open source.
        header: what the logs begin with.
        detectors: alike, one for each thread.
        policy: decides the warning.
        ego_speed: own speed; None where unknown.
        notes: what a person should know before it runs.
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
        """Run the drive to its end, and write its log and summary; see `run_drive` and `Stages`."""
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
        """Run it in a folder that is ready."""
        out = self.job.out
        # The noise of the own detector's boxes holds for a plugged-in one's too: against the boxes drawn by
        # hand on the training pictures, edges of YOLOv5n's and YOLOX-nano's scatter by 3 to 6 % of the height
        # (the model says 1 px and 4 %), heights are measured, and a visible side is taken in. Lower edges are
        # 1 to 4 % of the height lower than drawn, so that distances come out a little short.
        stages = Stages(
            self.detectors,
            Tracker(self.header.calibration),
            self.policy,
            self.ego_speed,
            (McapSink(out / MCAP_NAME), *sinks, *watchers),
            # For a watcher one in each detector, and none that waits.
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
        """The files that the run reads."""
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
        source: the job's source where it is open already, or one of one's own.
        sinks: logs of other kinds, written beside the MCAP log.
        watchers: who is told of every frame as soon as can be: with any of them few frames are under way at
            once.
        stop: once set, the frames under way are finished, and the logs closed.
        on_result: called after each frame was written.

    Raises:
        UserError: the source, the calibration or an option is wrong, or the logs cannot be written.
    """
    return prepare_drive(job, source).run(sinks, watchers, stop, on_result)


def prepare_drive(job: DriveJob, source: Source | None = None) -> PreparedDrive:
    """Open and load all that a job needs; nothing is written yet.

    Args:
        job: what to run.
        source: the job's source where it is open already.

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
    """What speaks against a calibration: whoever made it was told, and may have saved it all the same."""
    against = [finding.text for finding in plausibility(calibration) if finding.speaks_against]
    if not against:
        return ()
    more = f" ({len(against) - 1} more in its file)" if len(against) > 1 else ""
    return (f"the calibration looks wrong, so distances and warnings may be wrong too: {against[0]}{more}",)


def load_calibration(job: DriveJob, source: Source, facts: "McapFacts | None" = None) -> Calibration:
    """The calibration for a source, scaled to its image size.

    Args:
        job: what to run.
        source: its source.
        facts: what the source's file knows; its calibration counts where none was made beside it.

    Raises:
        UserError: there is none, or it is for another camera's image size.
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
    """The command for it, as a shell takes it."""
    topic = () if job.topic is None else ("--topic", job.topic)
    return shlex.join(("fcw", "calibrate", str(job.source), *topic))


def _has_own_calibration(job: DriveJob) -> bool:
    """Whether a calibration was named, or made beside the source; either is preferred to one in its file."""
    return job.calibration is not None or calibration_path(job.source).is_file()


def _field_of_view(facts: "McapFacts | None") -> str:
    """What a camera info is good for: it tells the focal length, but not where the camera is."""
    if facts is None or facts.field_of_view_rad is None:
        return ""
    degrees = math.degrees(facts.field_of_view_rad)
    return (
        f"; {facts.camera_topic} does not say where the camera is, only its field of view: "
        f"add `--field-of-view {degrees:.1f}` to the points"
    )


def _gpx(job: DriveJob) -> bytes:
    """The track that the own speed comes from."""
    return gpx_bytes(Path(str(job.ego_speed))) if _is_track(job) else b""


def _is_track(job: DriveJob) -> bool:
    """Whether the own speed is given as a GPX track."""
    return isinstance(job.ego_speed, str | Path) and str(job.ego_speed).lower().endswith(".gpx")


def _ego_speed(job: DriveJob, facts: "McapFacts | None") -> EgoSpeed | None:
    """The own speed that was given; else what the source's file knows of it."""
    if isinstance(job.ego_speed, EgoSpeed):
        return job.ego_speed
    if job.ego_speed is None:
        return None if facts is None else facts.ego_speed
    return EgoSpeed.parse(str(job.ego_speed))
