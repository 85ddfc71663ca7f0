"""Where a frame's time goes: the job with the default detector, one stage after the other in one thread."""

import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from fcw.camera.calibration import Calibration
from fcw.detection.choice import NET
from fcw.detection.net.detector import NetDetector, NetSettings
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel
from fcw.detection.net.proposals import Proposer
from fcw.detection.net.windows import Pyramid
from fcw.job import DriveJob, prepare_drive
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import MCAP_NAME
from fcw.motion.ego import EgoEstimator
from fcw.pipeline import Stages, follow
from fcw.threads import one_opencv_thread
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track

DECODING = "decoding, to BGR"
PROPOSING = "detection: the cascade proposes"
HALVING = "detection: halves for the windows"
FIRST_LOOK = "detection: first look"
SECOND_LOOK = "detection: second look"
DETECTION_REST = "detection: the rest"
OWN_MOTION = "own motion and lane"
TRACKING = "tracking by boxes"
CARRYING = "carrying by the picture"
WARNING = "threat and warning"
LOGGING = "log"
STAGES = (
    DECODING,
    PROPOSING,
    HALVING,
    FIRST_LOOK,
    SECOND_LOOK,
    DETECTION_REST,
    OWN_MOTION,
    TRACKING,
    CARRYING,
    WARNING,
    LOGGING,
)
_DETECTION, _FOLLOWING, _WITH_PICTURE = "detection", "following", "tracking with pictures"


class _Clock:
    """The calling thread's own time by stage, seconds."""

    def __init__(self) -> None:
        self.spent_s: defaultdict[str, float] = defaultdict(float)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start_s = time.thread_time()
        yield
        self.spent_s[name] += time.thread_time() - start_s


class _TimedTracker(Tracker):
    """A tracker whose updates are timed, beside one that takes the same boxes and sees no pictures."""

    def __init__(self, calibration: Calibration, clock: _Clock) -> None:
        super().__init__(calibration)
        self._by_boxes, self._clock = Tracker(calibration), clock

    def update(self, *arguments: Any, **named: Any) -> tuple[Track, ...]:  # noqa: ANN401 - as the tracker's
        """See `Tracker.update`."""
        with self._clock.stage(TRACKING):
            self._by_boxes.update(*arguments, **named | {"image": None})
        with self._clock.stage(_WITH_PICTURE):
            return super().update(*arguments, **named)


def stage_times(job: DriveJob, duration_s: float) -> dict[str, float]:
    """Milliseconds a frame of each stage: this thread's own time, the mean over the drive's first seconds.

    The detector's parts are run by themselves beside it; the rest is what it takes beyond them.

    Args:
        job: on the drive; nothing is written to its folder.
        duration_s: of the drive.

    Raises:
        UserError: the source or its calibration cannot be used.
    """
    drive = prepare_drive(replace(job, detector=NET, detection_threads=1))
    calibration, model, settings = drive.header.calibration, NetModel.load(SHIPPED_NET_PATH), NetSettings()
    detector = NetDetector(model, calibration, settings)
    proposer = Proposer(model.cascade, calibration, settings.proposals)
    clock, ego = _Clock(), EgoEstimator(calibration)
    stages = Stages((detector,), _TimedTracker(calibration, clock), drive.policy)
    count = max(round(duration_s * drive.source.frame_rate_hz), 1)
    done = 0
    with one_opencv_thread(), tempfile.TemporaryDirectory() as folder:
        sink = McapSink(Path(folder) / MCAP_NAME)
        sink.open(drive.header)
        try:
            frames = iter(drive.source.frames())
            while done < count:
                with clock.stage(DECODING):
                    frame = next(frames, None)
                if frame is None:
                    break
                with clock.stage(_DETECTION):
                    detections = detector.detect(frame.image)
                with clock.stage(PROPOSING):
                    proposed, _ = proposer.propose(frame.image)
                with clock.stage(HALVING):
                    pyramid = Pyramid(frame.image)
                with clock.stage(FIRST_LOOK):
                    placements = detector.first_look(pyramid, proposed)
                with clock.stage(SECOND_LOOK):
                    detector.second_look(pyramid, placements)
                with clock.stage(OWN_MOTION):
                    moving = ego.update(frame.time_ns, frame.image, [found.box for found in detections])
                with clock.stage(_FOLLOWING):
                    result = follow(frame, detections, moving, stages)
                with clock.stage(LOGGING):
                    sink.write(result, frame.packets)
                done += 1
        finally:
            sink.close()
    spent_s = clock.spent_s
    parts_s = sum(spent_s[part] for part in (PROPOSING, HALVING, FIRST_LOOK, SECOND_LOOK))
    spent_s[DETECTION_REST] = spent_s[_DETECTION] - parts_s
    spent_s[CARRYING] = spent_s[_WITH_PICTURE] - spent_s[TRACKING]
    spent_s[WARNING] = spent_s[_FOLLOWING] - spent_s[_WITH_PICTURE] - spent_s[TRACKING]
    return {stage: max(1e3 * spent_s[stage], 0.0) / max(done, 1) for stage in STAGES}
