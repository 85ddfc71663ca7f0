"""A log of a simulated drive against its exact truth: distances, detections, warnings.

A track or a detection is of the vehicle whose true box it overlaps best, with an IoU of at least one half.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fcw.box import Box
from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.matching import FALSE_POSITIVE, HIT_IOU, match_detections
from fcw.logs.records import FrameResult
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth, warning_is_due
from fcw.warning.types import WarningLevel

NEAREST_M, FARTHEST_M = 5.0, 60.0
"""The distances that count."""
SEEN_FRACTION = 0.8
"""A vehicle less visible than this counts neither as found nor as missed."""
REAR_VIEW_SLOPE = 0.45
"""Seen farther from the side than this, sideways over forward (24 degrees), a vehicle shows as much of its
side as of its rear: no rear view."""
LATEST_WARNING_AFTER_S = 2.0
"""A warning that comes this long after it was due is not about that danger any more."""
LATEST_TTC_S = 4.0
"""ISO 15623 needs no warning above this time to collision. Behind a lead that brakes that is its enhanced
time to collision (ETTC), which takes the closing speed to grow on as it does; by the plain TTC a warning of a
braking lead would be held to be needless until it is too late: in Euro NCAP's CCRb at 40 m and -6 m/s^2 it is
due at a TTC of 5.7 s and an ETTC of 2.6 s."""
EARLIEST_WARNING_BEFORE_S = LATEST_TTC_S
"""A warning that came so long before it was due is not about that danger."""


@dataclass(frozen=True, slots=True)
class DueWarning:
    """A warning that had to come.

    Attributes:
        vehicle: whom it is about.
        earliest_s: from when on it is not too early, on the drive's clock: the true ETTC is 4 s or less.
        due_s: when a driver of 1.2 s and 0.4 g had to be warned at the latest.
        warned_s: when `warning` was shown first; None when it never was.
    """

    vehicle: str
    earliest_s: float
    due_s: float
    warned_s: float | None

    @property
    def in_window(self) -> bool:
        """Whether the warning came when it was needed, neither too early nor too late."""
        return self.warned_s is not None and self.earliest_s <= self.warned_s <= self.due_s

    @property
    def in_time(self) -> bool:
        """Whether the warning came when it was due, or before."""
        return self.warned_s is not None and self.warned_s <= self.due_s


@dataclass(frozen=True, slots=True)
class GivenWarning:
    """A `caution` or `warning` that came.

    Attributes:
        level: which.
        start_s: when, on the drive's clock.
        vehicle: whom it is truly about; None when no vehicle is there.
        oncoming: whether that vehicle comes towards us.
        ettc_s: its true enhanced time to collision then; None when it was not coming nearer.
    """

    level: WarningLevel
    start_s: float
    vehicle: str | None
    oncoming: bool
    ettc_s: float | None

    @property
    def needless(self) -> bool:
        """Whether nothing was there to warn of: no vehicle, an oncoming one, or an ETTC above 4 s."""
        return self.vehicle is None or self.oncoming or self.ettc_s is None or self.ettc_s > LATEST_TTC_S


@dataclass(frozen=True, slots=True)
class SimulatedComparison:
    """What a log is worth.

    Attributes:
        frames: number of frames.
        searched: how many of them were searched for vehicles.
        lead_frames: frames with a true lead between 5 and 60 m in sight.
        lead_errors: relative distance error, signed, of each of those frames in which the log has it as lead.
        track_errors: of every track of a vehicle between 5 and 60 m in sight.
        vehicles: vehicles that count, over all frames that were searched.
        hits: how many of them were detected.
        false_positives: detections of nothing.
        due: the warnings that had to come.
        given: the ones that came.
    """

    frames: int
    searched: int
    lead_frames: int
    lead_errors: tuple[float, ...]
    track_errors: tuple[float, ...]
    vehicles: int
    hits: int
    false_positives: int
    due: tuple[DueWarning, ...]
    given: tuple[GivenWarning, ...]

    @property
    def detection_rate(self) -> float:
        """Part of the vehicles that were detected; nan when there were none."""
        return self.hits / self.vehicles if self.vehicles else float("nan")

    @property
    def false_positives_per_frame(self) -> float:
        """Detections of nothing per frame that was searched; nan when none was."""
        return self.false_positives / self.searched if self.searched else float("nan")

    @property
    def needless(self) -> tuple[GivenWarning, ...]:
        """The warnings that nothing was there to warn of."""
        return tuple(warning for warning in self.given if warning.needless)

    @property
    def warnings_of_oncoming(self) -> int:
        """How often an oncoming vehicle was warned of: never, if all is well."""
        return sum(warning.oncoming for warning in self.given)


def compare_with_truth(
    results: Sequence[FrameResult], truths: Sequence[FrameTruth], minimum_width_px: float = 0.0
) -> SimulatedComparison:
    """Compare a log with the truth of its drive.

    Args:
        results: of the log, one a frame.
        truths: of the simulation, one a frame.
        minimum_width_px: narrower vehicles count neither as found nor as missed.

    Raises:
        ValueError: they have different numbers of frames, or none.
    """
    if len(results) != len(truths) or not results:
        raise ValueError(f"{len(results)} results and {len(truths)} frames of truth do not belong together")
    lead_frames = vehicles = hits = false_positives = 0
    lead_errors: list[float] = []
    track_errors: list[float] = []
    for result, truth in zip(results, truths, strict=True):
        for track in result.tracks:
            vehicle = vehicle_at(track.box, truth)
            if vehicle is not None and _measurable(vehicle):
                track_errors.append(track.distance_m / vehicle.distance_m - 1)
        lead = truth.lead
        if lead is not None and _measurable(lead):
            lead_frames += 1
            if result.lead is not None and vehicle_at(result.lead.box, truth) is lead:
                lead_errors.append(result.lead.distance_m / lead.distance_m - 1)
        if result.searched:
            counted, found, false = _detections(result, truth, minimum_width_px)
            vehicles, hits, false_positives = vehicles + counted, hits + found, false_positives + false
    given = _given_warnings(results, truths)
    return SimulatedComparison(
        frames=len(results),
        searched=sum(result.searched for result in results),
        lead_frames=lead_frames,
        lead_errors=tuple(lead_errors),
        track_errors=tuple(track_errors),
        vehicles=vehicles,
        hits=hits,
        false_positives=false_positives,
        due=_due_warnings(truths, given),
        given=given,
    )


def vehicle_at(box: Box, truth: FrameTruth) -> VehicleTruth | None:
    """The vehicle whose true box a box overlaps best, with an IoU of at least one half; else None."""
    if not truth.vehicles:
        return None
    overlap = intersection_over_union(_array([box]), _array([v.box for v in truth.vehicles]))[0]
    best = int(np.argmax(overlap))
    return truth.vehicles[best] if overlap[best] >= HIT_IOU else None


def counts_as_rear_view(vehicle: VehicleTruth) -> bool:
    """Whether a detector must find it: its rear in sight, between 5 and 60 m, not seen from the side."""
    return (
        not vehicle.oncoming
        and _measurable(vehicle)
        and abs(vehicle.lateral_m) <= REAR_VIEW_SLOPE * vehicle.distance_m
    )


def _measurable(vehicle: VehicleTruth) -> bool:
    return NEAREST_M <= vehicle.distance_m <= FARTHEST_M and vehicle.visible_fraction >= SEEN_FRACTION


def _detections(result: FrameResult, truth: FrameTruth, minimum_width_px: float) -> tuple[int, int, int]:
    """Vehicles that count, those found, and detections of nothing, in one frame."""
    ignored = np.array(
        [not counts_as_rear_view(v) or v.box.w < minimum_width_px for v in truth.vehicles], bool
    )
    matches = match_detections(
        _array([detection.box for detection in result.detections]),
        np.array([detection.score for detection in result.detections], np.float64),
        # What does not count is ignored with its whole body, as in hand-made labels.
        _array([v.body_box if skip else v.box for v, skip in zip(truth.vehicles, ignored, strict=True)]),
        ignored,
    )
    return int((~ignored).sum()), int((matches >= 0).sum()), int((matches == FALSE_POSITIVE).sum())


def _array(boxes: Sequence[Box]) -> np.ndarray:
    return np.array([(box.x, box.y, box.w, box.h) for box in boxes], np.float64).reshape(-1, 4)


def _given_warnings(results: Sequence[FrameResult], truths: Sequence[FrameTruth]) -> tuple[GivenWarning, ...]:
    """Every rise of the level to `caution` or `warning`, with the vehicle it is about."""
    given = []
    before: tuple[WarningLevel, int | None] = (WarningLevel.NONE, None)
    for index, (result, truth) in enumerate(zip(results, truths, strict=True)):
        now = result.warning.level, result.warning.track_id
        rises = now[0] > before[0] or now[1] != before[1]
        if now[0] >= WarningLevel.CAUTION and rises:
            track = next((track for track in result.tracks if track.track_id == now[1]), None)
            vehicle = vehicle_at(track.box, truth) if track is not None else None
            name, oncoming, ettc_s = None, False, None
            if vehicle is not None:
                name, oncoming = vehicle.name, vehicle.oncoming
                ettc_s = _true_ettc_s(vehicle, truth, truths[max(index - 1, 0)])
            given.append(GivenWarning(now[0], truth.time_ns / 1e9, name, oncoming, ettc_s))
        before = now
    return tuple(given)


def enhanced_ttc_s(distance_m: float, closing_mps: float, growth_mps2: float) -> float | None:
    """Time until the distance is used up if the closing speed goes on growing as it does (ISO 15623's ETTC).

    A closing speed that shrinks counts as constant: whoever brakes may let go. None where nothing closes.
    """
    if closing_mps <= 0:
        return None
    # The solution of d = v t + a t^2 / 2 in the form that holds for a = 0 too.
    return 2 * distance_m / (closing_mps + math.sqrt(closing_mps**2 + 2 * max(growth_mps2, 0.0) * distance_m))


def _true_ettc_s(vehicle: VehicleTruth, truth: FrameTruth, before: FrameTruth) -> float | None:
    growth_mps2 = _closing_acceleration_mps2(vehicle, truth, before)
    return enhanced_ttc_s(vehicle.distance_m, vehicle.closing_speed_mps, growth_mps2)


def _closing_acceleration_mps2(vehicle: VehicleTruth, truth: FrameTruth, before: FrameTruth) -> float:
    """How fast the closing speed of a vehicle grows, since the frame before; 0 where it was not there."""
    earlier = next((other for other in before.vehicles if other.name == vehicle.name), None)
    dt_s = (truth.time_ns - before.time_ns) / 1e9
    if earlier is None or dt_s <= 0:
        return 0.0
    return (vehicle.closing_speed_mps - earlier.closing_speed_mps) / dt_s


def _due_warnings(truths: Sequence[FrameTruth], given: Sequence[GivenWarning]) -> tuple[DueWarning, ...]:
    """The warnings that had to come, each with the one that came."""
    due = []
    last_s: dict[str, float] = {}
    near_s: dict[str, list[float]] = {}
    for index, truth in enumerate(truths):
        time_s, lead = truth.time_ns / 1e9, truth.lead
        if lead is None:
            continue
        ettc_s = _true_ettc_s(lead, truth, truths[max(index - 1, 0)])
        if ettc_s is not None and ettc_s <= LATEST_TTC_S:
            near_s.setdefault(lead.name, []).append(time_s)
        if not warning_is_due(lead):
            continue
        # A danger that goes away for a moment is still the same danger.
        is_new = time_s - last_s.get(lead.name, float("-inf")) > LATEST_WARNING_AFTER_S
        last_s[lead.name] = time_s
        if is_new:
            near = (at_s for at_s in near_s.get(lead.name, ()) if at_s >= time_s - EARLIEST_WARNING_BEFORE_S)
            earliest_s = next(near, time_s)
            due.append(DueWarning(lead.name, earliest_s, time_s, _warned_s(lead.name, time_s, given)))
    return tuple(due)


def _warned_s(vehicle: str, due_s: float, given: Sequence[GivenWarning]) -> float | None:
    times_s = (
        warning.start_s
        for warning in given
        if warning.level == WarningLevel.WARNING
        and warning.vehicle == vehicle
        and due_s - EARLIEST_WARNING_BEFORE_S <= warning.start_s <= due_s + LATEST_WARNING_AFTER_S
    )
    return next(times_s, None)
