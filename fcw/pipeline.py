"""The loop: source -> detect -> track -> warn -> sinks, with decoding, detection and writing overlapped.

One thread decodes, one for each detector finds vehicles, one encodes where the source's video can't be
relayed, and the caller's thread tracks, warns and writes, in the order of the frames.
"""

import queue
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass

from fcw.detection.detector import Detection, Detector
from fcw.frame import Frame, Source, VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.records import DriveHeader, FrameResult, Sink, in_single_precision
from fcw.threads import one_opencv_thread
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.types import WarningPolicy

FRAMES_IN_FLIGHT = 8
"""Enough that no stage waits for another's odd slow frame; at 1280x720 it holds 22 MB of pictures."""


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """What the loop is made of.

    Attributes:
        detectors: alike, one for each detection thread.
        tracker: follows the vehicles.
        policy: decides the warning.
        ego_speed: own speed over time, and the yaw rate where it is known; None when unknown.
        sinks: where the drive is written.
        frames_in_flight: read at most so many ahead of what is written; a live drive wants few, as each
            waits for those before it.
    """

    detectors: Sequence[Detector]
    tracker: Tracker
    policy: WarningPolicy
    ego_speed: EgoSpeed | None = None
    sinks: Sequence[Sink] = ()
    frames_in_flight: int = FRAMES_IN_FLIGHT


def run_pipeline(
    source: Source,
    stages: Stages,
    header: DriveHeader,
    stop: threading.Event | None = None,
    on_result: Callable[[FrameResult], None] = lambda result: None,
) -> None:
    """Run the whole job on a drive and close every sink, whatever happens.

    Args:
        source: the drive.
        stages: detectors, tracker, policy and sinks.
        header: what the sinks write first.
        stop: once set, the frames under way are finished, and the logs closed.
        on_result: called after each frame was written.
    """
    with ExitStack() as stack:
        stack.enter_context(one_opencv_thread())
        for sink in stages.sinks:
            sink.open(header)
            stack.callback(sink.close)
        for frame, detections, packets in _detected_frames(source, stages, stop or threading.Event()):
            result = _follow(frame, detections, stages)
            for sink in stages.sinks:
                sink.write(result, packets)
            on_result(result)


def _follow(frame: Frame, detections: tuple[Detection, ...], stages: Stages) -> FrameResult:
    ego_speed_mps = stages.ego_speed.at(frame.time_ns) if stages.ego_speed else None
    yaw_rate_radps = stages.ego_speed.yaw_rate_at(frame.time_ns) if stages.ego_speed else None
    tracks = stages.tracker.update(frame.time_ns, detections, ego_speed_mps, yaw_rate_radps, frame.image)
    tracks = tuple(map(in_single_precision, tracks))
    lead_id = stages.tracker.lead_id
    threats = threats_of(stages.tracker, tracks, ego_speed_mps, yaw_rate_radps)
    return FrameResult(
        index=frame.index,
        time_ns=frame.time_ns,
        detections=tuple(map(in_single_precision, detections)),
        tracks=tracks,
        lead_id=lead_id,
        warning=stages.policy.update(frame.time_ns, threats, ego_speed_mps),
        ego_speed_mps=ego_speed_mps,
        notes=(stages.tracker.mount.note,) if stages.tracker.mount.note else (),
    )


_Pending = tuple[Frame, Future[tuple[Detection, ...]], Future[tuple[VideoPacket, ...]] | None]


def _detected_frames(
    source: Source, stages: Stages, stop: threading.Event
) -> Iterator[tuple[Frame, tuple[Detection, ...], tuple[VideoPacket, ...]]]:
    """Frames in order with their detections and packets; what failed in a thread is raised here."""
    idle_detectors: queue.SimpleQueue[Detector] = queue.SimpleQueue()
    for detector in stages.detectors:
        idle_detectors.put(detector)

    def detect(frame: Frame) -> tuple[Detection, ...]:
        detector = idle_detectors.get()
        try:
            return detector.detect(frame.image)
        finally:
            idle_detectors.put(detector)

    abandoned = threading.Event()
    pending: queue.SimpleQueue[_Pending | BaseException | None] = queue.SimpleQueue()
    room = threading.Semaphore(stages.frames_in_flight)
    encoder = (
        VideoEncoder(source.image_size, source.frame_rate_hz)
        if stages.sinks and not source.relays_video
        else None
    )

    def read() -> None:
        try:
            frames = iter(source.frames())
            # Room first: the frame is as new as can be when its detection begins.
            while room.acquire() and not abandoned.is_set() and (frame := next(frames, None)) is not None:
                encoding = encoding_pool.submit(encoder.encode, frame) if encoder else None
                pending.put((frame, detection_pool.submit(detect, frame), encoding))
                if stop.is_set():
                    break
            pending.put(None)
        except BaseException as error:
            pending.put(error)

    with (
        ThreadPoolExecutor(len(stages.detectors), "detect") as detection_pool,
        ThreadPoolExecutor(1, "encode") as encoding_pool,
    ):
        reader = threading.Thread(target=read, name="read")
        reader.start()
        try:
            while (item := pending.get()) is not None:
                if isinstance(item, BaseException):
                    raise item
                frame, detecting, encoding = item
                yield frame, detecting.result(), encoding.result() if encoding else frame.packets
                room.release()
        finally:
            abandoned.set()
            room.release()  # the reader may be waiting for it
            reader.join()
            if encoder:
                encoder.close()
