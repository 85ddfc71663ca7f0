"""Detections against labels: hits, misses, false positives per image (FPPI).

A hit is a detection with IoU >= 0.5 with a vehicle, one detection a vehicle, the surest first. Ignored
vehicles are neither hit nor missed; a detection with half its area in an ignored box is neither hit nor
false.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.overlap import intersection_areas, intersection_over_union

HIT_IOU = 0.5
IGNORED_PART = 0.5
FALSE_POSITIVE = -1
NOT_COUNTED = -2


def match_detections(
    detections: NDArray[np.float64],
    scores: NDArray[np.float64],
    labels: NDArray[np.float64],
    ignored: NDArray[np.bool_],
) -> NDArray[np.int64]:
    """What each detection of one picture is.

    Detections are taken by falling score, so what one of them is does not depend on those below it: the
    matches at any higher threshold are these without the detections under it.

    Args:
        detections: (D, 4) boxes x, y, w, h.
        scores: (D,).
        labels: (L, 4) boxes.
        ignored: (L,) labels that count neither as hit nor as miss.

    Returns:
        (D,) the index of the label hit, or FALSE_POSITIVE, or NOT_COUNTED.
    """
    matches = np.full(len(detections), FALSE_POSITIVE, np.int64)
    overlap = intersection_over_union(detections, labels)
    overlap[:, ignored] = 0.0
    covered = intersection_areas(detections, labels[ignored]) / np.prod(detections[:, 2:], axis=1)[:, None]
    for detection in np.argsort(-scores, kind="stable"):
        best = int(np.argmax(overlap[detection])) if len(labels) else 0
        if len(labels) and overlap[detection, best] >= HIT_IOU:
            matches[detection] = best
            overlap[:, best] = 0.0
        elif np.any(covered[detection] >= IGNORED_PART):
            matches[detection] = NOT_COUNTED
    return matches


class OperatingPoint(NamedTuple):
    """What a detector does at one score threshold."""

    threshold: float
    detection_rate: float
    fppi: float


@dataclass(frozen=True, slots=True, eq=False)
class DetectionCurve:
    """Detection rate against false positives per image over all thresholds.

    Attributes:
        scores: (D,) of the detections that count, descending.
        hit: (D,) whether each is a hit; the others are false positives.
        vehicles: number of vehicles that count.
        frames: number of pictures.
    """

    scores: NDArray[np.float64]
    hit: NDArray[np.bool_]
    vehicles: int
    frames: int

    def at_threshold(self, threshold: float) -> OperatingPoint:
        """Rate and FPPI of the detections that score at least `threshold`; the rate of no vehicles is NaN."""
        hits = self.hit[self.scores >= threshold]
        rate = float(hits.sum() / self.vehicles) if self.vehicles else float("nan")
        return OperatingPoint(threshold, rate, float((~hits).sum() / self.frames))

    def at_fppi(self, fppi: float) -> OperatingPoint:
        """The lowest threshold with no more than `fppi` false positives per image.

        It is infinite where even the surest detections are false too often.
        """
        false_count = np.cumsum(~self.hit)
        # Equal scores stand or fall together: only the last of a run of equals is a place to cut.
        last = np.append(self.scores[1:] != self.scores[:-1], True) if len(self.scores) else np.zeros(0, bool)
        allowed = np.flatnonzero(last & (false_count <= fppi * self.frames))
        return self.at_threshold(float(self.scores[allowed[-1]]) if len(allowed) else float("inf"))


class LabelledDetections(NamedTuple):
    """Detections and labels of one picture, as `match_detections` takes them."""

    detections: NDArray[np.float64]
    scores: NDArray[np.float64]
    labels: NDArray[np.float64]
    ignored: NDArray[np.bool_]


def detection_curve(frames: Iterable[LabelledDetections]) -> DetectionCurve:
    """Match every picture and pool the detections.

    Raises:
        ValueError: there is no picture.
    """
    scores: list[NDArray[np.float64]] = [np.zeros(0)]
    hits: list[NDArray[np.bool_]] = [np.zeros(0, bool)]
    vehicles = count = 0
    for frame in frames:
        matches = match_detections(*frame)
        counted = matches != NOT_COUNTED
        scores.append(frame.scores[counted])
        hits.append(matches[counted] >= 0)
        vehicles += int((~frame.ignored).sum())
        count += 1
    if not count:
        raise ValueError("no picture to evaluate on")
    pooled, hit = np.concatenate(scores), np.concatenate(hits)
    order = np.argsort(-pooled, kind="stable")
    return DetectionCurve(pooled[order], hit[order], vehicles, count)
