"""Where a frame's time goes: the job with the default detector, one stage after the other in one thread."""

import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.detection.choice import NET
from fcw.detection.detector import Detection
from fcw.detection.net.detector import NetDetector
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.job import DriveJob, prepare_drive
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import MCAP_NAME, RRD_NAME
from fcw.logs.records import Sink
from fcw.motion.ego import NOTHING_KNOWN, Ego, EgoEstimator
from fcw.pipeline import Stages, follow
from fcw.threads import one_opencv_thread
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track
from fcw_viz.rerun.log import RerunSink

DECODING = "decoding, to BGR"
HALVING = "detection: halves of the picture"
GLANCE = "detection: glance"
LOOK = "detection: look"
DETECTION_REST = "detection: the rest"
OWN_MOTION = "own motion and lane"
TRACKING = "tracking by boxes"
CARRYING = "carrying by the picture"
WARNING = "threat and warning"
ENCODING = "encoding anew, on all cores"
LOGGING = "log"
RERUN_LOGGING = "log for rerun"
STAGES = (
    DECODING,
    HALVING,
    GLANCE,
    LOOK,
    DETECTION_REST,
    OWN_MOTION,
    TRACKING,
    CARRYING,
    WARNING,
    ENCODING,
    LOGGING,
    RERUN_LOGGING,
)
"""In the order of the work. Only video that cannot be relayed is encoded anew."""
_FOLLOWING, _WITH_PICTURE = "following", "tracking with pictures"


class _Clock:
    """Processor time by stage, seconds."""

    def __init__(self) -> None:
        self.spent_s: defaultdict[str, float] = defaultdict(float)

    @contextmanager
    def stage(self, name: str, now_s: Callable[[], float] = time.thread_time) -> Iterator[None]:
        """What is done within; the calling thread's own time unless another clock is given."""
        start_s = now_s()
        yield
        self.spent_s[name] += now_s() - start_s


class _TimedTracker(Tracker):
    """A tracker whose updates are timed, beside one that takes the same boxes and sees no pictures."""

    def __init__(self, calibration: Calibration, clock: _Clock) -> None:
        super().__init__(calibration)
        self._by_boxes, self._clock = Tracker(calibration), clock

    def update(
        self,
        time_ns: int,
        detections: Sequence[Detection] | None,
        ego: Ego = NOTHING_KNOWN,
        image: NDArray[np.uint8] | None = None,
    ) -> tuple[Track, ...]:
        """See `Tracker.update`."""
        with self._clock.stage(TRACKING):
            self._by_boxes.update(time_ns, detections, ego)
        with self._clock.stage(_WITH_PICTURE):
            return super().update(time_ns, detections, ego, image)


def stage_times(job: DriveJob, duration_s: float) -> dict[str, float]:
    """Milliseconds a frame of each stage: this thread's own time, the mean over the drive's first seconds.

    Of the encoder, which has threads of its own, it is the time of all of them.

    Args:
        job: on the drive; nothing is written to its folder.
        duration_s: of the drive.

    Raises:
        UserError: the source or its calibration cannot be used.
    """
    drive = prepare_drive(replace(job, detector=NET, detection_threads=1))
    calibration, source = drive.header.calibration, drive.source
    detector = NetDetector(NetModel.load(SHIPPED_NET_PATH), calibration)
    clock, ego = _Clock(), EgoEstimator(calibration)
    stages = Stages((detector,), _TimedTracker(calibration, clock), drive.policy)
    encoder = None if source.relays_video else VideoEncoder(source.image_size, source.frame_rate_hz)
    count = max(round(duration_s * source.frame_rate_hz), 1)
    done = 0
    with ExitStack() as stack:
        stack.enter_context(one_opencv_thread())
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        sinks: dict[str, Sink] = {
            LOGGING: McapSink(folder / MCAP_NAME),
            RERUN_LOGGING: RerunSink(folder / RRD_NAME),
        }
        for name, sink in sinks.items():
            sink.open(drive.header)
            stack.callback(clock.stage(name)(sink.close))  # the rerun log writes many frames at once
        if encoder is not None:
            stack.callback(encoder.close)
        frames = iter(source.frames())
        while done < count:
            with clock.stage(DECODING):
                frame = next(frames, None)
            if frame is None:
                break
            with clock.stage(HALVING):
                pyramid = detector.pyramid(frame.image)
            with clock.stage(GLANCE):
                seen = detector.glance(pyramid)
            with clock.stage(LOOK):
                boxes, logits = detector.look(pyramid, seen)
            with clock.stage(DETECTION_REST):
                detections = detector.decide(*detector.with_glance(seen, boxes, logits))
            with clock.stage(OWN_MOTION):
                moving = ego.update(frame.time_ns, frame.image, [found.box for found in detections])
            with clock.stage(_FOLLOWING):
                result = follow(frame, detections, moving, stages)
            packets = frame.packets
            if encoder is not None:
                with clock.stage(ENCODING, time.process_time):
                    packets = encoder.encode(frame)
            for name, sink in sinks.items():
                with clock.stage(name):
                    sink.write(result, packets)
            done += 1
    spent_s = clock.spent_s
    spent_s[CARRYING] = spent_s[_WITH_PICTURE] - spent_s[TRACKING]
    spent_s[WARNING] = spent_s[_FOLLOWING] - spent_s[_WITH_PICTURE] - spent_s[TRACKING]
    return {stage: max(1e3 * spent_s[stage], 0.0) / max(done, 1) for stage in STAGES if stage in spent_s}
