"""The threat of one vehicle: when we reach it, whether it is in our way then, and what avoids it.

After Brannstrom, Coelingh & Sjoberg 2010, "Model-based threat assessment for avoiding arbitrary vehicle
collisions" (braking and steering needed), and Lefevre, Vasquez & Laugier 2014, "A survey on motion prediction
and risk assessment for intelligent vehicles" (the probability of a collision if nobody acts).

The constants below were chosen and tried on KITTI tracking 0000 to 0010 and the simulated scenarios. No drive
was left out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fcw.motion.bend.turn import Turn
from fcw.motion.state import OwnPath
from fcw.threat.course import place_at_contact
from fcw.tracking.box_measurement import ACROSS_M, visible_side_m
from fcw.tracking.lead import drives_along, is_oncoming, may_come_towards_us
from fcw.tracking.range.model import REARS
from fcw.tracking.types import Track

OWN_WIDTH_M = 1.8
"""Width of our car without its mirrors."""
WIDEST_CAR_M = 1.8
"""A car that looks wider than this is seen from a corner, unless it crosses our path or stands across it.
Lorries are exempt: they are taller than wide, or nearly so."""
CAR = REARS[0]
"""A passenger car as the range filter models it. The visible width of a crossing car follows from its box."""
ALONG_MPS = 2.0
"""A vehicle that moves faster than this along the road does not stand across it."""
LORRY_ASPECT = 0.85
STEADY_BEND_MPS2 = 0.2
"""A bend is steady if it is known to this lateral acceleration (1-sigma)."""
STEADY_BEND_M = 0.2
"""It is also steady if the lateral position of our path at the vehicle is known to this (1-sigma). The
largest of 0.1, 0.2 and 0.3 that adds no episode on KITTI tracking, 14 seeds; with 0010 left out all three are
equal."""
PASSING_ROOM_M = 0.3
"""Room that a driver leaves when steering past a vehicle."""
SHORTEST_S = 0.01
HORIZON_S = 7.0
"""Nobody can predict a collision that is farther away in time."""
SURE_GROWTH_MPS2 = 1.0
"""A closing speed that grows more slowly counts as constant: the lead may only have lifted its foot."""
YOUNG_S = 2.0
YOUNG_GROWTH_SIGMAS = 1.5
"""Up to the age of `YOUNG_S`, a closing speed must grow by this many sigmas to count as growing. In that time
the filter corrects its first errors, which looks like braking. `YOUNG_S` was chosen on one simulated scenario
(`near-pass`, from pictures); 3 s gives the same on KITTI's drives and in all scenarios from boxes. Required
at any age, it would delay warnings of a lead that brakes gently."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Threat:
    """One vehicle as a threat, as estimated at a frame. "Then" means when we reach its rear.

    Attributes:
        track: the vehicle.
        is_lead: whether it is the lead, which headway is about.
        is_oncoming: whether it surely comes towards us.
        reach_s: time until then, if the closing speed keeps growing as it does now; None when the gap does
            not close.
        reach_low_s: 16th percentile of `reach_s`; None when the gap does not close.
        reach_high_s: 84th percentile of `reach_s`; inf if we may never reach it, None when the gap does not
            close.
        offset_m: distance of its middle from the middle of our path then, positive to the left.
        offset_sigma_m: 1-sigma of `offset_m`.
        comes_in: whether it surely moves towards the middle of our path.
        crosses: whether it surely moves across our path faster than anyone changes lane.
        turn_known: whether our turning is known. If it is not, a vehicle that stands beside a bend may seem
            to come in.
        bend_changes: whether the curvature of our path at the vehicle is poorly known: while we steer into a
            bend or out of one, turn at an unknown speed, or drive through a bend whose lane lines are not
            seen, so that it may end. A vehicle that is in our way now will mostly not be in it then.
        lane_seen: whether the lane lines of our lane are seen, which tell whether a vehicle is in it.
        overlap_now_m: how far its width and ours overlap where it is now; if negative, the room between them.
        overlap_m: how far they overlap then; if negative, the room between them.
        clear_s: how long before then a vehicle that is in our way now will have left it: the
            post-encroachment time (Allen, Shin & Cooper 1978); 0 if it will not have left. None if it is not
            in our way now, if the gap does not close, and if a vehicle that leaves may be oncoming, which
            shortens that time.
        overlap_probability: probability that the two widths overlap then.
        collision_probability: probability that we hit it within `HORIZON_S` if nobody acts.
        required_deceleration_mps2: constant braking from now on that just avoids the collision; None when the
            gap does not close.
        required_lateral_mps2: constant lateral acceleration that steers past it with `PASSING_ROOM_M` to
            spare; 0 if there is room anyway, None when the gap does not close.
        drives: whether it surely drives along the road in our direction.
    """

    track: Track
    is_lead: bool
    is_oncoming: bool
    reach_s: float | None
    reach_low_s: float | None
    reach_high_s: float | None
    offset_m: float
    offset_sigma_m: float
    comes_in: bool
    crosses: bool
    turn_known: bool
    bend_changes: bool
    lane_seen: bool
    overlap_now_m: float
    overlap_m: float
    clear_s: float | None
    overlap_probability: float
    collision_probability: float
    required_deceleration_mps2: float | None
    required_lateral_mps2: float | None
    drives: bool

    @property
    def urgency(self) -> float:
        """Required deceleration times the probability of a collision; threats are sorted by it."""
        return self.collision_probability * min(self.required_deceleration_mps2 or 0.0, 100.0)


def assess(
    tracks: Sequence[Track],
    lead_id: int | None,
    path: OwnPath,
    own_mps: float | None,
    reference_offset_m: float = 0.0,
    turn: Turn | None = None,
    own_sigma_mps: float | None = None,
) -> tuple[Threat, ...]:
    """Assess all vehicles: the most urgent threat first, doubtful vehicles last.

    Args:
        tracks: all tracks of one frame.
        lead_id: which of them is the lead; None when the own path is free.
        path: our own path.
        own_mps: own speed; None when unknown.
        reference_offset_m: how far the point from which distances are measured is ahead of the camera.
        turn: our turning now; None when unknown, in which case we are assumed to follow the path's bend.
        own_sigma_mps: 1-sigma of the own speed if it was measured; None or 0 if it was given.
    """
    threats = [
        _assess_one(
            track,
            track.track_id == lead_id,
            is_oncoming(track, own_mps, own_sigma_mps),
            drives_along(track, own_mps, own_sigma_mps),
            path,
            reference_offset_m,
            turn,
            own_mps,
        )
        for track in tracks
    ]
    threats.sort(key=lambda threat: (threat.track.doubtful, -threat.urgency, threat.track.distance_m))
    return tuple(threats)


def reach_s(distance_m: float, closing_mps: float, growth_mps2: float) -> float | None:
    """Time to cover a distance if the closing speed keeps growing as it does now (ISO 15623's ETTC).

    A shrinking closing speed counts as constant, as a driver who brakes may stop braking. None when the gap
    does not close.
    """
    if closing_mps <= 0:
        return None
    # The solution of d = v t + a t^2 / 2, in a form that is also valid for a = 0.
    return 2 * distance_m / (closing_mps + math.sqrt(closing_mps**2 + 2 * max(growth_mps2, 0.0) * distance_m))


def surely_grows(track: Track) -> bool:
    """Whether a vehicle's closing speed surely grows, as it does behind a braking lead."""
    growth_mps2 = track.closing_acceleration_mps2
    least_mps2 = 0.0
    if track.age_s < YOUNG_S:
        least_mps2 = YOUNG_GROWTH_SIGMAS * track.closing_acceleration_sigma_mps2
    return growth_mps2 >= max(SURE_GROWTH_MPS2, least_mps2)


def required_deceleration_mps2(distance_m: float, closing_speed_mps: float) -> float | None:
    """Constant braking from now on that just avoids the collision: v^2 / (2 d); None when not closing.

    ISO 15623's required deceleration with a lead at constant speed and no system delay; inf at contact.
    """
    if closing_speed_mps <= 0:
        return None
    if distance_m <= 0:
        return math.inf
    return closing_speed_mps * closing_speed_mps / (2 * distance_m)  # `**` raises on overflow; this gives inf


def _assess_one(
    track: Track,
    is_lead: bool,
    comes_towards_us: bool,
    drives: bool,
    path: OwnPath,
    reference_offset_m: float,
    turn: Turn | None,
    own_mps: float | None,
) -> Threat:
    closing_mps, sigma_mps = track.closing_speed_mps, track.approach_sigma_mps
    growth_mps2 = track.closing_acceleration_mps2 if surely_grows(track) else 0.0
    time_s = reach_s(track.distance_m, closing_mps, growth_mps2)
    low_s = high_s = None
    if time_s is not None:
        low_s = reach_s(track.distance_m, closing_mps + sigma_mps, growth_mps2)
        slow_s = reach_s(track.distance_m, closing_mps - sigma_mps, growth_mps2)
        high_s = math.inf if slow_s is None else slow_s
    contact_s = HORIZON_S if time_s is None else min(time_s, HORIZON_S)
    place = place_at_contact(track, path, reference_offset_m, contact_s, turn, comes_towards_us, own_mps)
    is_tall = track.box.h > LORRY_ASPECT * track.box.w
    width_m = track.width_m if is_tall else min(track.width_m, WIDEST_CAR_M)
    if place.crosses or _is_across(track, own_mps):
        width_m = max(track.width_m, CAR.height_m * track.box.w / track.box.h)
    in_the_way_m = (OWN_WIDTH_M + width_m) / 2
    x_m = track.distance_m + reference_offset_m
    overlap_m = in_the_way_m - abs(place.offset_m)
    now_m = track.lateral_m - path.lateral_at(x_m)
    clear_s = None
    leaves = now_m * (place.offset_m - now_m) > 0
    if time_s is not None and not (leaves and may_come_towards_us(track, own_mps)):
        clear_s = _clear_s(now_m, place.offset_m, in_the_way_m, contact_s)
    reached = _probability_above(closing_mps, track.distance_m / HORIZON_S, sigma_mps)
    in_the_way = _probability_between(-in_the_way_m, in_the_way_m, place.offset_m, place.sigma_m)
    lateral_mps2 = None
    if time_s is not None:
        lateral_mps2 = 2 * max(overlap_m + PASSING_ROOM_M, 0.0) / min(max(time_s, SHORTEST_S), HORIZON_S) ** 2
    return Threat(
        track=track,
        is_lead=is_lead,
        is_oncoming=comes_towards_us,
        reach_s=time_s,
        reach_low_s=low_s,
        reach_high_s=high_s,
        offset_m=place.offset_m,
        offset_sigma_m=place.sigma_m,
        comes_in=place.comes_in,
        crosses=place.crosses,
        turn_known=turn is not None,
        bend_changes=turn is not None and _bend_changes(path, turn.own_mps, x_m),
        lane_seen=path.lane_width_m is not None,
        overlap_now_m=in_the_way_m - abs(now_m),
        overlap_m=overlap_m,
        clear_s=clear_s,
        overlap_probability=in_the_way,
        collision_probability=reached * in_the_way,
        required_deceleration_mps2=required_deceleration_mps2(track.distance_m, closing_mps),
        required_lateral_mps2=lateral_mps2,
        drives=drives,
    )


def _is_across(track: Track, own_mps: float | None) -> bool:
    """Whether it stands across the road, or crosses it slowly, so that its side is seen.

    Such a vehicle does not move along the road, and looks wider than any car that points along it. If the own
    speed is unknown, no vehicle counts as such: cars that turn off ahead of us look just as wide.
    """
    if own_mps is None or abs(own_mps - track.closing_speed_mps) > ALONG_MPS:
        return False
    seen_m = min(track.width_m, CAR.height_m * track.box.w / track.box.h)
    outer_m = abs(track.lateral_m) + seen_m / 2
    side_m = visible_side_m(outer_m, WIDEST_CAR_M, track.distance_m, CAR.length_m)
    return seen_m > WIDEST_CAR_M + side_m + ACROSS_M


def _clear_s(now_m: float, then_m: float, in_the_way_m: float, contact_s: float) -> float | None:
    """See `Threat.clear_s`."""
    if abs(now_m) > in_the_way_m:
        return None
    if abs(then_m) <= in_the_way_m:
        return 0.0
    return contact_s * (abs(then_m) - in_the_way_m) / abs(then_m - now_m)


def _bend_changes(path: OwnPath, own_mps: float, distance_m: float) -> bool:
    sigma_per_m = path.curvature_sigma_per_m
    return sigma_per_m * own_mps**2 > STEADY_BEND_MPS2 and sigma_per_m * distance_m**2 / 2 > STEADY_BEND_M


def _probability_above(mean: float, limit: float, sigma: float) -> float:
    return _normal((mean - limit) / sigma) if sigma > 0 else float(mean > limit)


def _probability_between(low: float, high: float, mean: float, sigma: float) -> float:
    if sigma <= 0:
        return float(low < mean < high)
    return _normal((high - mean) / sigma) - _normal((low - mean) / sigma)


def _normal(z: float) -> float:
    """The cumulative standard normal distribution at z."""
    return 0.5 * math.erfc(-z / math.sqrt(2))
