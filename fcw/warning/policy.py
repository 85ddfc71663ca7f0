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
from fcw.warning.course import Course
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
        closing_sigmas: nor does a closing speed below so many of its sigmas: it may be noise.
        upper_sigmas: a level is raised when the gap may be too small: when it is smaller than what is needed
            and so many sigmas of the difference. A warning that goes by the mean comes too late every second
            time; with 1 sigma the danger is there with a probability of 16 % when the warning comes.
        braking_mps2: a closing speed that grows more slowly counts as constant: a car that only coasts slows
            down by about as much.
        minimum_own_mps: below this own speed, where known, nothing is raised: at 10 km/h a driver of 1.2 s
            and 0.4 g needs 4 m, and queues creep nearer than that.
        release_factor: a raised level is held while its rule holds for a gap wider by this.
        minimum_duration_s: and at least so long: shorter than a driver's expected reaction (0.75 s, Green
            2000) it could be gone before it is understood.
    """

    minimum_age_s: float = 0.75
    closing_sigmas: float = 1.5
    upper_sigmas: float = 1.0
    braking_mps2: float = 0.5
    minimum_own_mps: float = 10 / KMH_PER_MPS
    release_factor: float = 1.25
    minimum_duration_s: float = 1.0

    def approach(self, lead: Track, own_mps: float | None) -> Approach:
        """The lead by its means."""
        growth_mps2 = lead.closing_acceleration_mps2
        brakes = growth_mps2 >= self.braking_mps2
        return Approach(
            closing_mps=lead.closing_speed_mps,
            acceleration_mps2=growth_mps2 if brakes else min(growth_mps2, 0.0),
            own_mps=own_mps,
        )

    def suffices(self, lead: Track, own_mps: float | None) -> bool:
        """Whether the lead surely closes, so that a rule of the closing speed may raise its level."""
        return (
            not lead.coasting
            and lead.age_s >= self.minimum_age_s
            and lead.closing_speed_mps > self.closing_sigmas * lead.closing_speed_sigma_mps
            and not self.creeps(own_mps)
        )

    def creeps(self, own_mps: float | None) -> bool:
        """Whether we are too slow for any warning."""
        return own_mps is not None and own_mps < self.minimum_own_mps

    def may_be_due(self, rule: Rule, lead: Track, own_mps: float | None) -> bool:
        """Whether the gap may be too small, by `upper_sigmas` of what is uncertain in it."""
        now = self.approach(lead, own_mps)
        needed_m = rule.needed_distance_m(now, holding=False)
        fast_mps = now.closing_mps + self.upper_sigmas * lead.closing_speed_sigma_mps
        if own_mps is not None:
            # The lead does not drive backwards.
            fast_mps = max(min(fast_mps, own_mps), now.closing_mps)
        faster = replace(now, closing_mps=fast_mps)
        spreads_m = [
            self.upper_sigmas * (lead.distance_m - lead.distance_low_m),
            rule.needed_distance_m(faster, holding=False) - needed_m,
        ]
        if now.acceleration_mps2 > 0:
            growth_mps2 = now.acceleration_mps2 + self.upper_sigmas * lead.closing_acceleration_sigma_mps2
            harder = replace(now, acceleration_mps2=growth_mps2)
            spreads_m.append(rule.needed_distance_m(harder, holding=False) - needed_m)
        return lead.distance_m <= needed_m + math.hypot(*spreads_m)


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
        self._course = Course()
        self._state = WarningState(WarningLevel.NONE)
        self._since_ns = 0
        self._time_ns: int | None = None

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
        misses = self._course.misses(time_ns, lead)
        if lead is not None and is_oncoming(lead, ego_speed_mps):
            lead = None
        shown = self._state.level
        rule = None if lead is None else self._highest(lead, ego_speed_mps, shown, misses)
        level = WarningLevel.NONE if rule is None else rule.level
        if level < shown and (time_ns - self._since_ns) / 1e9 < self._evidence.minimum_duration_s:
            same = lead is not None and lead.track_id == self._state.track_id
            self._state = (
                _state(shown, self._state.rule, lead, ego_speed_mps)
                if lead is not None and same
                else WarningState(shown, self._state.track_id, self._state.rule)
            )
            return self._state
        if level != shown:
            self._since_ns = time_ns
        self._state = (
            WarningState(WarningLevel.NONE)
            if lead is None or rule is None
            else _state(level, rule.name, lead, ego_speed_mps)
        )
        return self._state

    def _highest(self, lead: Track, own_mps: float | None, shown: WarningLevel, misses: bool) -> Rule | None:
        """The rule of the highest level that holds: those up to the level shown with wider thresholds."""
        evidence = self._evidence
        now, sure = evidence.approach(lead, own_mps), evidence.suffices(lead, own_mps)
        for rule in self._rules:
            if rule.by_closing and (misses or now.closing_mps <= 0):
                continue
            if rule.level <= shown:
                wide_m = rule.needed_distance_m(now, holding=True) * evidence.release_factor
                if lead.distance_m <= wide_m:
                    return rule
            if rule.by_closing:
                due = sure and evidence.may_be_due(rule, lead, own_mps)
            else:
                due = lead.distance_m <= rule.needed_distance_m(now, holding=False)
                due = due and not evidence.creeps(own_mps)
            if due:
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
