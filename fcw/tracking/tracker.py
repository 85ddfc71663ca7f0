"""Vehicles followed from frame to frame: association, births and deaths, and the lead."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.tracking.horizon import MountWatch, MountWatchSettings, RulerReading
from fcw.tracking.lead import Corridor, path_curvature_per_m, select_lead
from fcw.tracking.lead_speed import SpeedPrior, with_own_speed
from fcw.tracking.range_filter import RangeFilter, RangeState
from fcw.tracking.range_model import RangeModel
from fcw.tracking.ranging import BoxNoise, inner_edge_px
from fcw.tracking.types import Track

NEVER = 1e6
"""Cost of a pair that must not be associated."""
NEAREST_M = 0.5
"""Nothing ahead comes nearer to a camera behind a windscreen: a track coasting on from here is wrong."""
SHORTEST_STEP_S = 1e-6
"""Two pictures with one time count as this far apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSettings:
    """How tracks are associated, born and ended.

    Attributes:
        box_noise: errors of the detector's boxes.
        model: what the range filter believes of vehicles, camera and road.
        corridor: the own path.
        minimum_iou: least overlap of a detection with the box predicted for a track.
        maximum_scale_ratio: largest ratio of their widths: more than twice the noise of small boxes, less
            than between a car and the car two places ahead of it.
        confirm_hits: detections before a track is believed; false alarms rarely repeat in place.
        coast_s: a track without a detection for longer than this ends.
        box_smoothing_s: time constant of the filtered box.
        padding_sigmas: boxes are widened by so many sigmas of their noise before overlap is judged: the
            smallest are as large as their noise.
        mount: when a moved mount is said.
        speed_prior: of other vehicles, where the own speed is known.
    """

    box_noise: BoxNoise = field(default_factory=BoxNoise)
    model: RangeModel = field(default_factory=RangeModel)
    corridor: Corridor = field(default_factory=Corridor)
    minimum_iou: float = 0.2
    maximum_scale_ratio: float = 1.5
    confirm_hits: int = 3
    coast_s: float = 0.8
    box_smoothing_s: float = 0.1
    padding_sigmas: float = 2.0
    mount: MountWatchSettings = field(default_factory=MountWatchSettings)
    speed_prior: SpeedPrior = field(default_factory=SpeedPrior)


class Tracker:
    """Follows the vehicles of one drive.

    Args:
        calibration: for the size of the pictures the detections come from.
        settings: see `TrackerSettings`.
    """

    def __init__(self, calibration: Calibration, settings: TrackerSettings | None = None) -> None:
        self._calibration = calibration
        self._settings = settings or TrackerSettings()
        self._range = RangeFilter(calibration, self._settings.box_noise, self._settings.model)
        self._mount = MountWatch(self._range.calibration_sigma_rad, self._settings.mount)
        self._followed: list[_Followed] = []
        self._time_ns: int | None = None
        self._ego_speed_mps: float | None = None
        self._next_id = 1
        self._lead_id: int | None = None

    @property
    def lead_id(self) -> int | None:
        """Id of the lead among the tracks of the last update; None when the own path is free."""
        return self._lead_id

    @property
    def mount(self) -> MountWatch:
        """Whether the camera still looks where it did when it was calibrated, and what to tell if not."""
        return self._mount

    def update(
        self,
        time_ns: int,
        detections: Sequence[Detection],
        ego_speed_mps: float | None = None,
        yaw_rate_radps: float | None = None,
    ) -> tuple[Track, ...]:
        """Take one frame's detections.

        Args:
            time_ns: of the frame; intervals between frames may vary.
            detections: of the frame.
            ego_speed_mps: own speed, which tells oncoming and standing vehicles; None when unknown.
            yaw_rate_radps: how fast we turn, positive to the left, which bends the own path; None when
                unknown, then it is straight.

        Returns:
            The confirmed tracks in the order of their ids, coasting ones among them.

        Raises:
            ValueError: `time_ns` is before the last frame's.
        """
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(f"frame time went back from {self._time_ns} to {time_ns} ns")
        dt_s = 0.0 if self._time_ns is None else (time_ns - self._time_ns) / 1e9
        self._time_ns = time_ns
        oldest_ns = time_ns - round(self._settings.coast_s * 1e9)
        self._keep([followed.last_ns >= oldest_ns for followed in self._followed])
        own_gain_mps = 0.0
        if ego_speed_mps is not None and self._ego_speed_mps is not None:
            own_gain_mps = ego_speed_mps - self._ego_speed_mps
        self._ego_speed_mps = ego_speed_mps
        growths = self._range.predict(dt_s, own_gain_mps)
        for followed, growth in zip(self._followed, growths, strict=True):
            followed.predict(dt_s, growth)
        unused = set(range(len(detections)))
        pairs = self._associate(detections)
        step_s = max(dt_s, SHORTEST_STEP_S)
        self._range.update([(slot, detections[index].box) for slot, index in pairs], step_s)
        self._mount.update(self._rulers(pairs, detections), dt_s)
        for slot, index in pairs:
            self._followed[slot].correct(time_ns, detections[index])
            unused.discard(index)
        for slot, followed in enumerate(self._followed):
            followed.state = self._state(slot)
        self._keep([followed.is_worth_keeping() for followed in self._followed])
        for index in sorted(unused):
            self._start(time_ns, detections[index], ego_speed_mps)
        curvature_per_m = path_curvature_per_m(ego_speed_mps, yaw_rate_radps)
        tracks = tuple(
            followed.track(time_ns, curvature_per_m) for followed in self._followed if followed.confirmed
        )
        lead = select_lead(tracks, ego_speed_mps)
        self._lead_id = lead.track_id if lead else None
        return tracks

    def _rulers(
        self, pairs: Sequence[tuple[int, int]], detections: Sequence[Detection]
    ) -> list[RulerReading]:
        """What the vehicles that are believed say of the mount."""
        readings = []
        for slot, index in pairs:
            followed = self._followed[slot]
            ruler = self._range.ruler(slot, detections[index].box) if followed.confirmed else None
            if ruler is not None:
                readings.append(RulerReading((followed.track_id, self._range.kind(slot)), *ruler))
        return readings

    def _keep(self, worth: Sequence[bool]) -> None:
        """Forget the vehicles that are not worth it; slots of the range filter are places in the list."""
        if not all(worth):
            self._range.keep([slot for slot, keep in enumerate(worth) if keep])
            self._followed = [followed for followed, keep in zip(self._followed, worth, strict=True) if keep]

    def _associate(self, detections: Sequence[Detection]) -> list[tuple[int, int]]:
        """Pairs of least total cost: overlap lost, plus the difference in scale."""
        if not self._followed or not detections:
            return []
        cost = np.array(
            [[self._cost(followed.box, found.box) for found in detections] for followed in self._followed]
        )
        rows, columns = linear_sum_assignment(cost)
        return [
            (row, column)
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
            if cost[row, column] < NEVER
        ]

    def _cost(self, predicted: Box, found: Box) -> float:
        settings = self._settings
        # Small boxes are mostly noise: each is widened by it before their overlap is judged.
        pad = settings.padding_sigmas * settings.box_noise.edge_sigma_px(found)
        width = min(predicted.right, found.right) - max(predicted.x, found.x) + 2 * pad
        height = min(predicted.bottom, found.bottom) - max(predicted.y, found.y) + 2 * pad
        if width <= 0 or height <= 0:
            return NEVER
        shared = width * height
        areas = [(box.w + 2 * pad) * (box.h + 2 * pad) for box in (predicted, found)]
        iou = shared / (sum(areas) - shared)
        log_scale = abs(math.log(found.w / predicted.w))
        limit = math.log(
            settings.maximum_scale_ratio
        ) + settings.padding_sigmas * settings.box_noise.log_width_sigma(found)
        if iou < settings.minimum_iou or log_scale > limit:
            return NEVER
        return 1 - iou + log_scale

    def _state(self, slot: int) -> RangeState:
        """What is believed of a vehicle, with what the own speed says of it."""
        state, prior = self._range.state(slot), self._settings.speed_prior
        if self._ego_speed_mps is None:
            return state
        return with_own_speed(state, self._ego_speed_mps, prior)

    def _start(self, time_ns: int, detection: Detection, ego_speed_mps: float | None) -> None:
        """Begin a track, where the box gives a first distance."""
        if self._range.add(detection.box, ego_speed_mps):
            state = self._state(self._range.count - 1)
            self._followed.append(
                _Followed(self._next_id, time_ns, detection, state, self._calibration, self._settings)
            )
            self._next_id += 1


class _Followed:
    """One vehicle's filters and history."""

    def __init__(
        self,
        track_id: int,
        time_ns: int,
        detection: Detection,
        state: RangeState,
        calibration: Calibration,
        settings: TrackerSettings,
    ) -> None:
        self.box = detection.box
        self.last_ns = time_ns
        self.confirmed = False
        self.track_id = track_id
        self._first_ns = time_ns
        self._score = detection.score
        self.state = state
        self._calibration = calibration
        self._settings = settings
        self._drift_pxps = 0.0
        self._hits = 1
        self._misses = 0
        self._in_path = False

    def predict(self, dt_s: float, growth: float) -> None:
        """Move on by dt; counts as a miss until a detection says otherwise."""
        box, horizon_px = self.box, self._calibration.horizon_row_px
        axis_px = self._calibration.camera.principal_column_px
        # Offsets from the vanishing point grow as the picture of the vehicle does: all go with 1/D.
        bottom = horizon_px + (box.bottom - horizon_px) * growth
        center_x = axis_px + (box.center_x - axis_px) * growth
        self.box = _box(center_x + self._drift_pxps * dt_s, bottom, box.w * growth, box.h * growth)
        self._misses += 1

    def correct(self, time_ns: int, detection: Detection) -> None:
        """Take the detection of this frame."""
        dt_s = max((time_ns - self.last_ns) / 1e9, SHORTEST_STEP_S)
        settings, found, box = self._settings, detection.box, self.box
        self.last_ns = time_ns
        self._score = detection.score
        self._hits += 1
        self._misses -= 1
        # Alpha-beta filter for the column, which drifts when the vehicle moves across the road; its gain is
        # from the time constant, and at first that of a plain mean.
        alpha = max(1 - math.exp(-dt_s / settings.box_smoothing_s), 1 / self._hits)
        shift = found.center_x - box.center_x
        self._drift_pxps += alpha**2 / (2 - alpha) * shift / dt_s
        self.box = _box(
            box.center_x + alpha * shift,
            box.bottom + alpha * (found.bottom - box.bottom),
            box.w + alpha * (found.w - box.w),
            box.h + alpha * (found.h - box.h),
        )
        # At least every second frame: a false alarm that flickers is not confirmed by patience.
        self.confirmed |= self._hits >= settings.confirm_hits and self._hits >= self._misses

    def is_worth_keeping(self) -> bool:
        """Whether it is still ahead and in the picture, and seen more often than missed until confirmed."""
        width, height = self._calibration.image_size.width, self._calibration.image_size.height
        inside = 0 <= self.box.center_x < width and self.box.y < height
        return inside and self.state.distance_m > NEAREST_M and (self.confirmed or self._misses <= self._hits)

    def track(self, time_ns: int, curvature_per_m: float) -> Track:
        """The vehicle as believed now; called once a frame, for the path's hysteresis."""
        state = self.state
        distance_m, low_m, high_m = state.distance_with_interval(self._calibration.reference_offset_m)
        lateral_m, lateral_mps = self._lateral()
        coasting = self.last_ns != time_ns
        if not coasting:
            # Only what is seen comes into the path: a vehicle passed by is not beside its last place.
            # On a bent path what stands still keeps its place beside it, though it sweeps across the picture.
            from_path_m = lateral_m - curvature_per_m * state.distance_m**2 / 2
            from_path_mps = lateral_mps + curvature_per_m * state.distance_m * state.closing_speed_mps
            self._in_path = self._settings.corridor.holds(from_path_m, from_path_mps, self._in_path)
        return Track(
            track_id=self.track_id,
            box=self.box,
            score=self._score,
            distance_m=distance_m,
            distance_low_m=low_m,
            distance_high_m=high_m,
            lateral_m=lateral_m,
            closing_speed_mps=state.closing_speed_mps,
            closing_speed_sigma_mps=state.closing_speed_sigma_mps,
            ttc_s=distance_m / state.closing_speed_mps if state.closing_speed_mps > 0 else None,
            age_s=(time_ns - self._first_ns) / 1e9,
            coasting=coasting,
            in_path=self._in_path,
            closing_acceleration_mps2=state.closing_acceleration_mps2,
            closing_acceleration_sigma_mps2=state.closing_acceleration_sigma_mps2,
            lateral_speed_mps=lateral_mps,
        )

    def _lateral(self) -> tuple[float, float]:
        """Lateral position of the middle of the rear and its rate, positive to the left."""
        camera, distance_m = self._calibration.camera, self.state.distance_m
        metres_per_px = distance_m / camera.focal_y_px
        lateral_m = (camera.principal_column_px - self.box.center_x) * metres_per_px
        inner_px = inner_edge_px(self.box, self._calibration.image_size, self._settings.box_noise)
        if inner_px is not None:
            # The middle of what is left in the picture is nearer to the path than the vehicle's. Its inner
            # edge is whole: that of the far end of its inner side, where the box takes that in.
            side_m = self._settings.model.vehicle_length_m if self._settings.box_noise.shows_side else 0.0
            edge_m = (camera.principal_column_px - inner_px) * (distance_m + side_m) / camera.focal_y_px
            lateral_m = edge_m + math.copysign(self.state.width_m / 2, lateral_m)
        elif self._settings.box_noise.shows_side:
            # What shows beyond the rear's own width is the side that is turned to us.
            side_m = max(self.box.w * metres_per_px - self.state.width_m, 0.0)
            lateral_m += math.copysign(min(side_m / 2, abs(lateral_m)), lateral_m)
        return lateral_m, -self._drift_pxps * metres_per_px


def _box(center_x: float, bottom: float, w: float, h: float) -> Box:
    return Box(center_x - w / 2, bottom - h, w, h)
