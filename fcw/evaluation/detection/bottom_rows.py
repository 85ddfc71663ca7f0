"""Errors of the bottom rows of detections, on which distances depend, against labels."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from fcw.evaluation.detection.figures import DetectionEvaluation
from fcw.units import MAD_TO_SIGMA


@dataclass(frozen=True, slots=True)
class BottomRows:
    """Detected minus labelled bottom row of the hits, in pixels; positive is too low, and measured too near.

    Attributes:
        count: number of hits.
        vehicles: number of different vehicles among them.
        bias_px: mean error.
        sigma_px: standard deviation of the errors.
        median_px: median error.
        robust_sigma_px: standard deviation from the median absolute deviation.
    """

    count: int
    vehicles: int
    bias_px: float
    sigma_px: float
    median_px: float
    robust_sigma_px: float


def bottom_rows(
    evaluation: DetectionEvaluation,
    sources: Collection[str],
    smallest_px: float = 20.0,
    largest_px: float = 60.0,
) -> BottomRows | None:
    """The bottom rows of the hits at the evaluation's threshold.

    Args:
        evaluation: detections matched with labels.
        sources: only boxes with these values of the annotations' `source`.
        smallest_px: least height of the boxes.
        largest_px: largest height of the boxes.

    Returns:
        None if no box is left.
    """
    matches = evaluation.matches
    errors, vehicles = [], set()
    for index in np.flatnonzero((matches.vehicle >= 0) & (matches.scores >= evaluation.threshold)):
        vehicle = int(matches.vehicle[index])
        image = evaluation.images[int(matches.vehicle_frame[vehicle])]
        label = int(matches.vehicle_label[vehicle])
        _, y, _, h = image.labelled.boxes[label]
        if image.attributes[label].get("source") in sources and smallest_px <= h <= largest_px:
            errors.append(matches.boxes[index, 1] + matches.boxes[index, 3] - (y + h))
            vehicles.add(int(evaluation.grouping.vehicle[vehicle]))
    if not errors:
        return None
    values = np.array(errors)
    median = float(np.median(values))
    return BottomRows(
        count=len(values),
        vehicles=len(vehicles),
        bias_px=float(values.mean()),
        sigma_px=float(values.std()),
        median_px=median,
        robust_sigma_px=MAD_TO_SIGMA * float(np.median(np.abs(values - median))),
    )
