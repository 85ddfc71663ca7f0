"""Detections against labels: hits, misses, false positives per image (FPPI), average precision.

A hit is a detection with IoU >= 0.5 with a whole vehicle or with its rear face, one detection a vehicle, the
surest first. Ignored vehicles are neither hit nor missed; a detection with half its area in an ignored box is
neither hit nor false.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap

HIT_IOU = 0.5
IGNORED_PART = 0.5
FALSE_POSITIVE = -1
NOT_COUNTED = -2
RECALLS = np.linspace(0.0, 1.0, 101)
"""At which average precision looks at the curve, as COCO does."""


def match_detections(
    detections: NDArray[np.float64],
    scores: NDArray[np.float64],
    labels: NDArray[np.float64],
    ignored: NDArray[np.bool_],
    rear_boxes: NDArray[np.float64] | None = None,
) -> NDArray[np.int64]:
    """What each detection of one picture is.

    Detections are taken by falling score, so what one of them is does not depend on those below it: the
    matches at any higher threshold are these without the detections under it.

    Args:
        detections: (D, 4) boxes x, y, w, h.
        scores: (D,).
        labels: (L, 4) boxes.
        ignored: (L,) labels that count neither as hit nor as miss.
        rear_boxes: (L, 4) boxes of the vehicles' rear faces, NaN where there is none; None: there are none.

    Returns:
        (D,) the index of the label hit, or FALSE_POSITIVE, or NOT_COUNTED.
    """
    matches = np.full(len(detections), FALSE_POSITIVE, np.int64)
    overlap = vehicle_overlap(detections, labels, rear_boxes)
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
        frames: number of pictures whose false positives count.
        weights: (D,) how often each detection counts, where vehicles and pictures are resampled, and
            `vehicles` and `frames` are sums of weights too; None: once.
    """

    scores: NDArray[np.float64]
    hit: NDArray[np.bool_]
    vehicles: float
    frames: float
    weights: NDArray[np.float64] | None = None

    def at_threshold(self, threshold: float) -> OperatingPoint:
        """Rate and FPPI of the detections that score at least `threshold`; the rate of no vehicles is NaN."""
        kept = self.scores >= threshold
        return self._point(
            threshold, float(self._hits[kept].sum()), float((self._weights - self._hits)[kept].sum())
        )

    def at_fppi(self, fppi: float) -> OperatingPoint:
        """The lowest threshold with no more than `fppi` false positives per image.

        It is infinite where even the surest detections are false too often.
        """
        _, false = self._counts
        # Divided, 29 of 100 pictures are 0.29 to the bit, where 0.29 times 100 is a little less than 29.
        allowed = np.flatnonzero(self._cuts & (false / (self.frames or 1.0) <= fppi))
        return self.at_threshold(float(self.scores[allowed[-1]]) if len(allowed) else float("inf"))

    def at_rate(self, rate: float) -> OperatingPoint | None:
        """The highest threshold with a detection rate of at least `rate`; None where none has it."""
        hits, _ = self._counts
        enough = np.flatnonzero(self._cuts & (hits >= rate * self.vehicles - 1e-9))
        return self.at_threshold(float(self.scores[enough[0]])) if len(enough) else None

    def points(self) -> tuple[OperatingPoint, ...]:
        """All that a threshold can give, by falling threshold: FPPI and rate never fall."""
        hits, false = self._counts
        return tuple(
            self._point(float(self.scores[cut]), float(hits[cut]), float(false[cut]))
            for cut in np.flatnonzero(self._cuts)
        )

    @property
    def average_precision(self) -> float:
        """Mean over 101 recalls of the best precision at that recall or above, as COCO's AP at one IoU.

        Unlike there the order of equal scores does not matter. NaN where there is no vehicle.
        """
        if not self.vehicles:
            return float("nan")
        hits, false = (counts[self._cuts] for counts in self._counts)
        precision = hits / np.maximum(hits + false, np.finfo(float).tiny)
        best = np.append(np.maximum.accumulate(precision[::-1])[::-1], 0.0)
        return float(best[np.searchsorted(hits / self.vehicles, RECALLS, side="left")].mean())

    @property
    def _weights(self) -> NDArray[np.float64]:
        return np.ones(len(self.scores)) if self.weights is None else self.weights

    @property
    def _hits(self) -> NDArray[np.float64]:
        return np.where(self.hit, self._weights, 0.0)

    @property
    def _counts(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Hits and false positives among the first detections."""
        return np.cumsum(self._hits), np.cumsum(self._weights - self._hits)

    @property
    def _cuts(self) -> NDArray[np.bool_]:
        """Equal scores stand or fall together: only the last of a run of equals is a place to cut."""
        if not len(self.scores):
            return np.zeros(0, bool)
        return np.append(self.scores[1:] != self.scores[:-1], True)

    def _point(self, threshold: float, hits: float, false: float) -> OperatingPoint:
        rate = hits / self.vehicles if self.vehicles else float("nan")
        return OperatingPoint(threshold, rate, false / self.frames if self.frames else float("nan"))


class LabelledDetections(NamedTuple):
    """Detections and labels of one picture.

    Attributes:
        detections: (D, 4) boxes x, y, w, h.
        scores: (D,).
        labels: (L, 4) boxes.
        ignored: (L,) labels that count neither as hit nor as miss.
        rear_boxes: (L, 4) of the rear faces, NaN where there is none; None: there are none.
        complete: whether all vehicles are labelled; else no detection is a false positive.
    """

    detections: NDArray[np.float64]
    scores: NDArray[np.float64]
    labels: NDArray[np.float64]
    ignored: NDArray[np.bool_]
    rear_boxes: NDArray[np.float64] | None = None
    complete: bool = True

    def matches(self) -> NDArray[np.int64]:
        """What each detection is, as `match_detections` says; none is false where labels are incomplete."""
        matches = match_detections(self.detections, self.scores, self.labels, self.ignored, self.rear_boxes)
        return matches if self.complete else np.where(matches == FALSE_POSITIVE, NOT_COUNTED, matches)


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """The detections of many pictures that count, pooled, and the vehicles.

    Attributes:
        scores: (D,) descending.
        boxes: (D, 4) x, y, w, h.
        frame: (D,) index of the picture each is in.
        vehicle: (D,) index of the vehicle hit, or FALSE_POSITIVE.
        vehicle_frame: (V,) index of the picture of each vehicle that counts.
        vehicle_label: (V,) its index among that picture's labels.
        complete: (F,) whether all vehicles of each picture are labelled: in the others none is false, and
            they do not count where false positives are counted by picture.
    """

    scores: NDArray[np.float64]
    boxes: NDArray[np.float64]
    frame: NDArray[np.int64]
    vehicle: NDArray[np.int64]
    vehicle_frame: NDArray[np.int64]
    vehicle_label: NDArray[np.int64]
    complete: NDArray[np.bool_]

    @property
    def frames(self) -> int:
        """Number of pictures in which false positives are counted."""
        return int(self.complete.sum())

    def curve(
        self,
        vehicle_weights: NDArray[np.float64] | None = None,
        frame_weights: NDArray[np.float64] | None = None,
    ) -> DetectionCurve:
        """The curve, of all once or weighted.

        Args:
            vehicle_weights: (V,) how often each vehicle counts, with its hit.
            frame_weights: (F,) how often each picture counts, with its false positives.
        """
        vehicles = np.ones(len(self.vehicle_frame)) if vehicle_weights is None else vehicle_weights
        frames = np.ones(len(self.complete)) if frame_weights is None else frame_weights
        hit = self.vehicle >= 0
        weights = frames[self.frame]
        weights[hit] = vehicles[self.vehicle[hit]]
        pictures = float(frames[self.complete].sum())
        return DetectionCurve(self.scores, hit, float(vehicles.sum()), pictures, weights)


def pool_matches(frames: Iterable[LabelledDetections]) -> Matches:
    """Match every picture and pool the detections.

    Raises:
        ValueError: there is no picture.
    """
    scores: list[NDArray[np.float64]] = [np.zeros(0)]
    boxes: list[NDArray[np.float64]] = [np.zeros((0, 4))]
    frame_of: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    vehicle: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    vehicle_frame: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    vehicle_label: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    complete: list[bool] = []
    vehicles = 0
    for count, frame in enumerate(frames):
        matches = frame.matches()
        counted = matches != NOT_COUNTED
        vehicle_number = vehicles + np.cumsum(~frame.ignored) - 1
        scores.append(frame.scores[counted])
        boxes.append(frame.detections[counted])
        frame_of.append(np.full(int(counted.sum()), count, np.int64))
        numbers = np.append(vehicle_number, FALSE_POSITIVE)  # the last stands for index -1
        vehicle.append(numbers[matches[counted]].astype(np.int64))
        vehicle_label.append(np.flatnonzero(~frame.ignored))
        vehicle_frame.append(np.full(len(vehicle_label[-1]), count, np.int64))
        vehicles += len(vehicle_label[-1])
        complete.append(frame.complete)
    if not complete:
        raise ValueError("no picture to evaluate on")
    pooled = np.concatenate(scores)
    order = np.argsort(-pooled, kind="stable")
    return Matches(
        pooled[order],
        np.concatenate(boxes)[order],
        np.concatenate(frame_of)[order],
        np.concatenate(vehicle)[order],
        np.concatenate(vehicle_frame),
        np.concatenate(vehicle_label),
        np.array(complete, bool),
    )


def detection_curve(frames: Iterable[LabelledDetections]) -> DetectionCurve:
    """The curve over all pictures.

    Raises:
        ValueError: there is no picture.
    """
    return pool_matches(frames).curve()
