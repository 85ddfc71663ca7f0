"""All figures of the evaluation of a detector on labelled pictures, and their JSON."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.detection.matching import (
    DetectionCurve,
    Matches,
    OperatingPoint,
    pool_matches,
)
from fcw.evaluation.detection.detectors import (
    CalibrationOf,
    FrameDetections,
    mean_windows,
    median_milliseconds,
)
from fcw.evaluation.detection.intervals import (
    CONFIDENCE,
    RESAMPLES,
    Grouping,
    Interval,
    curve_intervals,
    interval,
    vehicle_draws,
)
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.json_form import without_non_finite

DISTANCE_EDGES_M = (0.0, 5.0, 15.0, 30.0, 50.0, 80.0, math.inf)
HEIGHT_EDGES_PX = (0.0, 20.0, 30.0, 40.0, 60.0, 100.0, math.inf)
HEIGHT_PART_EDGES = (0.0, 0.05, 0.1, 0.2, 0.35, math.inf)
"""Edges of the classes of height, as parts of the picture's height."""


@dataclass(frozen=True, slots=True)
class Stratum:
    """The vehicles of one kind at the threshold of the evaluation.

    Attributes:
        vehicles: number of boxes that count.
        distinct_vehicles: number of different vehicles among them.
        detection_rate: part of the boxes that is hit; NaN if there are none.
        detection_rate_interval: 95 % interval of the rate.
        fppi: false positives of this kind per picture (of the clip, if the kinds are clips); NaN if false
            positives have no such kind, or no picture is completely labelled.
    """

    vehicles: int
    distinct_vehicles: int
    detection_rate: float
    detection_rate_interval: Interval
    fppi: float


@dataclass(frozen=True, slots=True, eq=False)
class DetectionEvaluation:
    """A detector against labels.

    Attributes:
        images: the pictures.
        found: what was found in each picture, with boxes of every score.
        matches: detections matched with vehicles.
        grouping: which boxes and pictures belong together.
        curve: the curve over all pictures.
        threshold: least score at which the detector takes a window for a vehicle.
        distances_m: (V,) distances of the vehicles that count, from their labelled bottom rows.
        false_distances_m: (D,) distances of the detections, from their bottom rows.
        ms_per_frame: median time of the detector's thread; None if it was not measured.
        windows_per_frame: mean number of windows searched; None if the detector does not tell.
    """

    images: tuple[AnnotatedImage, ...]
    found: tuple[FrameDetections, ...]
    matches: Matches
    grouping: Grouping
    curve: DetectionCurve
    threshold: float
    distances_m: NDArray[np.float64]
    false_distances_m: NDArray[np.float64]
    ms_per_frame: float | None
    windows_per_frame: float | None

    @property
    def operating_point(self) -> OperatingPoint:
        """Detection rate and FPPI at the threshold."""
        return self.curve.at_threshold(self.threshold)

    def intervals(
        self, fppi: Sequence[float], resamples: int = RESAMPLES, same_clips: bool = False
    ) -> dict[str, Interval]:
        """95 % intervals of `detection_rate`, `fppi`, `average_precision`, and `at X` for each FPPI."""
        names = ("detection_rate", "fppi", "average_precision", *(f"at {x:g}" for x in fppi))
        values = curve_intervals(
            self.matches,
            self.grouping,
            lambda curve: (
                *curve.at_threshold(self.threshold)[1:],
                curve.average_precision,
                *(curve.at_fppi(x).detection_rate for x in fppi),
            ),
            resamples,
            same_clips,
        )
        return dict(zip(names, values, strict=True))

    def by_distance(self, resamples: int = RESAMPLES) -> dict[str, Stratum]:
        """Strata by distance in metres."""
        return self._binned(self.distances_m, self.false_distances_m, DISTANCE_EDGES_M, resamples)

    def by_height(self, resamples: int = RESAMPLES) -> dict[str, Stratum]:
        """Strata by height of the box in pixels."""
        return self._binned(self.vehicle_boxes[:, 3], self.matches.boxes[:, 3], HEIGHT_EDGES_PX, resamples)

    def by_height_part(self, resamples: int = RESAMPLES) -> dict[str, Stratum]:
        """Strata by height of the box as a part of the picture's height."""
        heights = np.array([image.labelled.size.height for image in self.images], np.float64)
        vehicles = self.vehicle_boxes[:, 3] / heights[self.matches.vehicle_frame]
        detections = self.matches.boxes[:, 3] / heights[self.matches.frame]
        return self._binned(vehicles, detections, HEIGHT_PART_EDGES, resamples)

    def by_attribute(self, name: str, resamples: int = RESAMPLES) -> dict[str, Stratum]:
        """Strata by a field of the annotations such as `kind` or `view`; vehicles without it are in none."""
        places = zip(self.matches.vehicle_frame, self.matches.vehicle_label, strict=True)
        values = np.array([str(self.images[frame].attributes[label].get(name)) for frame, label in places])
        return {
            str(value): self._stratum(values == value, None, 0, resamples)
            for value in np.unique(values)
            if value != str(None)
        }

    def by_clip(self, resamples: int = RESAMPLES) -> dict[str, Stratum]:
        """Strata by clip, with false positives per picture of the clip."""
        clips = np.array([image.labelled.clip for image in self.images])
        return {
            str(clip): self._stratum(
                clips[self.matches.vehicle_frame] == clip,
                clips[self.matches.frame] == clip,
                int((self.matches.complete & (clips == clip)).sum()),
                resamples,
            )
            for clip in np.unique(clips)
        }

    @property
    def vehicle_boxes(self) -> NDArray[np.float64]:
        """(V, 4) labelled boxes that count, in the order of `matches`."""
        places = zip(self.matches.vehicle_frame, self.matches.vehicle_label, strict=True)
        boxes = [self.images[frame].labelled.boxes[label] for frame, label in places]
        return np.array(boxes, np.float64).reshape(-1, 4)

    @property
    def hit(self) -> NDArray[np.bool_]:
        """(V,) whether each vehicle is found at the threshold."""
        hit = np.zeros(len(self.matches.vehicle_frame), bool)
        vehicle = self.matches.vehicle[self.matches.scores >= self.threshold]
        hit[vehicle[vehicle >= 0]] = True
        return hit

    def as_json(self, at_fppi: Sequence[float] = (), resamples: int = RESAMPLES) -> dict[str, Any]:
        """All figures as JSON values; rates are fractions, and undefined values are None."""
        intervals = self.intervals(at_fppi, resamples)
        same_clips = self.intervals(at_fppi, resamples, same_clips=True)
        point = self.operating_point
        result: dict[str, Any] = {
            "frames": len(self.images),
            "vehicles": len(self.matches.vehicle_frame),
            "distinct_vehicles": len(np.unique(self.grouping.vehicle)),
            "score_threshold": self.threshold,
            "detection_rate": point.detection_rate,
            "fppi": point.fppi,
            "average_precision": self.curve.average_precision,
            "ms_per_frame": self.ms_per_frame,
            "windows_per_frame": self.windows_per_frame,
            "confidence": CONFIDENCE,
        }
        for name in ("detection_rate", "fppi", "average_precision"):
            result[f"{name}_interval"] = intervals[name]
            result[f"{name}_interval_same_clips"] = same_clips[name]
        points = [(x, self.curve.at_fppi(x)) for x in at_fppi]
        if points:
            result["detection_rate_at_fppi"] = points[0][1].detection_rate
            result["at_fppi"] = [
                {
                    "fppi": x,
                    "detection_rate": at.detection_rate,
                    "detection_rate_interval": intervals[f"at {x:g}"],
                    "detection_rate_interval_same_clips": same_clips[f"at {x:g}"],
                    "score_threshold": at.threshold,
                }
                for x, at in points
            ]
        for name, strata in (
            ("by_distance", self.by_distance(resamples)),
            ("by_height", self.by_height(resamples)),
            ("by_height_part", self.by_height_part(resamples)),
            ("by_view", self.by_attribute("view", resamples)),
            ("by_kind", self.by_attribute("kind", resamples)),
            ("by_clip", self.by_clip(resamples)),
        ):
            result[name] = {kind: _stratum_json(stratum) for kind, stratum in strata.items()}
        result["curve"] = [
            {"score_threshold": at.threshold, "detection_rate": at.detection_rate, "fppi": at.fppi}
            for at in self.curve.points()
        ]
        return without_non_finite(result)

    def _binned(
        self,
        vehicles: NDArray[np.float64],
        detections: NDArray[np.float64],
        edges: Sequence[float],
        resamples: int,
    ) -> dict[str, Stratum]:
        strata = {}
        for low, high in pairwise(edges):
            inside, false_inside = (
                (values >= low) & ((values < high) | math.isinf(high)) for values in (vehicles, detections)
            )
            name = f"{low:g}-{high:g}" if math.isfinite(high) else f"{low:g}+"
            strata[name] = self._stratum(inside, false_inside, self.matches.frames, resamples)
        return strata

    def _stratum(
        self, vehicles: NDArray[np.bool_], detections: NDArray[np.bool_] | None, frames: int, resamples: int
    ) -> Stratum:
        hit, rates = self.hit & vehicles, np.zeros(0)
        if vehicles.any():
            draws = vehicle_draws(self.grouping, resamples)
            totals = draws[:, vehicles].sum(axis=1)
            rates = draws[:, hit].sum(axis=1)[totals > 0] / totals[totals > 0]
        sure = (self.matches.scores >= self.threshold) & (self.matches.vehicle < 0)
        count = int(vehicles.sum())
        return Stratum(
            vehicles=count,
            distinct_vehicles=len(np.unique(self.grouping.vehicle[vehicles])),
            detection_rate=float(hit.sum() / count) if count else math.nan,
            detection_rate_interval=interval(rates),
            fppi=math.nan if detections is None or not frames else float((sure & detections).sum() / frames),
        )


def evaluate(
    images: Sequence[AnnotatedImage],
    calibration_of: CalibrationOf,
    found: Sequence[FrameDetections],
    threshold: float,
    timed: Sequence[FrameDetections] = (),
) -> DetectionEvaluation:
    """Match what a detector found with the labels, and compute the distances of both.

    Args:
        images: the pictures.
        calibration_of: their calibrations.
        found: what it found in each picture, with boxes of every score.
        threshold: least score at which it takes a window for a vehicle.
        timed: what it found at this threshold, with the times that count; empty if times were not measured.

    Raises:
        ValueError: there is no picture.
        UserError: a picture has no calibration.
    """
    matches = pool_matches(
        image.labelled.with_detections(frame.boxes, frame.scores)
        for image, frame in zip(images, found, strict=True)
    )
    return DetectionEvaluation(
        images=tuple(images),
        found=tuple(found),
        matches=matches,
        grouping=Grouping.of(images, matches),
        curve=matches.curve(),
        threshold=threshold,
        distances_m=np.array(
            [
                _distance_m(images[frame], calibration_of, images[frame].labelled.boxes[label])
                for frame, label in zip(matches.vehicle_frame, matches.vehicle_label, strict=True)
            ]
        ),
        false_distances_m=np.array(
            [
                _distance_m(images[frame], calibration_of, box)
                for frame, box in zip(matches.frame, matches.boxes, strict=True)
            ]
        ),
        ms_per_frame=median_milliseconds(timed) if timed else None,
        windows_per_frame=mean_windows(timed) if timed else None,
    )


def _distance_m(image: AnnotatedImage, calibration_of: CalibrationOf, box: NDArray[np.float64]) -> float:
    """Distance at the bottom row of a box; 0 if that is nearer than the bumper."""
    return max(calibration_of(image.labelled).distance_at(float(box[1] + box[3])), 0.0)


def _stratum_json(stratum: Stratum) -> dict[str, Any]:
    return {
        "vehicles": stratum.vehicles,
        "distinct_vehicles": stratum.distinct_vehicles,
        "detection_rate": stratum.detection_rate,
        "detection_rate_interval": stratum.detection_rate_interval,
        "fppi": stratum.fppi,
    }
