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

    Where no source is named a number was chosen on the simulated scenarios (NHTSA's, Euro NCAP's, the
    threats), simulated following and the episodes of KITTI tracking 0000 to 0010 (all of
    `fcw evaluate warning`); nothing was left out, so that these are no evidence for it.

    Attributes:
        minimum_age_s: a younger track raises no rule that goes by the closing speed: that of its first few
            boxes is mostly their noise, and every new track is a chance of a false alarm.
        imminent_age_s: the same for what is reached within `imminent_s`, and found in this very frame: a
            false box that the picture carries is reached soon, too;
        imminent_sigmas: where its closing speed is so many of its sigmas,
        imminent_probability: and it is in our way now, or surely crosses it, and will be with this
            probability: who stands beside a bend and was just found seems to come in.
        minimum_lead_s: a vehicle that has been the lead for less raises no rule that goes by the own speed:
            one that is passed by, and seen in part, may seem to be in the path for a moment.
        overlap_probability: what goes by the closing speed is raised where the vehicle will probably be in
            our way.
        lead_probability: of the lead it is enough that this is so likely; far away its way across is not
            known well, but it is in the path now.
        upon_us_s: what is surely reached within this time,
        upon_us_m: and by its mean so far in our way then, is on course, wherever it is now and whatever our
            path does: who turns the wheel then does so because of it. Chosen on strangers' clips and KITTI's
            drives (docs/figures/warning.md, "Upon us").
        just_before_s: what is in our way now by `in_lane_m`, is surely reached within `upon_us_s` and would
            have left for less than this time then, is on course while our bend does not change: who crosses
            in front of us, or leaves our lane, may stop. Studies of traffic conflicts count post-encroachment
            times below 1 s. Measured on strangers' clips and KITTI's drives (docs/figures/warning.md, "Gone
            just before").
        beside_m: with more room than this between it and our path now,
        crossing_probability: it must be so likely, and the bend of our path known: from a car that turns, all
            that stands beside the road sweeps across the path. Where the bend is unknown, it must be as
            likely, and as near, as what is imminent.
        minimum_course_s: and would have been for so long,
        imminent_course_s: or so long where it comes into a lane whose lines are seen, or comes in with
            `imminent_probability` and is reached within `imminent_s`. Chosen on strangers' clips that were
            warned of late (docs/figures/warning.md, "What surely hits us"); 0.1 s brought false episodes on
            KITTI's drives, 0.2 s none.
        held_probability: a raised level is held while that is at least so likely.
        oncoming_probability: what comes towards us is warned of where that is so likely: in a bend
            every oncoming vehicle is ahead of us for a moment.
        oncoming_reach_s: and so near in time. Nobody can brake off its speed, so that no rule has another
            threshold for it.
        steering_mps2: who does not come in, and is passed by steering with less than this, is not warned of
            while not the lead, and with half of it not by `caution`: a driver on the way past a parked car
            steers in time, and would be warned of every one of them (Brannstrom et al. 2010: a threat is what
            neither braking nor steering avoids any more at ease).
        in_lane_m: what reaches so far into our path, in a lane whose lines are seen, is not passed at ease:
            for that the lane has to be left.
        imminent_s: where it is reached within this time, a lead needs no longer than who comes in does: what
            is found late, and near, leaves no time.
        closing_sigmas: a closing speed below so many of its sigmas raises no rule that goes by it: it may be
            noise, and of a vehicle just found the tracker believes something between standing and as fast as
            we are, which is 1.7 sigmas of closing speed before anything is measured.
        upper_sigmas: a level is raised when the gap may be too small: when it is smaller than what is needed
            and so many sigmas of the difference. A warning that goes by the mean comes too late every second
            time; with 1.65 sigmas it does so in 5 of 100.
        distance_alone: so much of the gap's error, as a part of the gap, is its alone, and what is more the
            closing speed shares. Of 0, 0.04 and 0.06 the one with which as many of Euro NCAP's trials are
            warned of in time as when all errors counted as independent of one another.
        latest_ttc_s: above this TTC nothing is raised that goes by the closing speed. ISO 15623 needs no
            warning above 4 s; but behind a lead that brakes a driver must be warned before, at 5.7 s in the
            hardest of Euro NCAP's scenarios that can be prevented, and while braking begins the tracker's
            closing speed lags by a fifth.
        latest_warning_s: above this time to its rear, in which a lead that brakes goes on doing so, there is
            `caution` in the place of `warning`: ISO 15623's 4 s and what it lags.
        latest_surely_s: where the own speed is unknown, and a closing speed little known for long, there is
            `caution` as long as that time may well be more than this: its 84th percentile.
        latest_braking_s: the same by the mean behind a lead that brakes: that it goes on is only assumed.
        earliest_before_s: behind any other vehicle there is `caution` until so long before the rule of
            `warning` is due but for one sigma: what is uncertain makes it come early, but no earlier.
        caution_first_s: so long `caution` comes before `warning`,
        caution_first_reach_s: where there is more than this time.
        minimum_due_s: `warning` must be due for so long,
        surely_found_part: where the detector found the vehicle in a smaller part of its frames: what is due
            for a frame or two is mostly noise then. Both were chosen on strangers' clips whose boxes were
            disturbed (docs/figures/clips.md, "How much is chance").
        minimum_own_mps: below this own speed, where known, nothing is raised: at 10 km/h a driver of 1.2 s
            and 0.4 g needs 4 m, and queues creep nearer than that.
        release_factor: a raised level is held while its rule holds for a gap wider by this.
        minimum_duration_s: and at least so long: shorter than a driver's expected reaction (0.75 s, Green
            2000) it could be gone before it is understood.
        held_below_ttc_s: and as long as the time to contact is below this and does not grow: below 4 s no
            warning is needless by ISO 15623.
        grown_ttc: it grows when it is so many times the shortest since the level was raised.
        lost_s: a raised level is held so long after its vehicle is followed no more, if that was in our way
            and we have not reached it yet: found again it is another one, that has to be seen for
            `minimum_age_s` first.
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
        """The vehicle by its means."""
        growth_mps2 = vehicle.closing_acceleration_mps2
        brakes = holding or surely_grows(vehicle)
        return Approach(
            closing_mps=vehicle.closing_speed_mps,
            acceleration_mps2=growth_mps2 if brakes else min(growth_mps2, 0.0),
            own_mps=own_mps,
        )

    def is_on_course(self, threat: Threat, holding: bool, was_on_course: bool = False) -> bool:
        """Whether it will be in our way.

        Args:
            threat: the vehicle.
            holding: whether it is warned of.
            was_on_course: whether it was in the frame before: the rate at which it comes in is known to a few
                tenths of a metre a second, and less sure for a frame it is not another vehicle.
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
        """Whether a driver passes a vehicle that is not the lead by steering a little."""
        in_lane = threat.lane_seen and threat.overlap_now_m >= self.in_lane_m
        ahead = threat.is_lead or threat.is_oncoming or threat.comes_in or in_lane
        if ahead or threat.required_lateral_mps2 is None:
            return False
        least_mps2 = self.steering_mps2 * (1.0 if level == WarningLevel.WARNING else 0.5)
        return threat.required_lateral_mps2 < least_mps2

    def course_evidence_s(self, threat: Threat) -> float:
        """For how long it must have been on a collision course."""
        soon = threat.comes_in and (threat.lane_seen or self._surely_hits_soon(threat))
        return self.imminent_course_s if soon else self.minimum_course_s

    def _surely_hits_soon(self, threat: Threat) -> bool:
        return self.is_imminent(threat) and threat.overlap_probability >= self.imminent_probability

    def lead_evidence_s(self, threat: Threat) -> float:
        """For how long a lead must have been one before a rule that goes by the closing speed is raised."""
        return self.minimum_course_s if self.is_imminent(threat) else self.minimum_lead_s

    def is_imminent(self, threat: Threat) -> bool:
        """Whether there is no time to see more of it."""
        return threat.reach_s is not None and threat.reach_s <= self.imminent_s

    def is_upon_us(self, threat: Threat) -> bool:
        """Whether it surely hits us within a moment if nobody acts."""
        soon = threat.reach_high_s is not None and threat.reach_high_s <= self.upon_us_s
        return soon and threat.overlap_m >= self.upon_us_m

    def leaves_late(self, threat: Threat) -> bool:
        """Whether it is in our way now, is reached within a moment, and would have left only just before."""
        soon = threat.reach_high_s is not None and threat.reach_high_s <= self.upon_us_s
        in_our_way = threat.overlap_now_m >= self.in_lane_m and not threat.bend_changes
        return soon and in_our_way and threat.clear_s is not None and threat.clear_s <= self.just_before_s

    def is_too_early(self, threat: Threat, rule: Rule, own_mps: float | None) -> bool:
        """Whether nobody needs a `warning` yet.

        A lead that brakes goes on doing so in the time to its rear: what would be early, if it does not.
        And it is warned of no later than one that keeps its speed.
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
            or (own_mps is None and (high_s or math.inf) > self.latest_surely_s)
            or soon_m > due_m
        )

    def has_time(self, threat: Threat) -> bool:
        """Whether there is time for `caution` before `warning`."""
        return threat.reach_low_s is None or threat.reach_low_s > self.caution_first_reach_s

    def was_in_our_way(self, lost: WarningState) -> bool:
        """Whether a vehicle that is followed no more, extrapolated to now, is ahead of us and will be hit."""
        soon = lost.ttc_s is not None and 0 < lost.ttc_s < self.held_below_ttc_s
        return soon and lost.overlap_m is not None and lost.overlap_m > 0

    def due_evidence_s(self, vehicle: Track) -> float:
        """For how long `warning` must have been due."""
        return self.minimum_due_s if vehicle.found_part < self.surely_found_part else 0.0

    def is_seen(self, vehicle: Track, own_mps: float | None) -> bool:
        """Whether it may raise anything."""
        creeps = own_mps is not None and own_mps < self.minimum_own_mps
        return not (vehicle.coasting or vehicle.doubtful or creeps)

    def surely_closes(self, threat: Threat) -> bool:
        """Whether it may raise what goes by the closing speed."""
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
        """The gap from which on the level is due, with what is uncertain in it."""
        now = self.approach(vehicle, own_mps, holding)
        needed_m = rule.needed_distance_m(now, holding)
        if rule.by_closing and needed_m > 0:
            needed_m += self.upper_sigmas * self._spread_m(rule, vehicle, now, holding)
        return needed_m * (self.release_factor if holding else 1.0)

    def _spread_m(self, rule: Rule, vehicle: Track, now: Approach, holding: bool) -> float:
        """1-sigma of the gap less what is needed, to first order.

        What is wrong with the camera's scale is as wrong with the closing speed as with the gap: where both
        are smaller the need is, too.
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
        # Upwards, as below it a rule may not apply at all.
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
