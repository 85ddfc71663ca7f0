"""The misses and false positives of an evaluation, each with its kind: where improvements come from."""

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
"""A detection that overlaps a vehicle so much, and no hit, shows it in a wrong box."""


class FailureKind(StrEnum):
    """What went wrong, as a person reads it."""

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
        kind: which.
        frame: index of the picture.
        box: (4,) x, y, w, h: the vehicle missed, or the false detection.
        score: of the false detection, or of the best box on the missed vehicle; None: there is none.
        iou: the detection's with the vehicle it overlaps most, or with its rear face; or the reverse.
        distance_m: of the box's bottom row.
        label: index of the missed vehicle among the picture's labels; None for false positives.
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
    """The vehicles not found at the evaluation's threshold, nearest first."""
    missed = np.flatnonzero(~evaluation.hit)
    failures = [_miss(evaluation, int(index)) for index in missed]
    return tuple(sorted(failures, key=lambda failure: failure.distance_m))


def false_positives(evaluation: DetectionEvaluation) -> tuple[Failure, ...]:
    """The false positives at the evaluation's threshold, surest first."""
    matches = evaluation.matches
    sure = (matches.vehicle == FALSE_POSITIVE) & (matches.scores >= evaluation.threshold)
    return tuple(_false_positive(evaluation, int(index)) for index in np.flatnonzero(sure))


def count_kinds(failures: Sequence[Failure]) -> dict[FailureKind, int]:
    """How many there are of each kind, in the order of the kinds."""
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
