"""The loop: source -> detect -> track -> warn -> sinks, with decoding, detection and writing overlapped.

One thread decodes, one per detector finds vehicles, one estimates our own motion, and one encodes if the
source's video cannot be relayed. The calling thread tracks, warns and writes, in the order of the frames.
Alternatively, the calling thread does everything. That takes less processor time, and is meant for many
processes side by side.
"""

import queue
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace

from fcw.box import Box
from fcw.detection.asking import vehicles_in
from fcw.detection.detector import Aim, Detection, Detector
from fcw.detection.schedule import SearchSchedule
from fcw.frame import Frame, Source, VideoPacket, nothing_seen
from fcw.logs.encode import VideoEncoder
from fcw.logs.records import CUT, NOTHING_SEEN, DriveHeader, FrameResult, Sink, in_single_precision
from fcw.motion.aiming import Aims, take_aim
from fcw.motion.ego import Ego, EgoEstimator
from fcw.motion.flow.cuts import Follows
from fcw.sources.repeated import RepeatedPictures
from fcw.threads import one_opencv_thread
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.warning.asking import state_by
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.types import BeginsAnew, WarningPolicy

FRAMES_IN_FLIGHT = 8
"""Enough that no stage waits when another one has an occasional slow frame; 22 MB of pictures at 1280x720."""
MOST_BYTES_IN_FLIGHT = 80 << 20
"""Limits the frames in flight if pictures are large: three of 3840x2160, one of 5312x2988."""


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """The parts of the loop.

    Attributes:
        detectors: equal detectors, one for each detection thread.
        tracker: follows the vehicles.
        policy: decides the warning.
        ego_speed: own speed over time, with the yaw rate if it is known; None if it is not given.
        sinks: where the results are written.
        frames_in_flight: the most frames that are read ahead of the one being written; fewer if pictures are
            large. A live drive needs few, as each frame waits for those before it.
        ego: estimates own motion and path from the picture; None uses only what is given.
        known: returns what an earlier run found in a frame; None for a frame that is yet to be searched.
        one_thread: whether the calling thread does everything, with the first detector.
        search_hz: how many frames per second are searched, in addition to those that the tracker asks for;
            see `SearchSchedule`. 0 searches all.
    """

    detectors: Sequence[Detector]
    tracker: Tracker
    policy: WarningPolicy
    ego_speed: EgoSpeed | None = None
    sinks: Sequence[Sink] = ()
    frames_in_flight: int = FRAMES_IN_FLIGHT
    ego: EgoEstimator | None = None
    known: Callable[[Frame], tuple[Detection, ...] | None] = lambda frame: None
    one_thread: bool = False
    search_hz: float = 0.0


def run_pipeline(
    source: Source,
    stages: Stages,
    header: DriveHeader,
    stop: threading.Event | None = None,
    on_result: Callable[[FrameResult], None] = lambda result: None,
) -> None:
    """Run the whole job on a drive. Every sink is closed, whatever happens.

    Args:
        source: the drive.
        stages: detectors, tracker, policy and sinks.
        header: what the sinks write first.
        stop: once set, the frames in flight are finished and the logs closed.
        on_result: called after each frame has been written.
    """
    with ExitStack() as stack:
        stack.enter_context(one_opencv_thread())
        for sink in stages.sinks:
            sink.open(header)
            stack.callback(sink.close)
        detected_frames = _in_one_thread if stages.one_thread else _overlapped
        aims = Aims(stages.tracker.believed_mount, max(stages.frames_in_flight, FRAMES_IN_FLIGHT))
        schedule = SearchSchedule(source.frame_rate_hz, stages.search_hz)
        stop = stop or threading.Event()
        frames = stack.enter_context(closing(detected_frames(source, stages, aims, schedule, stop)))
        result = None
        for frame, repeats, detections, ego, packets in frames:
            if result is not None and repeats and ego.follows is Follows.SAME_VIEW:
                result = again(result, frame)
            else:
                result = follow(frame, detections, ego, stages)
            aims.believe(stages.tracker.believed_mount)
            for sink in stages.sinks:
                sink.write(result, packets)
            on_result(result)


def follow(frame: Frame, detections: tuple[Detection, ...] | None, ego: Ego, stages: Stages) -> FrameResult:
    """Update tracker and policy with a frame, and return its result. Frames must be in order of time.

    Args:
        frame: the picture and its time.
        detections: the vehicles found in it; None if it was not searched.
        ego: own motion and path at this frame.
        stages: has the tracker and the policy.
    """
    if ego.follows is Follows.UNLIKE:
        detections = None
    elif ego.follows is Follows.AFTER_CUT and isinstance(stages.policy, BeginsAnew):
        stages.policy.begin_anew()
    blank = nothing_seen(frame.image)
    told = (
        (NOTHING_SEEN, blank),
        (CUT, ego.follows is Follows.AFTER_CUT),
        (ego.poor_sight, ego.poor_sight and not blank),
    )
    own_mps = ego.motion.speed_mps
    tracks = stages.tracker.update(frame.time_ns, detections, ego, frame.image)
    tracks = tuple(map(in_single_precision, tracks))
    threats = threats_of(stages.tracker, tracks, ego)
    return FrameResult(
        index=frame.index,
        time_ns=frame.time_ns,
        detections=tuple(in_single_precision(found) for found in detections or () if not found.faint),
        tracks=tracks,
        lead_id=stages.tracker.lead_id,
        warning=state_by(stages.policy, frame, threats, own_mps),
        ego_speed_mps=own_mps,
        notes=(*stages.tracker.notes, *(note for note, holds in told if holds)),
        own_motion=in_single_precision(ego.motion),
        own_path=in_single_precision(ego.path),
        searched=detections is not None,
    )


def again(result: FrameResult, frame: Frame) -> FrameResult:
    """The result for a frame that repeats the previous picture: the previous result at the new time."""
    notes = tuple(note for note in result.notes if note != CUT)
    return replace(
        result,
        index=frame.index,
        time_ns=frame.time_ns,
        detections=(),
        notes=notes,
        searched=False,
        repeated=True,
    )


_Found = tuple[Detection, ...] | None
_Detected = tuple[Frame, bool, _Found, Ego, tuple[VideoPacket, ...]]
_Stream = Generator[_Detected, None, None]
_Pending = tuple[Frame, bool, Aim, Future[_Found], Future[Ego], Future[tuple[VideoPacket, ...]] | None]

_UNSEARCHED: Future[_Found] = Future()
_UNSEARCHED.set_result(None)


def _search(detector: Detector, frame: Frame, aim: Aim) -> tuple[Detection, ...]:
    take_aim(detector, aim)
    return vehicles_in(detector, frame)


def _known(stages: Stages, frame: Frame, aim: Aim, first: Aim) -> tuple[Detection, ...] | None:
    """What an earlier run found, if the detector still looks in the same place; it began at `first`."""
    found = stages.known(frame)
    return found if aim == first else None


def _in_one_thread(
    source: Source, stages: Stages, aims: Aims, schedule: SearchSchedule, stop: threading.Event
) -> _Stream:
    """Frames in order with their detections, own motion and packets, all made by the calling thread."""

    def detect(frame: Frame, aim: Aim) -> tuple[Detection, ...]:
        known = _known(stages, frame, aim, aims.first)
        return _search(stages.detectors[0], frame, aim) if known is None else known

    ego, encoder, shown = _Ourselves(stages), _encoder(source, stages), RepeatedPictures()
    try:
        for frame in source.frames():
            aim, repeats = aims.next(), shown.is_repeated(frame)
            found = detect(frame, aim) if not repeats and schedule.searches(frame.time_ns) else None
            moving = ego.see(frame, found)
            if found is None and not repeats and stages.tracker.wants_search:
                found = detect(frame, aim)
            yield frame, repeats, found, moving, encoder.encode(frame) if encoder else frame.packets
            if stop.is_set():
                break
    finally:
        if encoder:
            encoder.close()


def _overlapped(
    source: Source, stages: Stages, aims: Aims, schedule: SearchSchedule, stop: threading.Event
) -> _Stream:
    """Frames in order with their detections, own motion and packets, made by threads.

    An exception in a thread is raised here.
    """
    idle_detectors: queue.SimpleQueue[Detector] = queue.SimpleQueue()
    for detector in stages.detectors:
        idle_detectors.put(detector)

    def detect(frame: Frame, aim: Aim) -> _Found:
        if (known := _known(stages, frame, aim, aims.first)) is not None:
            return known
        detector = idle_detectors.get()
        try:
            return _search(detector, frame, aim)
        finally:
            idle_detectors.put(detector)

    def see_ourselves(frame: Frame, detecting: Future[_Found]) -> Ego:
        return ego.see(frame, detecting.result())

    ego, encoder, shown = _Ourselves(stages), _encoder(source, stages), RepeatedPictures()
    abandoned = threading.Event()
    pending: queue.SimpleQueue[_Pending | BaseException | None] = queue.SimpleQueue()
    size = source.image_size
    bearable = MOST_BYTES_IN_FLIGHT // (3 * size.width * size.height)
    room = threading.Semaphore(min(stages.frames_in_flight, max(bearable, 1)))

    def read() -> None:
        try:
            frames = iter(source.frames())
            # Wait for room before reading, so that a live frame is as new as possible when it is searched.
            while room.acquire() and not abandoned.is_set() and (frame := next(frames, None)) is not None:
                encoding = encoding_pool.submit(encoder.encode, frame) if encoder else None
                aim, detecting, repeats = aims.next(), _UNSEARCHED, shown.is_repeated(frame)
                if not repeats and schedule.searches(frame.time_ns):
                    detecting = detection_pool.submit(detect, frame, aim)
                seeing = ego_pool.submit(see_ourselves, frame, detecting)
                pending.put((frame, repeats, aim, detecting, seeing, encoding))
                if stop.is_set():
                    break
            pending.put(None)
        except BaseException as error:
            pending.put(error)

    with (
        ThreadPoolExecutor(len(stages.detectors), "detect") as detection_pool,
        ThreadPoolExecutor(1, "ego") as ego_pool,
        ThreadPoolExecutor(1, "encode") as encoding_pool,
    ):
        reader = threading.Thread(target=read, name="read")
        reader.start()
        try:
            while (item := pending.get()) is not None:
                if isinstance(item, BaseException):
                    raise item
                frame, repeats, aim, detecting, moving, encoding = item
                packets = encoding.result() if encoding else frame.packets
                found = detecting.result()
                if found is None and not repeats and stages.tracker.wants_search:
                    found = detect(frame, aim)
                yield frame, repeats, found, moving.result(), packets
                room.release()
        finally:
            abandoned.set()
            room.release()  # the reader may be waiting for room
            reader.join()
            for pool in (detection_pool, ego_pool, encoding_pool):
                pool.shutdown(cancel_futures=True)
            if encoder:  # not before: closed while it encodes, libx264 aborts the process or never returns
                encoder.close()


def _encoder(source: Source, stages: Stages) -> VideoEncoder | None:
    """An encoder if the drive is written and its own video cannot be relayed."""
    if stages.sinks and not source.relays_video:
        return VideoEncoder(source.image_size, source.frame_rate_hz)
    return None


class _Ourselves:
    """Estimates own motion and path, frame by frame in order."""

    def __init__(self, stages: Stages) -> None:
        self._ego, self._given = stages.ego or EgoEstimator(), stages.ego_speed
        self._others: list[Box] = []
        self._first_ns: int | None = None

    def see(self, frame: Frame, detections: _Found) -> Ego:
        """Update with a frame. Vehicles are masked by their boxes in it, or in the last frame searched."""
        if detections is not None:
            self._others = [found.box for found in detections if not found.faint]
        given = self._given
        if self._first_ns is None:
            self._first_ns = frame.time_ns
        time_ns = frame.time_ns - (self._first_ns if given and given.from_first_frame else 0)
        speed_mps = given.at(time_ns) if given else None
        yaw_rate_radps = given.yaw_rate_at(time_ns) if given else None
        return self._ego.update(frame.time_ns, frame.image, self._others, speed_mps, yaw_rate_radps)
