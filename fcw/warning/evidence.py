"""What it takes to raise a level for a vehicle, and how long it is held."""

import math
from dataclasses import dataclass, replace

from fcw.threat.threat import Threat, reach_s, surely_grows
from fcw.tracking.types import SeenBy, Track
from fcw.units import KMH_PER_MPS
from fcw.warning.rule import Approach, Rule
from fcw.warning.types import WarningLevel, WarningState


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """What it takes to raise a level, and how long it is held.

    A rule compares the gap either with what the closing speed needs or, as headway does, with what the own
    speed needs (`Rule.by_closing`). Numbers without a source were chosen on the simulated scenarios (NHTSA,
    Euro NCAP, the threats), simulated following, and the episodes of KITTI tracking 0000 to 0010, all of
    `fcw evaluate warning`. No drive was left out, so these are no evidence for the numbers.

    "On course" means that a vehicle will be in our way when we reach it (`is_on_course`); "contact" is that
    moment.

    Attributes:
        minimum_age_s: age from which a track raises rules that use the closing speed. Over its first boxes
            that speed is mostly noise, and every new track is a chance of a false alarm.
        imminent_age_s: the same for a vehicle reached within `imminent_s`, if the detector found it in this
            frame and the next two limits are met. A false box that the picture carries is also reached soon.
        imminent_sigmas: the least closing speed of such a young track, in sigmas.
        imminent_probability: the least probability that such a young track is in our way at contact. It must
            also be in our way now, or cross it, because a newly found object beside a bend seems to come in.
        minimum_lead_s: time for which a vehicle must have been the lead before it raises rules that use the
            own speed. A vehicle that is passed and only partly seen may seem to be in our path for a moment.
        overlap_probability: the least probability of being in our way at contact, for rules that use the
            closing speed.
        lead_probability: the same for the lead. Its lateral motion is not known well when it is far ahead,
            but it is in our path now.
        upon_us_s: a vehicle surely reached within this time and in our way by `upon_us_m` then is on course,
            wherever it is now and whatever our path does: a driver who turns the wheel at that point does so
            because of it. Both numbers were chosen on strangers' clips and KITTI (docs/figures/warning.md,
            "Vehicles about to be reached").
        upon_us_m: see `upon_us_s`; the overlap at contact, by its mean.
        just_before_s: a vehicle in our way by `in_lane_m` and surely reached within `upon_us_s` is on course
            even if it would leave our way up to this long before contact, while our bend does not change: it
            may stop. Traffic conflict studies count post-encroachment times below 1 s. Measured on strangers'
            clips and KITTI (docs/figures/warning.md, "Vehicles that leave our path just before").
        beside_m: a vehicle farther from our path than this is beside us.
        crossing_probability: the least probability of being in our way for a vehicle that comes in from
            beside us, and for every vehicle while our bend changes. A vehicle that comes in counts only if
            our turning is known or if it meets the limits of an imminent vehicle, because everything beside
            the road sweeps across our path while we turn.
        minimum_course_s: time for which a vehicle must have been on course.
        imminent_course_s: the same for a vehicle that comes into a lane whose lines are seen, or comes in
            with `imminent_probability` and is reached within `imminent_s`. Chosen on strangers' clips with
            late warnings (docs/figures/warning.md, "What surely hits us"); 0.1 s gave false episodes on
            KITTI.
        held_probability: a raised level is held while being in our way is at least this probable.
        oncoming_probability: the least probability of being in our way for an oncoming vehicle. In a bend,
            every oncoming vehicle is straight ahead of us for a moment.
        oncoming_reach_s: an oncoming vehicle is warned of when it is reached within this time. Nobody can
            brake off its speed, so no other rule has a threshold for it.
        steering_mps2: a vehicle that is neither the lead nor oncoming, and does not come in, raises no
            `warning` if steering with less than this passes it, and no `caution` if half of this does.
            Drivers steer around parked cars in time (Brannstrom et al. 2010: a threat is what neither braking
            nor steering avoids comfortably).
        in_lane_m: a vehicle that reaches this far into our lane, whose lines are seen, cannot be passed
            comfortably, because we would have to leave the lane. Nor can a vehicle that drives along our path
            and reaches as far into it, now and at contact.
        imminent_s: a vehicle reached within this time is imminent. For the lead, `minimum_course_s` then
            replaces `minimum_lead_s` in rules that use the closing speed.
        closing_sigmas: the least closing speed, in sigmas, for rules that use it. The prior of a new vehicle,
            anything from standing to our own speed, is already 1.7 sigmas before anything is measured.
        upper_sigmas: the gap is too small if it is less than what is needed plus this many sigmas of the
            difference. If the mean decided, every second warning would be late; with 1.65 sigmas, 5 in 100
            are.
        distance_alone: up to this fraction of the gap, its error is independent of the closing speed; the
            rest of the error is shared with it. The least of 0, 0.04, 0.06 and 0.1 that has as many trials of
            `fcw evaluate warning --ncap` in time as independent errors have, 191 of 217; the others have 181,
            185 and 189.
        latest_ttc_s: no rule that uses the closing speed is raised above this TTC. ISO 15623 needs no warning
            above 4 s. But behind a braking lead the hardest preventable scenario of Euro NCAP needs one at
            5.7 s, and when braking begins the tracked closing speed lags by a fifth.
        latest_warning_s: above this time to contact (16th percentile, at a constant closing speed) `warning`
            is lowered to `caution`. ISO 15623's 4 s, plus the lag of the estimate.
        latest_surely_s: if the own speed is unknown, `warning` is also lowered to `caution` while the 84th
            percentile of that time is above this.
        latest_braking_s: behind a braking lead, neither of these two limits counts once the mean time to
            contact is below this, computed as if it keeps braking. That it does is only an assumption.
        earliest_before_s: behind any other vehicle, the level stays at `caution` until this long before the
            rule of `warning` is due by its mean plus one sigma. Uncertainty makes warnings early, but not
            earlier than that.
        caution_first_s: `caution` comes this long before `warning`, if there is more time than
            `caution_first_reach_s`.
        caution_first_reach_s: see `caution_first_s`.
        minimum_due_s: `warning` must have been due for this long if the detector found the vehicle in less
            than `surely_found_part` of its frames. For such a vehicle, a warning that is due for a frame or
            two is mostly noise. Both were chosen on strangers' clips with disturbed boxes
            (docs/figures/clips.md, "How much is chance").
        surely_found_part: see `minimum_due_s`.
        minimum_own_mps: nothing is raised below this own speed, if it is known. At 10 km/h a driver with 1.2
            s and 0.4 g needs 4 m, and cars in a queue creep closer than that.
        release_factor: a raised level is held while its rule's needed gap, times this factor, exceeds the
            gap.
        minimum_duration_s: the least duration of a level. A shorter one, below an alert driver's reaction
            time (0.75 s, Green 2000), could end before it is understood.
        held_below_ttc_s: a raised level is also held while the TTC is below this and does not grow. By ISO
            15623 no warning below 4 s is needless.
        grown_ttc: the TTC counts as grown if it is this many times its shortest since the level was raised.
        lost_s: a raised level is held this long after its vehicle was lost, if the vehicle was in our way and
            has not yet been reached. If it is found again, it is a new track, which must first reach
            `minimum_age_s`.
    """

    minimum_age_s: float = 0.75
    imminent_age_s: float = 0.3
    imminent_sigmas: float = 4.0
    imminent_probability: float = 0.9
    minimum_lead_s: float = 0.6
    overlap_probability: float = 0.5
    lead_probability: float = 0.45
    upon_us_s: float = 1.75
    upon_us_m: float = 0.25
    just_before_s: float = 1.0
    beside_m: float = 0.3
    crossing_probability: float = 0.8
    minimum_course_s: float = 0.3
    imminent_course_s: float = 0.2
    held_probability: float = 0.25
    oncoming_probability: float = 0.8
    oncoming_reach_s: float = 2.5
    steering_mps2: float = 1.0
    in_lane_m: float = 0.3
    imminent_s: float = 2.0
    closing_sigmas: float = 3.0
    upper_sigmas: float = 1.65
    distance_alone: float = 0.1
    latest_ttc_s: float = 7.0
    latest_warning_s: float = 4.3
    latest_surely_s: float = 4.8
    latest_braking_s: float = 3.7
    earliest_before_s: float = 0.8
    caution_first_s: float = 0.3
    caution_first_reach_s: float = 3.8
    minimum_due_s: float = 0.15
    surely_found_part: float = 0.85
    minimum_own_mps: float = 10 / KMH_PER_MPS
    release_factor: float = 1.25
    minimum_duration_s: float = 1.0
    held_below_ttc_s: float = 4.0
    grown_ttc: float = 1.1
    lost_s: float = 1.0

    def approach(self, vehicle: Track, own_mps: float | None, holding: bool) -> Approach:
        """The vehicle's motion relative to us, by the mean of each estimate."""
        growth_mps2 = vehicle.closing_acceleration_mps2
        brakes = holding or surely_grows(vehicle)
        return Approach(
            closing_mps=vehicle.closing_speed_mps,
            acceleration_mps2=growth_mps2 if brakes else min(growth_mps2, 0.0),
            own_mps=own_mps,
        )

    def is_on_course(self, threat: Threat, holding: bool, was_on_course: bool = False) -> bool:
        """Whether the vehicle will be in our way when we reach it.

        Args:
            threat: the vehicle.
            holding: whether it is warned of.
            was_on_course: whether it was on course in the previous frame. Lateral speed is known only to a
                few tenths of a metre per second, so a vehicle that comes in need not prove it again in every
                frame.
        """
        if threat.is_oncoming:
            if holding:
                return threat.reach_s is not None and threat.overlap_probability >= self.held_probability
            near = threat.reach_s is not None and threat.reach_s <= self.oncoming_reach_s
            return near and threat.overlap_probability >= self.oncoming_probability
        if self.is_upon_us(threat) or self.leaves_late(threat):
            return True
        if threat.is_lead and not threat.bend_changes:
            least = self.held_probability if holding else self.lead_probability
            return threat.overlap_m > 0 or threat.overlap_probability >= least
        is_beside = threat.overlap_now_m < -self.beside_m
        comes = is_beside and not (holding or was_on_course)
        if comes and not (threat.comes_in and (threat.turn_known or self._surely_hits_soon(threat))):
            return False
        least = self.crossing_probability if comes or threat.bend_changes else self.overlap_probability
        least = self.held_probability if holding else least
        return threat.overlap_probability >= least

    def may_steer(self, threat: Threat, level: WarningLevel) -> bool:
        """Whether a driver can pass the vehicle, which is not the lead, by steering a little."""
        # If no lane lines are seen, it may be parked beside our lane, our bend may pass it, or it may leave.
        stays = threat.drives and threat.overlap_m >= self.in_lane_m and not threat.bend_changes
        in_lane = (threat.lane_seen or stays) and threat.overlap_now_m >= self.in_lane_m
        ahead = threat.is_lead or threat.is_oncoming or threat.comes_in or in_lane
        if ahead or threat.required_lateral_mps2 is None:
            return False
        least_mps2 = self.steering_mps2 * (1.0 if level == WarningLevel.WARNING else 0.5)
        return threat.required_lateral_mps2 < least_mps2

    def course_evidence_s(self, threat: Threat) -> float:
        """How long the vehicle must have been on course."""
        soon = threat.comes_in and (threat.lane_seen or self._surely_hits_soon(threat))
        return self.imminent_course_s if soon else self.minimum_course_s

    def _surely_hits_soon(self, threat: Threat) -> bool:
        return self.is_imminent(threat) and threat.overlap_probability >= self.imminent_probability

    def lead_evidence_s(self, threat: Threat) -> float:
        """How long the lead must have been the lead before it raises a rule that uses the closing speed."""
        return self.minimum_course_s if self.is_imminent(threat) else self.minimum_lead_s

    def is_imminent(self, threat: Threat) -> bool:
        """Whether the vehicle is reached too soon to wait for more evidence."""
        return threat.reach_s is not None and threat.reach_s <= self.imminent_s

    def is_upon_us(self, threat: Threat) -> bool:
        """Whether we surely hit it within a moment if nobody acts."""
        soon = threat.reach_high_s is not None and threat.reach_high_s <= self.upon_us_s
        return soon and threat.overlap_m >= self.upon_us_m

    def leaves_late(self, threat: Threat) -> bool:
        """Whether it is in our way now, is reached within a moment, and would leave only just before that."""
        soon = threat.reach_high_s is not None and threat.reach_high_s <= self.upon_us_s
        in_our_way = threat.overlap_now_m >= self.in_lane_m and not threat.bend_changes
        return soon and in_our_way and threat.clear_s is not None and threat.clear_s <= self.just_before_s

    def is_too_early(self, threat: Threat, rule: Rule, own_mps: float | None) -> bool:
        """Whether it is too early for a `warning` of this vehicle.

        Times to contact are computed at the present closing speed. It is never too early for a lead that
        brakes so hard that it is reached soon. Any other braking lead is warned of no later than one that
        keeps its speed.
        """
        vehicle, growth_mps2 = threat.track, threat.track.closing_acceleration_mps2
        if surely_grows(vehicle) and threat.reach_s is not None and threat.reach_s <= self.latest_braking_s:
            return False
        now = Approach(
            closing_mps=vehicle.closing_speed_mps, acceleration_mps2=min(growth_mps2, 0.0), own_mps=own_mps
        )
        distance_m, sigma_mps = vehicle.distance_m, vehicle.approach_sigma_mps
        low_s = reach_s(distance_m, now.closing_mps + sigma_mps, 0.0)
        high_s = reach_s(distance_m, now.closing_mps - sigma_mps, 0.0)
        soon_m = distance_m - self.earliest_before_s * now.closing_mps
        due_m = rule.needed_distance_m(now, holding=False) + self._spread_m(rule, vehicle, now, holding=False)
        return (
            low_s is None
            or low_s > self.latest_warning_s
            or (own_mps is None and (high_s is None or high_s > self.latest_surely_s))
            or soon_m > due_m
        )

    def has_time(self, threat: Threat) -> bool:
        """Whether there is time for `caution` before `warning`."""
        return threat.reach_low_s is None or threat.reach_low_s > self.caution_first_reach_s

    def was_in_our_way(self, lost: WarningState) -> bool:
        """Whether a lost vehicle, extrapolated to now, is still ahead of us and would be hit."""
        soon = lost.ttc_s is not None and 0 < lost.ttc_s < self.held_below_ttc_s
        return soon and lost.overlap_m is not None and lost.overlap_m > 0

    def due_evidence_s(self, vehicle: Track) -> float:
        """How long `warning` must have been due."""
        return self.minimum_due_s if vehicle.found_part < self.surely_found_part else 0.0

    def is_seen(self, vehicle: Track, own_mps: float | None) -> bool:
        """Whether the vehicle may raise any level at all."""
        creeps = own_mps is not None and own_mps < self.minimum_own_mps
        return not (vehicle.coasting or vehicle.doubtful or creeps)

    def surely_closes(self, threat: Threat) -> bool:
        """Whether the vehicle may raise rules that use the closing speed."""
        vehicle = threat.track
        least_s, sigmas = self.minimum_age_s, self.closing_sigmas
        ahead = threat.overlap_now_m > 0 or (threat.crosses and threat.comes_in)
        ahead &= threat.overlap_probability >= self.imminent_probability
        found = vehicle.seen_by is SeenBy.DETECTOR
        if vehicle.age_s < least_s and self.is_imminent(threat) and ahead and found:
            least_s, sigmas = self.imminent_age_s, self.imminent_sigmas
        closing_mps = vehicle.closing_speed_mps
        return (
            vehicle.age_s >= least_s
            and closing_mps > sigmas * vehicle.approach_sigma_mps
            and vehicle.distance_m <= closing_mps * self.latest_ttc_s
        )

    def due_below_m(self, rule: Rule, vehicle: Track, own_mps: float | None, holding: bool) -> float:
        """The gap below which the level is due, with a margin for its uncertainty."""
        now = self.approach(vehicle, own_mps, holding)
        needed_m = rule.needed_distance_m(now, holding)
        if rule.by_closing and needed_m > 0:
            needed_m += self.upper_sigmas * self._spread_m(rule, vehicle, now, holding)
        return needed_m * (self.release_factor if holding else 1.0)

    def _spread_m(self, rule: Rule, vehicle: Track, now: Approach, holding: bool) -> float:
        """1-sigma of the gap minus the needed gap, to first order.

        An error of the camera's scale changes the closing speed as much as the gap: if both are smaller, so
        is the needed gap.
        """
        error_m = vehicle.distance_m - vehicle.distance_low_m
        alone_m = min(error_m, self.distance_alone * vehicle.distance_m)
        shared_m = math.sqrt(error_m**2 - alone_m**2)
        fast_mps = now.closing_mps + vehicle.approach_sigma_mps
        if now.own_mps is not None:
            # The vehicle does not drive backwards.
            fast_mps = max(min(fast_mps, now.own_mps), now.closing_mps)
        needed_m = rule.needed_distance_m(now, holding)
        if math.isinf(needed_m):
            return 0.0
        # A step upwards, because for a smaller closing speed a rule may not apply at all.
        larger = now
        if vehicle.distance_m > 0:
            larger = replace(now, closing_mps=now.closing_mps * (1 + shared_m / vehicle.distance_m))
        spreads_m = [
            alone_m,
            shared_m - (rule.needed_distance_m(larger, holding) - needed_m),
            rule.needed_distance_m(replace(now, closing_mps=fast_mps), holding) - needed_m,
        ]
        if now.acceleration_mps2 > 0:
            growth_mps2 = now.acceleration_mps2 + vehicle.closing_acceleration_sigma_mps2
            grown = replace(now, acceleration_mps2=growth_mps2)
            spreads_m.append(rule.needed_distance_m(grown, holding) - needed_m)
        return math.hypot(*spreads_m)
