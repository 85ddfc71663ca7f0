"""The misses and false positives of an evaluation by kind, which show what to improve."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import intersection_areas, vehicle_overlap
from fcw.detection.matching import FALSE_POSITIVE, HIT_IOU
from fcw.detection.training.dataset import background
from fcw.evaluation.detection.figures import DetectionEvaluation

MISPLACED_IOU = 0.3
"""A detection that is not a hit but overlaps a vehicle by at least this much is a misplaced box of it."""


class FailureKind(StrEnum):
    """What went wrong; the value is the text in reports."""

    NOT_FOUND = "missed: not found"
    UNSURE = "missed: found, under the threshold"
    MISPLACED_MISS = "missed: box misplaced"
    SHARED = "missed: its box counts for a neighbour"
    DOUBLE = "false: second box on a found vehicle"
    MISPLACED = "false: box misplaced on a vehicle that counts"
    IGNORED_VEHICLE = "false: box misplaced on an ignored vehicle"
    BACKGROUND = "false: background"


@dataclass(frozen=True, slots=True, eq=False)
class Failure:
    """A miss or a false positive.

    Attributes:
        kind: the kind of failure.
        frame: index of the picture.
        box: (4,) x, y, w, h of the missed vehicle or of the false detection.
        score: score of the false detection, or of the best box on the missed vehicle; None if there is none.
        iou: largest IoU of the false detection with a vehicle or its rear face, or of the missed vehicle with
            a detection.
        distance_m: distance at the bottom row of the box.
        label: index of the missed vehicle among the labels of the picture; None for false positives.
        vehicle: identity of the missed vehicle; None for false positives.
    """

    kind: FailureKind
    frame: int
    box: NDArray[np.float64]
    score: float | None
    iou: float
    distance_m: float
    label: int | None = None
    vehicle: int | None = None


def misses(evaluation: DetectionEvaluation) -> tuple[Failure, ...]:
    """The vehicles that are not found at the threshold of the evaluation, nearest first."""
    missed = np.flatnonzero(~evaluation.hit)
    failures = [_miss(evaluation, int(index)) for index in missed]
    return tuple(sorted(failures, key=lambda failure: failure.distance_m))


def false_positives(evaluation: DetectionEvaluation) -> tuple[Failure, ...]:
    """The false positives at the threshold of the evaluation, highest score first."""
    matches = evaluation.matches
    sure = (matches.vehicle == FALSE_POSITIVE) & (matches.scores >= evaluation.threshold)
    return tuple(_false_positive(evaluation, int(index)) for index in np.flatnonzero(sure))


def count_kinds(failures: Sequence[Failure]) -> dict[FailureKind, int]:
    """Number of failures of each kind, in the order of the kinds."""
    counts = Counter(failure.kind for failure in failures)
    return {kind: counts[kind] for kind in FailureKind if counts[kind]}


def _miss(evaluation: DetectionEvaluation, index: int) -> Failure:
    matches = evaluation.matches
    frame, label = int(matches.vehicle_frame[index]), int(matches.vehicle_label[index])
    labelled, found = evaluation.images[frame].labelled, evaluation.found[frame]
    box, rear_box = labelled.boxes[label], labelled.rear_boxes[label]
    overlap = vehicle_overlap(found.boxes, box[None], rear_box[None])[:, 0]
    sure = found.scores >= evaluation.threshold
    placed = overlap >= HIT_IOU
    if (placed & sure).any():
        kind, chosen = FailureKind.SHARED, placed & sure
    elif placed.any():
        kind, chosen = FailureKind.UNSURE, placed
    elif ((overlap >= MISPLACED_IOU) & sure).any():
        kind, chosen = FailureKind.MISPLACED_MISS, (overlap >= MISPLACED_IOU) & sure
    else:
        kind, chosen = FailureKind.NOT_FOUND, overlap > 0
    best = int(np.argmax(np.where(chosen, overlap, -1.0))) if chosen.any() else None
    return Failure(
        kind,
        frame,
        box,
        None if best is None else float(found.scores[best]),
        0.0 if best is None else float(overlap[best]),
        float(evaluation.distances_m[index]),
        label,
        int(evaluation.grouping.vehicle[index]),
    )


def _false_positive(evaluation: DetectionEvaluation, index: int) -> Failure:
    matches = evaluation.matches
    frame, box = int(matches.frame[index]), matches.boxes[index]
    labelled = evaluation.images[frame].labelled
    overlap = vehicle_overlap(box[None], labelled.boxes, labelled.rear_boxes)[0]
    counted = np.where(labelled.ignored, 0.0, overlap)
    best_counted = float(counted.max(initial=0.0))
    covered = intersection_areas(box[None], labelled.boxes[labelled.ignored])[0] / float(box[2] * box[3])
    if best_counted >= HIT_IOU:
        kind = FailureKind.DOUBLE
    elif background(box[None], labelled.boxes, labelled.ignored, labelled.rear_boxes)[0]:
        kind = FailureKind.BACKGROUND
    elif best_counted >= float(covered.max(initial=0.0)):
        kind = FailureKind.MISPLACED
    else:
        kind = FailureKind.IGNORED_VEHICLE
    return Failure(
        kind,
        frame,
        box,
        float(matches.scores[index]),
        float(overlap.max(initial=0.0)),
        float(evaluation.false_distances_m[index]),
    )
