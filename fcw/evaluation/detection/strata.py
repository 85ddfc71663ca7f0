"""Detection rates by kind of vehicle, all at the same pooled thresholds.

A threshold is chosen once, so that the detector has a given number of false positives per picture over all
pictures. Each kind of vehicle and each camera is judged at this threshold, because a program has only one,
whatever drives ahead of it. Pictures in which not every vehicle is labelled count neither for the threshold
nor for the kinds; their camera has a row of its own.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.detection.matching import Matches, pool_matches
from fcw.evaluation.detection.detectors import FrameDetections
from fcw.evaluation.detection.figures import HEIGHT_PART_EDGES
from fcw.evaluation.detection.intervals import RESAMPLES, Grouping, Interval, interval
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.json_form import to_json, without_non_finite

NEAR_HEIGHT = 0.2
CLEAR_WIDTH_PX = 24.0
KINDS = {"cars, SUVs": frozenset({"car", "suv"}), "vans, lorries, buses": frozenset({"van", "truck", "bus"})}
FOG_CAMERA, DUSK_CLIP = "dawn", "camvid_0001TP"


@dataclass(frozen=True, slots=True)
class LabelledVehicle:
    """A vehicle that counts, as its labels describe it.

    Attributes:
        camera: camera that took the picture.
        clip: clip of the picture.
        complete: whether all vehicles in the picture are labelled.
        width_px: width of its box.
        height_part: height of its box as a part of the picture's height.
        occluded: 0 for not hidden, 1 for up to about 40 %, 2 for more.
        truncated: whether it is cut by the edge of the picture.
        view: rear or rear-quarter; None if not labelled.
        kind: car, suv, van, truck or bus; None if not labelled.
    """

    camera: str
    clip: str
    complete: bool
    width_px: float
    height_part: float
    occluded: int
    truncated: bool
    view: str | None
    kind: str | None

    @classmethod
    def of(cls, image: AnnotatedImage, label: int) -> "LabelledVehicle":
        """The vehicle of one label of a picture."""
        labelled, fields = image.labelled, image.attributes[label]
        _, _, w, h = labelled.boxes[label]
        return cls(
            camera=labelled.camera,
            clip=labelled.clip,
            complete=labelled.complete,
            width_px=float(w),
            height_part=float(h) / labelled.size.height,
            occluded=int(fields.get("occluded") or 0),
            truncated=bool(fields.get("truncated")),
            view=fields.get("view"),
            kind=fields.get("kind"),
        )

    @property
    def clear(self) -> bool:
        """Whether nothing hides it and it is large enough to be seen well."""
        return self.occluded == 0 and self.width_px >= CLEAR_WIDTH_PX

    @property
    def near(self) -> bool:
        """Whether it takes a fifth of the picture's height or more."""
        return self.height_part >= NEAR_HEIGHT


Condition = Callable[[LabelledVehicle], bool]


def _between(low: float, high: float, vehicle: LabelledVehicle) -> bool:
    return low <= vehicle.height_part < high


def _height_name(low: float, high: float) -> str:
    if not low:
        return f"height under {high:.0%}"
    return f"height {low:.0%} to {high:.0%}" if math.isfinite(high) else f"height from {low:.0%}"


STRATA: Mapping[str, Condition] = {
    "all": lambda vehicle: True,
    "clear": lambda vehicle: vehicle.clear,
    "clear, rear": lambda vehicle: vehicle.clear and vehicle.view == "rear",
    "clear, rear-quarter": lambda vehicle: vehicle.clear and vehicle.view == "rear-quarter",
    **{_height_name(low, high): partial(_between, low, high) for low, high in pairwise(HEIGHT_PART_EDGES)},
    "near": lambda vehicle: vehicle.near,
    "near, not hidden": lambda vehicle: vehicle.near and vehicle.occluded == 0,
    "near, truncated": lambda vehicle: vehicle.near and vehicle.truncated,
    **{name: (lambda vehicle, kinds=kinds: vehicle.kind in kinds) for name, kinds in KINDS.items()},
    "half-hidden": lambda vehicle: vehicle.occluded == 1,
    "truncated": lambda vehicle: vehicle.truncated,
    "fog": lambda vehicle: vehicle.camera == FOG_CAMERA,
    "dusk": lambda vehicle: vehicle.clip == DUSK_CLIP,
    "fog, dusk": lambda vehicle: vehicle.camera == FOG_CAMERA or vehicle.clip == DUSK_CLIP,
}
"""Kinds of vehicles by name. Vehicles without a label for kind or view are not in the rows of these."""


@dataclass(frozen=True, slots=True)
class StratumRates:
    """How many vehicles of a kind are found.

    Attributes:
        boxes: number of boxes that count.
        vehicles: number of different vehicles among them.
        rates: detection rate at each threshold; NaN if there is no vehicle.
        intervals: 95 % interval of each rate, with clips, vehicles and thresholds resampled.
        intervals_same_clips: the same with the clips kept and only their vehicles resampled.
        any_score: part of the boxes that is found with any score.
    """

    boxes: int
    vehicles: int
    rates: tuple[float, ...]
    intervals: tuple[Interval, ...]
    intervals_same_clips: tuple[Interval, ...]
    any_score: float


@dataclass(frozen=True, slots=True)
class CameraRates:
    """The clear vehicles and the false positives of a camera at the pooled thresholds.

    Attributes:
        pictures: number of its pictures.
        clear: rates of its clear vehicles.
        fppi: false positives per picture at each threshold; NaN if pictures are not completely labelled.
    """

    pictures: int
    clear: StratumRates
    fppi: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class StratifiedRates:
    """A detector by kinds of vehicles.

    Attributes:
        at_fppi: false positives per picture over all pictures for which the thresholds are chosen.
        thresholds: the score thresholds.
        pictures: number of pictures in which false positives are counted.
        strata: rates by name, in the order of STRATA.
        cameras: rates by name.
    """

    at_fppi: tuple[float, ...]
    thresholds: tuple[float, ...]
    pictures: int
    strata: Mapping[str, StratumRates]
    cameras: Mapping[str, CameraRates]

    def as_json(self) -> dict[str, Any]:
        """All figures as JSON values; undefined values are None."""
        return without_non_finite(
            {
                "at_fppi": list(self.at_fppi),
                "thresholds": list(self.thresholds),
                "pictures": self.pictures,
                "strata": {name: to_json(rates) for name, rates in self.strata.items()},
                "cameras": {name: to_json(rates) for name, rates in self.cameras.items()},
            }
        )


def stratified_rates(
    images: Sequence[AnnotatedImage],
    found: Sequence[FrameDetections],
    at_fppi: Sequence[float],
    resamples: int = RESAMPLES,
) -> StratifiedRates:
    """Match what a detector found, choose its thresholds over all pictures, and judge each kind at them.

    Args:
        images: the pictures.
        found: what it found in each picture, with boxes of every score.
        at_fppi: false positives per picture at which to judge.
        resamples: number of resamples for each interval.

    Raises:
        ValueError: there is no picture.
    """
    matches = pool_matches(
        image.labelled.with_detections(frame.boxes, frame.scores)
        for image, frame in zip(images, found, strict=True)
    )
    vehicles = [
        LabelledVehicle.of(images[frame], int(label))
        for frame, label in zip(matches.vehicle_frame, matches.vehicle_label, strict=True)
    ]
    cameras = sorted({image.labelled.camera for image in images})
    members = [
        *(np.array([v.complete and condition(v) for v in vehicles], bool) for condition in STRATA.values()),
        *(np.array([v.clear and v.camera == camera for v in vehicles], bool) for camera in cameras),
    ]
    thresholds = tuple(matches.curve().at_fppi(fppi).threshold for fppi in at_fppi)
    rates = _rates(matches, Grouping.of(images, matches), members, thresholds, at_fppi, resamples)
    taken_by = np.array([image.labelled.camera for image in images])
    return StratifiedRates(
        at_fppi=tuple(at_fppi),
        thresholds=thresholds,
        pictures=matches.frames,
        strata=dict(zip(STRATA, rates, strict=False)),
        cameras={
            camera: CameraRates(
                pictures=int((taken_by == camera).sum()),
                clear=clear,
                fppi=_fppi(matches, taken_by == camera, thresholds),
            )
            for camera, clear in zip(cameras, rates[len(STRATA) :], strict=True)
        },
    )


def _rates(
    matches: Matches,
    grouping: Grouping,
    members: Sequence[NDArray[np.bool_]],
    thresholds: Sequence[float],
    at_fppi: Sequence[float],
    resamples: int,
) -> list[StratumRates]:
    """The rates of several kinds, all from the same resamples.

    Args:
        matches: matches of all pictures.
        grouping: grouping of the same pictures.
        members: for each kind, (V,) whether a vehicle is of it.
        thresholds: thresholds at which to judge.
        at_fppi: false positives per picture for which they are chosen, again in each resample.
        resamples: number of resamples.
    """
    kinds = np.array(members, np.float64)
    best = np.full(len(matches.vehicle_frame), -math.inf)  # score of each vehicle's hit
    best[matches.vehicle[matches.vehicle >= 0]] = matches.scores[matches.vehicle >= 0]
    every = np.ones(len(best))

    def rates(weights: NDArray[np.float64], cuts: Sequence[float]) -> NDArray[np.float64]:
        """(K, T) rate of each kind at each threshold."""
        hit = best[:, None] >= np.array(cuts)
        counts = (kinds @ weights)[:, None]
        with np.errstate(invalid="ignore"):
            return (kinds @ (weights[:, None] * hit)) / counts

    drawn = []
    for same_clips in (False, True):
        values = []
        for vehicles, frames in grouping.resamples(resamples, same_clips):
            curve = matches.curve(vehicles, frames)
            values.append(rates(vehicles, [curve.at_fppi(fppi).threshold for fppi in at_fppi]))
        drawn.append(np.array(values))
    here = rates(every, thresholds)
    found = rates(every, [np.finfo(float).min])
    return [
        StratumRates(
            boxes=int(members[kind].sum()),
            vehicles=len(np.unique(grouping.vehicle[members[kind]])),
            rates=tuple(here[kind].tolist()),
            intervals=tuple(interval(drawn[0][:, kind, at]) for at in range(len(thresholds))),
            intervals_same_clips=tuple(interval(drawn[1][:, kind, at]) for at in range(len(thresholds))),
            any_score=float(found[kind, 0]),
        )
        for kind in range(len(members))
    ]


def _fppi(matches: Matches, pictures: NDArray[np.bool_], thresholds: Sequence[float]) -> tuple[float, ...]:
    """False positives per picture in some pictures, at each threshold."""
    complete = int((matches.complete & pictures).sum())
    false = matches.scores[(matches.vehicle < 0) & pictures[matches.frame]]
    if not complete:
        return tuple(math.nan for _ in thresholds)
    return tuple(float((false >= threshold).sum()) / complete for threshold in thresholds)
