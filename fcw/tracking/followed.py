"""One vehicle's box, its history, and the track made of it."""

import math

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.motion.bend.turn import Turn, sweep_mps
from fcw.motion.state import OwnPath
from fcw.tracking.across.bearing_filter import BearingFilter
from fcw.tracking.across.lateral_filter import LateralFilter
from fcw.tracking.association import WHOLE, Edges, completed, cut_as_expected, own_edges, towards
from fcw.tracking.belief.lately import Lately
from fcw.tracking.box_measurement import outwards_m, road_slope
from fcw.tracking.picture.follower import Follower, Moved
from fcw.tracking.range.boxed_part import News
from fcw.tracking.range.state import RangeState
from fcw.tracking.ranging import inner_edge_px
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.types import SeenBy, Track, known_ttc_s

NEAREST_M = 0.5
"""No vehicle ahead comes nearer than this to a camera behind a windscreen. A track that coasts to here is
wrong."""
SHORTEST_STEP_S = 1e-6
"""Two frames with equal times count as this far apart."""


class Followed:
    """One vehicle's box and history.

    Attributes:
        box: its box in the picture; may extend beyond the picture's edges.
        last_ns: when it was last seen, by the detector or in the picture.
        detected_ns: when the detector last saw it.
        confirmed: whether the track is confirmed.
        seen_by: what saw it in the latest frame or, if that was not searched, in the last one that was.
        doubtful: whether it may be no vehicle; see `fcw.tracking.belief`.
        looks: follows its image patch.
        free: edges of its box beyond which it did not continue when it was last searched for; see
            `free_edges`.
    """

    def __init__(
        self,
        track_id: int,
        time_ns: int,
        detection: Detection,
        state: RangeState,
        calibration: Calibration,
        settings: TrackerSettings,
        focal_px: float,
        path: OwnPath,
        turn_radps: float | None,
    ) -> None:
        self.box = detection.box
        self.last_ns = self.detected_ns = time_ns
        self.confirmed = False
        self.seen_by = SeenBy.DETECTOR
        self.looks = Follower(settings.following)
        self.free = WHOLE
        self.track_id = track_id
        self._first_ns = self._time_ns = time_ns
        self._score = detection.score
        self.state = state
        self._calibration = calibration
        self._settings = settings
        self._drift_pxps = 0.0
        self._dt_s = self._search_s = 0.0
        self._searched = True
        self._credit_s = 0.0
        self._feet = self._feet_of(detection.box)
        self._hits = 1
        self._misses = 0
        self._lately = Lately(settings.belief.lately_s)
        self.found_s = 0.0
        """Total time for which the detector found it."""
        self._in_a_row = 0
        """How often it was found in two consecutive frames."""
        self._in_path = False
        self._part_ns: int | None = None
        """Since when only a part of it has been boxed."""
        self.doubtful = False
        self._seen: Box | None = None
        """The box seen in this frame, until the lateral position is updated with it."""
        self._next_m = state.distance_m
        """Predicted distance of its rear at this frame."""
        lateral_m = self._lateral_m(detection.box, focal_px, path, None)
        sigma = settings.box_noise.edge_sigma_px(detection.box) / focal_px
        self._across = LateralFilter(lateral_m, sigma * state.distance_m, self._sweep_mps(turn_radps))
        self._bearing = BearingFilter(lateral_m / state.distance_m, sigma, state.distance_m, turn_radps)
        self._rest: tuple[int, complex] | None = None
        """Since when, and where, it has been stationary in the picture while it was carried."""

    def predict(
        self, time_ns: int, dt_s: float, growth: float, search_s: float | None, turn_radps: float | None
    ) -> None:
        """Predict the vehicle at the time of a frame.

        Args:
            time_ns: time of the frame.
            dt_s: time since the previous frame.
            growth: factor by which the vehicle grew in the picture since then.
            search_s: time since the previous frame that was searched; None if this one is not searched. A
                searched frame counts as a miss until a detection is assigned.
            turn_radps: our yaw rate, positive to the left; None when unknown.
        """
        self._time_ns = time_ns
        box, horizon_px = self.box, self._calibration.horizon_row_px
        axis_px = self._calibration.camera.principal_column_px
        # Offsets from the vanishing point grow as the vehicle's size in the picture does: all go with 1/D.
        bottom = horizon_px + (box.bottom - horizon_px) * growth
        center_x = axis_px + (box.center_x - axis_px) * growth
        self.box = _box(center_x + self._drift_pxps * dt_s, bottom, box.w * growth, box.h * growth)
        self._dt_s = dt_s
        self._searched = search_s is not None
        self._next_m = self.state.distance_m - self.state.closing_speed_mps * dt_s
        self._across.predict(dt_s, self._sweep_mps(turn_radps))
        self._bearing.predict(dt_s, turn_radps, self.state.closing_speed_mps, self.state.distance_m)
        if search_s is not None:
            self._misses += 1
            self._lately.miss(search_s)
            self._search_s = search_s
        if search_s is not None or self.seen_by is SeenBy.PICTURE:
            self.seen_by = SeenBy.COASTING

    def _sweep_mps(self, turn_radps: float | None) -> float | None:
        """Rate at which it seems to move to the left because we turn."""
        return None if turn_radps is None else -turn_radps * self._next_m

    def carry(self, time_ns: int, moved: Moved, we_drive: bool) -> bool:
        """Move its box to where its image patch was followed to; returns False if it cannot be there.

        It counts as seen if the detector saw it for long enough before; see `FollowingSettings.credit`.

        Args:
            time_ns: time of the frame.
            moved: where its image patch was found.
            we_drive: whether we are known to drive. If so, a patch that is stationary in the picture is on
                the windscreen.
        """
        # On a flat road the lower edge goes down as the vehicle grows. A patch that moves otherwise is not
        # its.
        astray_px = moved.box.w * (self._feet_of(moved.box) - self._feet)
        focal_px, following = self._calibration.camera.focal_y_px, self._settings.following
        if abs(astray_px) > focal_px * following.pitch_rad + following.uneven * moved.box.h:
            self.lose()
            return False
        if self._stands_still(time_ns, moved.box) and we_drive:
            self.lose()
            return False
        self._drift(moved.box, self._dt_s)
        self.box = moved.box
        if self._searched:
            self._seen = moved.box
        if self._credit_s > 0 and self.seen_by is SeenBy.COASTING:
            self.seen_by = SeenBy.PICTURE
        return True

    def _stands_still(self, time_ns: int, box: Box) -> bool:
        """Whether it has been carried for `still_s` without moving in the picture."""
        following, middle = self._settings.following, complex(box.center_x, box.y + box.h / 2)
        still_px = following.still_rad * self._calibration.camera.focal_y_px
        if self._rest is None or abs(middle - self._rest[1]) > still_px:
            self._rest = time_ns, middle
        return time_ns - self._rest[0] > following.still_s * 1e9

    def lose(self) -> None:
        """Stop carrying it, as the followed patch is not this vehicle."""
        self.looks.forget()
        if self.seen_by is SeenBy.PICTURE:
            self.seen_by = SeenBy.COASTING

    def view_of(self, time_ns: int, found: Box, free: Edges) -> tuple[Box, Edges]:
        """Box of the whole vehicle in this frame, and which of its edges were seen.

        If the vehicle was seen well a moment ago and only a part of it is boxed now, its width and height are
        kept, for at most `part_s`. After that, the detected box is taken as the vehicle's.

        Args:
            time_ns: time of the frame.
            found: its detected box.
            free: edges beyond which it does not continue; see `free_edges`.
        """
        settings, edges = self._settings, WHOLE
        if self._hits >= settings.part_hits and time_ns - self.detected_ns <= settings.part_s * 1e9:
            size = self._calibration.image_size
            found = cut_as_expected(found, self.box, size, settings.box_noise)
            edges = own_edges(found, self.box, size, settings.box_noise)
        if edges == WHOLE:
            self._part_ns = None
        elif self._part_ns is None:
            self._part_ns = time_ns
        elif time_ns - self._part_ns > settings.part_s * 1e9:
            edges = WHOLE
        return completed(found, self.box, edges), edges.both(free)

    def correct(self, time_ns: int, found: Box, score: float, faint: bool = False) -> None:
        """Update with the box of this frame, see `view_of`, and its score.

        A faint detection tells where the vehicle is, but counts neither for nor against its existence.
        """
        settings, box = self._settings, self.box
        following, dt_s = settings.following, (time_ns - self.last_ns) / 1e9
        carried = self.seen_by == SeenBy.PICTURE
        self.seen_by, self.last_ns, self.detected_ns = SeenBy.DETECTOR, time_ns, time_ns
        self._rest = None
        self._feet = self._feet_of(found)
        self._score = score
        self._seen = found
        self._misses -= 1
        self._lately.find(faint)
        if not faint:
            search_s = self._search_s
            self._credit_s = min(self._credit_s + following.credit * search_s, following.longest_s)
            self._hits += 1
            self.found_s += search_s
            self._in_a_row += dt_s <= search_s + SHORTEST_STEP_S  # sums of intervals are rounded
        if not carried:
            self._drift(found, dt_s)
        self.box = towards(box, found, self._gain(dt_s), self._calibration.image_size, settings.box_noise)
        # A false detection that flickers must not become confirmed just by lasting long enough.
        self.confirmed |= self._hits >= settings.confirm_hits and self._is_seen_often()

    def settle(self, time_ns: int) -> None:
        """End a frame. If the vehicle was carried, the frame uses up credit that detections have given."""
        if self.seen_by == SeenBy.PICTURE:
            self.last_ns = time_ns
            self._credit_s -= self._dt_s

    def _gain(self, dt_s: float) -> float:
        """Gain of an alpha-beta filter, from its time constant; for the first few boxes, that of a mean."""
        return max(1 - math.exp(-dt_s / self._settings.box_smoothing_s), 1 / self._hits)

    def _drift(self, seen: Box, dt_s: float) -> None:
        """Update the rate at which the box drifts sideways because the vehicle moves across the road.

        If the picture's border cuts the vehicle, its visible side is used instead of the middle of the box.
        """
        alpha, size = 1 - math.exp(-dt_s / self._settings.box_smoothing_s), self._calibration.image_size
        shift_px = seen.center_x - self.box.center_x
        if (inner_px := inner_edge_px(seen, size, self._settings.box_noise)) is not None:
            shift_px = inner_px - (self.box.x if inner_px == seen.x else self.box.right)
        self._drift_pxps += alpha**2 / (2 - alpha) * shift_px / max(dt_s, SHORTEST_STEP_S)

    def _feet_of(self, box: Box) -> float:
        """How far below the horizon it stands, in units of its width: independent of the distance."""
        return (box.bottom - self._calibration.horizon_row_px) / box.w

    def is_worth_keeping(self) -> bool:
        """Whether it is still ahead and in the picture and, until confirmed, seen often or recently."""
        width, height = self._calibration.image_size.width, self._calibration.image_size.height
        across = -0.5 <= self.box.center_x <= width - 0.5 or self.seen_by == SeenBy.DETECTOR
        inside = across and self.box.y < height
        recent = (self._time_ns - self.detected_ns) / 1e9 <= self._settings.unconfirmed_s
        may_be = self.confirmed or (recent and self._is_clear()) or self._is_seen_often()
        return inside and self.state.distance_m > NEAREST_M and may_be

    @property
    def found_part(self) -> float:
        """Fraction of its frames in which the detector found it, of those in which it was not faint."""
        return self._hits / (self._hits + self._misses)

    @property
    def found_lately(self) -> float:
        """`found_part` over the last seconds only: a vehicle that was far away for long was rarely found."""
        return self._lately.part

    def _is_seen_often(self) -> bool:
        settings = self._settings
        often = self.found_part >= settings.confirm_part
        in_a_row = self._in_a_row >= settings.confirm_in_a_row
        return self._hits >= self._misses or (often and in_a_row and self._is_clear())

    def _is_clear(self) -> bool:
        """Whether its box is much larger than the noise of its edges."""
        settings = self._settings
        return self.box.h >= settings.clear_sigmas * settings.box_noise.edge_sigma_px(self.box)

    def wants_search(self) -> bool:
        """Whether every frame should be searched, as the vehicle is new or may be reached soon."""
        settings, state = self._settings, self.state
        is_new = (self._time_ns - self._first_ns) / 1e9 < settings.new_s
        is_soon = state.distance_m < settings.soon_s * state.closing_speed_mps
        return (is_new or is_soon) and abs(self._across.lateral_m) < settings.aside_m

    def track(self, time_ns: int, path: OwnPath, turn: Turn | None) -> Track:
        """The track at this frame. To be called once a frame, as `in_path` has hysteresis."""
        state = self.state
        distance_m, low_m, high_m = state.distance_with_interval(self._calibration.reference_offset_m)
        across = self._across
        lateral_m, lateral_mps = across.lateral_m, across.rate_mps
        if self.seen_by != SeenBy.COASTING:
            # A vehicle that coasts cannot enter the path: one that we have passed is not where it was last.
            # Beside a bend, a standing vehicle keeps its place although it sweeps across the picture.
            from_path_m = lateral_m - path.lateral_at(state.distance_m)
            from_path_mps = lateral_mps - sweep_mps(path, turn, state.distance_m, state.closing_speed_mps)
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
            closing_speed_sigma_at_distance_mps=state.closing_speed_sigma_at_distance_mps,
            ttc_s=known_ttc_s(distance_m, state.closing_speed_mps, state.closing_speed_sigma_at_distance_mps),
            age_s=(time_ns - self._first_ns) / 1e9,
            seen_by=self.seen_by,
            in_path=self._in_path,
            closing_acceleration_mps2=state.closing_acceleration_mps2,
            closing_acceleration_sigma_mps2=state.closing_acceleration_sigma_mps2,
            lateral_speed_mps=lateral_mps,
            width_m=state.width_m,
            lateral_sigma_m=math.hypot(across.sigma_m, lateral_m * state.log_across_sigma),
            # At a constant bearing, the lateral position shrinks at the same relative rate as the distance.
            lateral_speed_sigma_mps=math.hypot(
                across.rate_sigma_mps, lateral_m * state.across_rate_sigma_per_s
            ),
            doubtful=self.doubtful,
            found_part=self.found_part,
            lateral_slowing_mps2=across.slowing_mps2,
            lateral_speed_by_bearing_mps=self._bearing.across_mps(
                lateral_m, state.closing_speed_mps, state.distance_m
            ),
            lateral_speed_by_bearing_sigma_mps=self._bearing.across_sigma_mps,
        )

    def place_across(self, focal_px: float, path: OwnPath, news: News) -> None:
        """Update the lateral position with the box of this frame. Called once its distance is known.

        Args:
            focal_px: focal length of the camera.
            path: our own path.
            news: whether another part of the vehicle is boxed now, whose middle is elsewhere without any
                motion.
        """
        self._across.scale(self.state.distance_m / max(self._next_m, NEAREST_M))
        if self._seen is not None:
            noise = self._settings.box_noise
            sigma_px = noise.edge_sigma_px(self._seen) / math.sqrt(2)
            sigma_px *= math.sqrt(noise.white(max(self._search_s, SHORTEST_STEP_S)))
            sigma_m = sigma_px * self.state.distance_m / focal_px
            lateral_m = self._lateral_m(self._seen, focal_px, path, self._across.lateral_m)
            if news is not News.UNSURE:
                displaced = news is News.OTHER
                (self._across.displace if displaced else self._across.correct)(lateral_m, sigma_m)
                bearing, sigma = lateral_m / self.state.distance_m, sigma_m / self.state.distance_m
                (self._bearing.displace if displaced else self._bearing.correct)(bearing, sigma)
            self._seen = None

    def _inner_edge_px(self, box: Box, believed_m: float, metres_per_px: float) -> float | None:
        """Column of the vehicle's inner side if its outer side is expected beyond the picture; else None.

        In that case the outer edge of the box is not the vehicle's.
        """
        axis_px, width = self._calibration.camera.principal_column_px, self._calibration.image_size.width
        half_m = self.state.width_m / 2
        if axis_px - (believed_m + half_m) / metres_per_px < -0.5 and believed_m > half_m:
            return box.right
        if axis_px - (believed_m - half_m) / metres_per_px > width - 0.5 and believed_m < -half_m:
            return box.x
        return None

    def _lateral_m(self, box: Box, focal_px: float, path: OwnPath, believed_m: float | None) -> float:
        """Lateral position of the middle of the rear by a box, positive to the left.

        Args:
            box: its box in the picture.
            focal_px: focal length of the camera.
            path: our own path.
            believed_m: the predicted position; None if there is none.
        """
        camera, distance_m = self._calibration.camera, self.state.distance_m
        metres_per_px = distance_m / focal_px
        lateral_m = (camera.principal_column_px - box.center_x) * metres_per_px
        inner_px = inner_edge_px(box, self._calibration.image_size, self._settings.box_noise)
        if inner_px is None and believed_m is not None:
            inner_px = self._inner_edge_px(box, believed_m, metres_per_px)
        if inner_px is not None:
            # The middle of what is left in the picture is nearer to the path than the vehicle's. Its inner
            # edge is whole: that of the far end of its inner side, where the box takes that in, and that of
            # its rear, where it reaches across the camera's axis.
            outwards = -1.0 if inner_px == box.x else 1.0
            inner = camera.principal_column_px - inner_px
            shows_side = self._settings.box_noise.shows_side and inner * outwards > 0
            side_m = self.state.length_m if shows_side else 0.0
            lateral_m = inner * (distance_m + side_m) / focal_px + outwards * self.state.width_m / 2
        elif self._settings.box_noise.shows_side:
            shown_m, length_m = box.w * metres_per_px, self.state.length_m
            turned_m = lateral_m - road_slope(path, distance_m) * distance_m
            lateral_m += outwards_m(turned_m, shown_m, self.state.width_m, distance_m, length_m)
        return lateral_m


def _box(center_x: float, bottom: float, w: float, h: float) -> Box:
    return Box(center_x - w / 2, bottom - h, w, h)
