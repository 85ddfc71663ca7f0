"""Intervals of detection figures by resampling what is independent: clips, and vehicles in them.

A vehicle is drawn with all its boxes in all pictures, and false positives with stretches of pictures
(B. Efron, R. Tibshirani, An Introduction to the Bootstrap, 1993, ch. 8; in two stages as in A. Davison,
D. Hinkley, Bootstrap Methods and their Application, 1997, sect. 3.8). With a single clip, only its vehicles
are drawn, so that the interval does not contain the difference between cameras. With three clips it is wide,
as it should be. If the question is about these clips alone, they can be kept, and only their content drawn.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.matching import DetectionCurve, Matches
from fcw.evaluation.detection.labels import AnnotatedImage
from fcw.evaluation.detection.vehicles import frame_blocks, vehicle_identities

CONFIDENCE = 0.95
RESAMPLES = 1000


class Interval(NamedTuple):
    """The 95 % confidence interval of a figure."""

    low: float
    high: float


class Weights(NamedTuple):
    """One resample: how often each vehicle (V,) and each picture (F,) is drawn."""

    vehicles: NDArray[np.float64]
    frames: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Grouping:
    """What belongs together.

    Attributes:
        vehicle: (V,) number, from 0, of the vehicle in each box that counts.
        vehicle_clip: (V,) clip of each of these boxes.
        block: (F,) stretch of pictures to which each picture belongs.
        clip: (F,) clip of each picture.
    """

    vehicle: NDArray[np.int64]
    vehicle_clip: NDArray[np.int64]
    block: NDArray[np.int64]
    clip: NDArray[np.int64]

    @classmethod
    def of(cls, images: Sequence[AnnotatedImage], matches: Matches) -> "Grouping":
        """The groups of labelled pictures, with vehicles in the order of `matches`."""
        identities = vehicle_identities(images)
        clips = sorted({image.labelled.clip for image in images})
        clip = np.array([clips.index(image.labelled.clip) for image in images], np.int64)
        places = zip(matches.vehicle_frame, matches.vehicle_label, strict=True)
        vehicle = np.array([identities[frame][label] for frame, label in places], np.int64)
        numbers = np.unique(vehicle, return_inverse=True)[1].astype(np.int64)
        return cls(numbers, clip[matches.vehicle_frame], frame_blocks(images), clip)

    def resamples(self, count: int = RESAMPLES, same_clips: bool = False, seed: int = 0) -> Iterator[Weights]:
        """Draw clips and, within each drawn clip, its vehicles and its stretches of pictures.

        The same arguments give the same draws, so that figures of two detectors can be compared in pairs.

        Args:
            count: number of resamples.
            same_clips: whether to keep every clip, and draw only within the clips.
            seed: seed of the draws.
        """
        random = np.random.default_rng(seed)
        vehicles_of = _members(self.vehicle, self.vehicle_clip)
        frames_of = _members(self.block, self.clip)
        clips = np.unique(self.clip)
        for _ in range(count):
            vehicles, frames = np.zeros(len(self.vehicle)), np.zeros(len(self.clip))
            for clip in clips if same_clips else random.choice(clips, len(clips)):
                for weights, members in ((vehicles, vehicles_of.get(clip)), (frames, frames_of.get(clip))):
                    if members is not None:
                        drawn = random.integers(members.groups, size=members.groups)
                        weights[members.places] += np.bincount(drawn, minlength=members.groups)[members.group]
            yield Weights(vehicles, frames)


@lru_cache(maxsize=2)
def vehicle_draws(grouping: Grouping, count: int) -> NDArray[np.float64]:
    """(count, V) how often each vehicle is drawn in each of `Grouping.resamples`.

    The result is cached, because every kind and every clip needs it, and drawing is most of the work.
    """
    draws = np.array([weights.vehicles for weights in grouping.resamples(count)])
    draws.setflags(write=False)
    return draws


class _Members(NamedTuple):
    """The members of a clip: indices, the group of each (vehicle or stretch), and the number of groups."""

    places: NDArray[np.int64]
    group: NDArray[np.int64]
    groups: int


def _members(names: NDArray[np.int64], clips: NDArray[np.int64]) -> dict[int, _Members]:
    members = {}
    for clip in np.unique(clips):
        index = np.flatnonzero(clips == clip)
        different, group = np.unique(names[index], return_inverse=True)
        members[int(clip)] = _Members(index, group, len(different))
    return members


def interval(values: Sequence[float] | NDArray[np.float64]) -> Interval:
    """The middle 95 % of resampled values; undefined ones (NaN) are left out."""
    defined = np.asarray(values)[~np.isnan(values)]
    if not len(defined):
        return Interval(float("nan"), float("nan"))
    low, high = np.quantile(defined, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return Interval(float(low), float(high))


def curve_intervals(
    matches: Matches,
    grouping: Grouping,
    figures: Callable[[DetectionCurve], Sequence[float]],
    resamples: int = RESAMPLES,
    same_clips: bool = False,
) -> tuple[Interval, ...]:
    """Intervals of several figures of the curve, from the same resamples (see `Grouping.resamples`)."""
    values = [figures(matches.curve(*weights)) for weights in grouping.resamples(resamples, same_clips)]
    return tuple(interval(column) for column in zip(*values, strict=True))
