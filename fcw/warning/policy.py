"""From rules to a warning: evidence before a level is raised, hysteresis before it is lowered.

Every rule says how large the gap must be; its level is due when the gap is smaller. A policy is a name and a
list of rules, each for one level; `fcw.warning.policies` has the ones there are.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from fcw.tracking.lead import is_oncoming
from fcw.tracking.types import Track
from fcw.units import KMH_PER_MPS
from fcw.warning.course import will_miss
from fcw.warning.types import WarningLevel, WarningState


@dataclass(frozen=True, slots=True, kw_only=True)
class Approach:
    """How the lead stands to us, as a rule sees it.

    Attributes:
        closing_mps: rate at which the gap shrinks; negative when it opens.
        acceleration_mps2: rate at which the closing speed grows.
        own_mps: own speed; None when unknown.
    """

    closing_mps: float
    acceleration_mps2: float = 0.0
    own_mps: float | None = None


class Rule(Protocol):
    """A condition for a level."""

    @property
    def name(self) -> str:
        """Name in logs."""
        ...

    @property
    def level(self) -> WarningLevel:
        """The level it raises."""
        ...

    @property
    def by_closing(self) -> bool:
        """Whether it goes by the closing speed, which needs evidence, or by the own speed alone."""
        ...

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """The level is due when the gap is no larger than this; `holding`: it has been raised before."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """What it takes to raise a level, and how long it is held.

    Attributes:
        minimum_age_s: a younger track raises no rule that goes by the closing speed: that of its first few
            boxes is mostly their noise, and every new track is a chance of a false alarm.
        minimum_lead_s: a vehicle that has been the lead for less raises nothing: one that is passed by, and
            seen in part, may seem to be in the path for a moment. As long as the tracker sees a cut-in ahead.
        closing_sigmas: a closing speed below so many of its sigmas raises no rule that goes by it: it may be
            noise, and of a vehicle just found the tracker believes something between standing and as fast as
            we are, which is 1.7 sigmas of closing speed before anything is measured.
        upper_sigmas: a level is raised when the gap may be too small: when it is smaller than what is needed
            and so many sigmas of the difference. A warning that goes by the mean comes too late every second
            time; with 1.65 sigmas it does so in 5 of 100.
        braking_mps2: a closing speed that grows more slowly counts as constant: a lead that lets go of the
            pedal slows down by about as much.
        latest_ttc_s: above this TTC nothing is raised that goes by the closing speed. ISO 15623 needs no
            warning above 4 s; but behind a lead that brakes a driver must be warned before, at 5.7 s in the
            hardest of Euro NCAP's scenarios that can be prevented, and while braking begins the tracker's
            closing speed lags by a fifth.
        minimum_own_mps: below this own speed, where known, nothing is raised: at 10 km/h a driver of 1.2 s
            and 0.4 g needs 4 m, and queues creep nearer than that.
        release_factor: a raised level is held while its rule holds for a gap wider by this.
        minimum_duration_s: and at least so long: shorter than a driver's expected reaction (0.75 s, Green
            2000) it could be gone before it is understood.
        held_below_ttc_s: and as long as the time to contact is below this and does not grow: below 4 s no
            warning is needless by ISO 15623.
        grown_ttc: it grows when it is so many times the shortest since the level was raised.
    """

    minimum_age_s: float = 0.75
    minimum_lead_s: float = 0.5
    closing_sigmas: float = 3.0
    upper_sigmas: float = 1.65
    braking_mps2: float = 1.0
    latest_ttc_s: float = 7.0
    minimum_own_mps: float = 10 / KMH_PER_MPS
    release_factor: float = 1.25
    minimum_duration_s: float = 1.0
    held_below_ttc_s: float = 4.0
    grown_ttc: float = 1.1

    def approach(self, lead: Track, own_mps: float | None, holding: bool) -> Approach:
        """The lead by its means."""
        growth_mps2 = lead.closing_acceleration_mps2
        brakes = holding or growth_mps2 >= self.braking_mps2
        return Approach(
            closing_mps=lead.closing_speed_mps,
            acceleration_mps2=growth_mps2 if brakes else min(growth_mps2, 0.0),
            own_mps=own_mps,
        )

    def is_seen(self, lead: Track, lead_s: float, own_mps: float | None) -> bool:
        """Whether a vehicle that has been the lead for so long may raise anything."""
        creeps = own_mps is not None and own_mps < self.minimum_own_mps
        return not lead.coasting and lead_s >= self.minimum_lead_s and not creeps

    def surely_closes(self, lead: Track) -> bool:
        """Whether it may raise what goes by the closing speed."""
        closing_mps = lead.closing_speed_mps
        return (
            lead.age_s >= self.minimum_age_s
            and closing_mps > self.closing_sigmas * lead.closing_speed_sigma_mps
            and lead.distance_m <= closing_mps * self.latest_ttc_s
        )

    def due_below_m(self, rule: Rule, lead: Track, own_mps: float | None, holding: bool) -> float:
        """The gap from which on the level is due, with what is uncertain in it."""
        now = self.approach(lead, own_mps, holding)
        needed_m = rule.needed_distance_m(now, holding)
        if rule.by_closing:
            needed_m += self.upper_sigmas * self._spread_m(rule, lead, now, holding)
        return needed_m * (self.release_factor if holding else 1.0)

    def _spread_m(self, rule: Rule, lead: Track, now: Approach, holding: bool) -> float:
        """1-sigma of the gap less what is needed, to first order."""
        fast_mps = now.closing_mps + lead.closing_speed_sigma_mps
        if now.own_mps is not None:
            # The lead does not drive backwards.
            fast_mps = max(min(fast_mps, now.own_mps), now.closing_mps)
        others = [replace(now, closing_mps=fast_mps)]
        if now.acceleration_mps2 > 0:
            growth_mps2 = now.acceleration_mps2 + lead.closing_acceleration_sigma_mps2
            others.append(replace(now, acceleration_mps2=growth_mps2))
        needed_m = rule.needed_distance_m(now, holding)
        more_m = [rule.needed_distance_m(other, holding) - needed_m for other in others]
        return math.hypot(lead.distance_m - lead.distance_low_m, *more_m)


class RulePolicy:
    """Raises a level at once when a rule of it holds, and lowers it late (see `Evidence`).

    Oncoming vehicles never raise anything; a gap that does not close, and a vehicle that will be beside the
    own path before contact, raise nothing that goes by the closing speed.

    Args:
        name: in logs.
        rules: in any order; of those that hold the one of the highest level counts, the first of them.
        evidence: see `Evidence`.
    """

    def __init__(self, name: str, rules: Sequence[Rule], evidence: Evidence | None = None) -> None:
        self.name = name
        self._rules = sorted(rules, key=lambda rule: -rule.level)
        self._evidence = evidence or Evidence()
        self._state = WarningState(WarningLevel.NONE)
        self._since_ns = 0
        self._time_ns: int | None = None
        self._lead_id: int | None = None
        self._lead_since_ns = 0
        self._shortest_ttc_s = math.inf
        """Of the vehicle that the level is about, since it was raised."""

    def update(self, time_ns: int, lead: Track | None, ego_speed_mps: float | None) -> WarningState:
        """The state at `time_ns`.

        Args:
            time_ns: of the frame; must not decrease.
            lead: the lead vehicle, or None.
            ego_speed_mps: own speed; None when unknown, then rules that need it never hold.

        Raises:
            ValueError: `time_ns` is before the last one.
        """
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(f"time went back from {self._time_ns} to {time_ns} ns")
        self._time_ns = time_ns
        lead_id = None if lead is None else lead.track_id
        if lead_id != self._lead_id:
            self._lead_id, self._lead_since_ns = lead_id, time_ns
        if lead is not None and is_oncoming(lead, ego_speed_mps):
            lead = None
        if lead is not None and lead.ttc_s is not None and lead.track_id == self._state.track_id:
            self._shortest_ttc_s = min(self._shortest_ttc_s, lead.ttc_s)
        shown = self._state.level
        rule = None if lead is None else self._highest(time_ns, lead, ego_speed_mps, shown)
        level = WarningLevel.NONE if rule is None else rule.level
        young = (time_ns - self._since_ns) / 1e9 < self._evidence.minimum_duration_s
        if level < shown and (young or self._still_dangerous(lead)):
            same = lead is not None and lead.track_id == self._state.track_id
            self._state = (
                _state(shown, self._state.rule, lead, ego_speed_mps)
                if lead is not None and same
                else WarningState(shown, self._state.track_id, self._state.rule)
            )
            return self._state
        if level != shown:
            self._since_ns = time_ns
            self._shortest_ttc_s = math.inf if lead is None or lead.ttc_s is None else lead.ttc_s
        self._state = (
            WarningState(WarningLevel.NONE)
            if lead is None or rule is None
            else _state(level, rule.name, lead, ego_speed_mps)
        )
        return self._state

    def _still_dangerous(self, lead: Track | None) -> bool:
        """Whether contact comes nearer all the same.

        Where the lead brakes less than before, the thresholds fall behind it for a while: the warning would
        go and come again a second later, though nobody has acted.
        """
        if lead is None or lead.ttc_s is None or lead.track_id != self._state.track_id:
            return False
        evidence = self._evidence
        longest_s = min(evidence.held_below_ttc_s, evidence.grown_ttc * self._shortest_ttc_s)
        return (
            self._state.level >= WarningLevel.CAUTION
            and lead.ttc_s < longest_s
            and self._evidence.surely_closes(lead)
            and not will_miss(lead)
        )

    def _highest(self, time_ns: int, lead: Track, own_mps: float | None, shown: WarningLevel) -> Rule | None:
        """The rule of the highest level that holds: those up to the level shown with wider thresholds."""
        evidence = self._evidence
        off_course = lead.closing_speed_mps <= 0 or will_miss(lead)
        seen = evidence.is_seen(lead, (time_ns - self._lead_since_ns) / 1e9, own_mps)
        closes = seen and evidence.surely_closes(lead)
        for rule in self._rules:
            if rule.by_closing and off_course:
                continue
            may_be_raised = closes if rule.by_closing else seen
            for holding, allowed in ((True, rule.level <= shown), (False, may_be_raised)):
                if allowed and lead.distance_m <= evidence.due_below_m(rule, lead, own_mps, holding):
                    return rule
        return None


def required_deceleration_mps2(distance_m: float, closing_speed_mps: float) -> float | None:
    """Constant braking from now on that just avoids the collision: v^2 / (2 d); None when not closing.

    ISO 15623's required deceleration with a lead at constant speed and no system delay; inf at contact.
    """
    if closing_speed_mps <= 0:
        return None
    return closing_speed_mps**2 / (2 * distance_m) if distance_m > 0 else math.inf


def _state(level: WarningLevel, rule: str, lead: Track, ego_speed_mps: float | None) -> WarningState:
    return WarningState(
        level,
        lead.track_id,
        rule,
        lead.ttc_s,
        required_deceleration_mps2(lead.distance_m, lead.closing_speed_mps),
        lead.distance_m / ego_speed_mps if ego_speed_mps else None,
    )
