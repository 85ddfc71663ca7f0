"""Real vehicles that come nearer: a labelled picture is enlarged as it would be seen from ever nearer.

Whoever drives straight at a rear that faces him sees it magnified by the ratio of the distances, about the
point of the horizon that he drives towards: its width grows so, and so does the depth of its lower edge below
the horizon, as on a flat road. So a labelled vehicle becomes a danger with exact truth, in the light and the
weather of its picture. Only the vehicle is right: what is beside it grows at the same rate, own motion cannot
be told from such pictures, and nobody gives the own speed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.detector import Detector
from fcw.detection.matching import HIT_IOU
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.warning.driver import EXPECTED_DRIVER
from fcw.warning.types import WarningLevel, WarningPolicy

PICTURES_PER_S = 15.0
STANDING_S = 0.8
"""How long the distance stays what it is in the picture."""
GROWTH_MPS2 = 4.0
"""How fast the closing speed grows after that, up to its final value."""
DUE_PART = 0.6
"""At its final closing speed a driver must be warned at this part of the first gap."""
END_GAP_M = 2.0
NOISE_LEVELS = 1.5
"""Standard deviation of the noise of the light that is new in each picture, in levels of 255."""


@dataclass(frozen=True, slots=True, eq=False)
class ApproachFrame:
    """One picture of an approach.

    Attributes:
        time_ns: from the first one on.
        image: (height, width, 3) BGR.
        box: the vehicle, cut to the picture.
        gap_m: its true distance, from the reference of the calibration.
        closing_mps: how fast that shrinks.
    """

    time_ns: int
    image: NDArray[np.uint8]
    box: Box
    gap_m: float
    closing_mps: float


@dataclass(frozen=True, slots=True)
class ApproachTrial:
    """What came of one approach.

    Attributes:
        found_part: of its pictures, in which a detection had the vehicle.
        tracked_part: of its pictures, in which a track did.
        due_s: when a driver of 1.2 s and 0.4 g had to be warned.
        warned_s: when `warning` was first shown of the vehicle; None where it never was.
        others: pictures with a `warning` of anything else.
    """

    found_part: float
    tracked_part: float
    due_s: float
    warned_s: float | None
    others: int

    @property
    def in_time(self) -> bool:
        """Whether the warning came before the driver needed it, or in the same picture."""
        return self.warned_s is not None and self.warned_s <= self.due_s


def approach(
    picture: NDArray[np.uint8], box: Box, calibration: Calibration, seed: int = 0
) -> Iterator[ApproachFrame]:
    """Drive at a vehicle of a picture until it is two metres ahead.

    Args:
        picture: (height, width, 3) BGR.
        box: the vehicle; its lower edge stands on the road, below the horizon.
        calibration: of the picture.
        seed: of the noise.
    """
    height, width = picture.shape[:2]
    horizon_px, middle_px = calibration.horizon_row_px, box.x + box.w / 2
    reference_m = calibration.reference_offset_m
    first_m = calibration.distance_at(box.y + box.h) + reference_m  # from the camera
    most_mps = closing_speed_mps(DUE_PART * (first_m - reference_m))
    chance = np.random.default_rng(seed)
    distance_m, closing_mps, index = first_m, 0.0, 0
    while distance_m - reference_m > END_GAP_M:
        scale = first_m / distance_m
        matrix = np.array([[scale, 0, middle_px * (1 - scale)], [0, scale, horizon_px * (1 - scale)]])
        seen = cv2.warpAffine(picture, matrix, (width, height), flags=cv2.INTER_LINEAR)
        noise = NOISE_LEVELS * chance.standard_normal((height, width, 1), np.float32)
        left, right = (max(min(middle_px + side * scale * box.w / 2, width - 0.5), -0.5) for side in (-1, 1))
        rows_px = (horizon_px + scale * (row_px - horizon_px) for row_px in (box.y, box.y + box.h))
        top, bottom = (max(min(row_px, height - 0.5), -0.5) for row_px in rows_px)
        yield ApproachFrame(
            round(index * 1e9 / PICTURES_PER_S),
            np.clip(seen + noise, 0, 255).astype(np.uint8),
            Box(left, top, right - left, bottom - top),
            distance_m - reference_m,
            closing_mps,
        )
        index += 1
        if index >= STANDING_S * PICTURES_PER_S:
            closing_mps = min(closing_mps + GROWTH_MPS2 / PICTURES_PER_S, most_mps)
        distance_m -= closing_mps / PICTURES_PER_S


def closing_speed_mps(needed_m: float) -> float:
    """With which the expected driver needs just this gap: `Driver.needed_distance_m` solved for the speed."""
    braking_mps2 = EXPECTED_DRIVER.braking_mps2
    lost_mps = EXPECTED_DRIVER.reaction_s * braking_mps2
    return math.sqrt(lost_mps**2 + 2 * braking_mps2 * needed_m) - lost_mps


def run_approach(
    frames: Iterator[ApproachFrame],
    calibration: Calibration,
    detector: Detector,
    policy: WarningPolicy,
) -> ApproachTrial:
    """Run detector, tracker and policy on an approach.

    Args:
        frames: of `approach`.
        calibration: of the pictures.
        detector: for pictures of that calibration.
        policy: a fresh one.
    """
    tracker = Tracker(calibration)
    found = tracked = others = count = 0
    due_s: float | None = None
    warned_s: float | None = None
    time_s = 0.0
    for frame in frames:
        time_s, count = frame.time_ns / 1e9, count + 1
        detections = detector.detect(frame.image)
        tracks = tracker.update(frame.time_ns, detections, image=frame.image)
        state = policy.update(frame.time_ns, threats_of(tracker, tracks), None)
        its_tracks = {track.track_id for track in tracks if _is_it(track.box, frame.box)}
        found += any(_is_it(detection.box, frame.box) for detection in detections if not detection.faint)
        tracked += bool(its_tracks)
        if due_s is None and 0 < frame.gap_m <= EXPECTED_DRIVER.needed_distance_m(frame.closing_mps):
            due_s = time_s
        if state.level >= WarningLevel.WARNING:
            if state.track_id not in its_tracks:
                others += 1
            elif warned_s is None:
                warned_s = time_s
    return ApproachTrial(found / count, tracked / count, time_s if due_s is None else due_s, warned_s, others)


def _is_it(box: Box, vehicle: Box) -> bool:
    pair = [np.array([[one.x, one.y, one.w, one.h]]) for one in (box, vehicle)]
    return bool(intersection_over_union(*pair)[0, 0] >= HIT_IOU)
