"""What comes of false boxes: how often one that is found for a moment grows into a warning.

    python benchmarks/tracking/false_boxes.py DRIVE ... [--seeds 1] [--longest 0.4]

DRIVE is a folder of `fcw run`, or a folder of such folders. Its pictures, detections and own motion are
tracked again, and every three to four seconds a box as large as a car 5 to 30 m ahead in the own lane is put
among the detections, where no vehicle was found, for 0.1 s to `--longest` (three frames at least); half of
them stand still in the picture, half come nearer as the road does. No warning may come of any.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fcw.box import Box, iou
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.logs.export.clip import find_drives
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.pictures import LogPictures
from fcw.logs.records import FrameResult
from fcw.motion.ego import Ego
from fcw.motion.path import assumed_path
from fcw.motion.state import OwnMotion
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

FIRST_S = 1.5
NOISE_PART = 0.03
"""1-sigma of a box's edges, as a part of its height."""
USUAL_MPS = 10.0
"""Where the own speed is unknown."""
FREE_IOU, SAME_IOU = 0.05, 0.4


@dataclass(slots=True)
class FalseBox:
    """One, and what came of it."""

    frames: range
    distance_m: float
    lateral_m: float
    comes_nearer: bool
    found_part: float
    put_in: bool = False
    last_s: float = 0.0
    box: Box | None = None
    track_id: int | None = None
    level: WarningLevel = WarningLevel.NONE

    def now(self, calibration: Calibration, own_mps: float, passed_s: float) -> Box:
        """Where it is so long after it appeared."""
        nearer_m = own_mps * passed_s if self.comes_nearer else 0.0
        return calibration.ground_box(max(self.distance_m - nearer_m, 3.0), self.lateral_m, 1.8, 1.5)


def planned(times_s: Sequence[float], longest_s: float, rng: np.random.Generator) -> Iterator[FalseBox]:
    """The false boxes of a drive."""
    step_s = (times_s[-1] - times_s[0]) / (len(times_s) - 1)
    first_s = FIRST_S
    while first_s + FIRST_S < times_s[-1]:
        first = int(np.searchsorted(times_s, first_s))
        count = max(3, round(rng.uniform(0.1, longest_s) / step_s))
        place = rng.uniform(5.0, 30.0), rng.uniform(-1.0, 1.0)
        yield FalseBox(range(first, first + count), *place, rng.random() < 0.5, rng.choice((0.6, 1.0)))
        first_s += rng.uniform(3.0, 4.0)


def put_in(
    boxes: Sequence[FalseBox],
    frame: int,
    result: FrameResult,
    calibration: Calibration,
    times_s: Sequence[float],
    rng: np.random.Generator,
) -> tuple[Detection, ...]:
    """A frame's detections, and the false ones."""
    found = list(result.detections)
    for one in boxes:
        if frame not in one.frames:
            continue
        own_mps = USUAL_MPS if result.ego_speed_mps is None else result.ego_speed_mps
        box = one.now(calibration, own_mps, times_s[frame] - times_s[one.frames.start])
        if frame == one.frames.start:
            one.put_in = all(iou(box, other.box) < FREE_IOU for other in result.detections)
        if one.put_in and rng.random() < one.found_part:
            left, top, right, bottom = NOISE_PART * box.h * rng.standard_normal(4)
            one.box = Box(box.x + left, box.y + top, box.w + right - left, box.h + bottom - top)
            one.last_s = times_s[frame]
            found.append(Detection(one.box, 4.0))
    return tuple(found)


def run(log: DriveLog, longest_s: float, seed: int) -> list[FalseBox]:
    """Track a drive again with false boxes; those that were put in."""
    calibration, pictures, rng = log.header.calibration, LogPictures(log), np.random.default_rng(seed)
    results = list(log.results())
    times_s = [(result.time_ns - results[0].time_ns) / 1e9 for result in results]
    boxes = list(planned(times_s, longest_s, rng))
    tracker, policy = Tracker(calibration), make_policy()
    for frame, result in enumerate(results):
        ego = Ego(
            result.own_motion or OwnMotion(speed_mps=result.ego_speed_mps),
            result.own_path or assumed_path(None),
        )
        found = put_in(boxes, frame, result, calibration, times_s, rng)
        tracks = tracker.update(result.time_ns, found, ego, pictures.at(result.index))
        state = policy.update(result.time_ns, threats_of(tracker, tracks, ego), ego.motion.speed_mps)
        for one in boxes:
            for track in tracks:
                is_new = one.track_id is None and track.age_s < 1.0 and times_s[frame] < one.last_s + 0.2
                if is_new and one.box is not None and iou(track.box, one.box) > SAME_IOU:
                    one.track_id = track.track_id
            if one.track_id is not None and state.track_id == one.track_id:
                one.level = max(one.level, state.level)
    return [one for one in boxes if one.put_in]


def main() -> None:
    """Print a line for each drive, and the sum."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("drives", type=Path, nargs="+")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--longest", type=float, default=0.4, help="seconds that a box is found at most")
    options = parser.parse_args()
    everywhere: list[FalseBox] = []
    for name, path in find_drives(options.drives).items():
        log = DriveLog(path)
        boxes = [one for seed in range(options.seeds) for one in run(log, options.longest, seed)]
        everywhere += boxes
        sys.stdout.write(f"{name}: {told(boxes)}\n")
    sys.stdout.write(f"all: {told(everywhere)}\n")


def told(boxes: Sequence[FalseBox]) -> str:
    """What came of them, in words."""
    followed = sum(one.track_id is not None for one in boxes)
    caution, warning = (
        sum(one.level >= level for one in boxes) for level in (WarningLevel.CAUTION, WarningLevel.WARNING)
    )
    return f"{len(boxes)} false boxes, {followed} followed, {caution} caution or more, {warning} warning"


if __name__ == "__main__":
    main()
