"""Sizes and shapes of labelled vehicles: what the distance prior searches for."""

from collections.abc import Iterable

import numpy as np

from fcw.detection.model import VehicleStatistics
from fcw.detection.training.dataset import TrainingImage

# The search extends beyond the sizes of labelled vehicles, because calibrations are wrong (by 20 % for some
# clips), and a car that brakes or climbs pitches. Far away, where vehicles are few rows below the horizon,
# that makes sizes in metres look much too small. Wider margins found no more and cost time (0.3 to 12 m: 2.7
# times).
TAIL = 0.01
LOW_MARGIN = 0.6
HIGH_MARGIN = 1.25
# Distances at which the aspect ratio is taken. Bins meet half way between two, on a logarithmic scale.
ASPECT_DISTANCES_M = (6.0, 10.0, 16.0, 25.0, 40.0)
MIN_VEHICLES_IN_BIN = 10


def vehicle_statistics(images: Iterable[TrainingImage]) -> VehicleStatistics:
    """Statistics of the vehicles that count, each seen through its clip's calibration.

    The size sqrt(width height) in metres is the size in pixels times the camera's height over the number of
    rows from the horizon to the bottom edge. At the vehicle's distance, that many rows are as long as the
    camera is high (up to the cosine of the pitch). The search range is from 0.6 times the 1 % quantile to
    1.25 times the 99 % quantile.

    Raises:
        ValueError: no vehicle stands below its picture's horizon.
    """
    sizes_m: list[float] = []
    ratios: list[float] = []
    distances_m: list[float] = []
    for image in images:
        for _, y, w, h in image.labelled.boxes[~image.labelled.ignored]:
            below_px = y + h - image.calibration.horizon_row_px
            distance_m = image.calibration.camera.distance_at(float(y + h))
            if below_px > 0 and 0 < distance_m < np.inf:
                sizes_m.append(np.sqrt(w * h) * image.calibration.camera.height_m / below_px)
                ratios.append(w / h)
                distances_m.append(distance_m)
    if not sizes_m:
        raise ValueError("no labelled vehicle stands below the horizon")
    low_m, median_m, high_m = np.quantile(sizes_m, [TAIL, 0.5, 1 - TAIL])
    support, medians = [], []
    nearest = np.abs(np.log(distances_m)[:, None] - np.log(ASPECT_DISTANCES_M)).argmin(axis=1)
    for index, distance_m in enumerate(ASPECT_DISTANCES_M):
        members = np.array(ratios)[nearest == index]
        if len(members) >= MIN_VEHICLES_IN_BIN:
            support.append(distance_m)
            medians.append(float(np.median(members)))
    if not support:
        support, medians = [float(np.median(distances_m))], [float(np.median(ratios))]
    return VehicleStatistics(
        size_low_m=float(low_m) * LOW_MARGIN,
        size_median_m=float(median_m),
        size_high_m=float(high_m) * HIGH_MARGIN,
        aspect_distances_m=tuple(support),
        aspect_ratios=tuple(medians),
    )
