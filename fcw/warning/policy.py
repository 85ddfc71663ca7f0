"""From rules to a warning: warn of the most threatening vehicle, and lower the level late.

Every rule says how large the gap must be; its level is due when the gap is smaller. A policy is a name and a
list of rules, each for one level; `fcw.warning.policies` lists them. Every vehicle on a collision course is
judged, whether it is the lead, half in the path or behind another. Headway concerns the lead only.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fcw.threat.threat import Threat, required_deceleration_mps2
from fcw.tracking.types import SeenBy
from fcw.warning.evidence import Evidence
from fcw.warning.rule import Rule
from fcw.warning.types import WarningLevel, WarningState


@dataclass(slots=True)
class _Memory:
    """What a policy remembers of a vehicle. Times are since when something has held; None if it does not."""

    lead_ns: int | None = None
    course_ns: int | None = None
    alarm_ns: int | None = None
    """Since when a rule for `caution` or more has held."""
    due_ns: int | None = None
    """Since when `warning` has been due in every frame in which the vehicle was seen."""
    on_course: bool = False
    """Whether it was on a collision course in the previous frame."""
    found_s: float = 0.0
    """Total time for which the detector has found it."""
    carried_s: float = 0.0
    """Time since the detector last found it."""

    @property
    def is_vouched_for(self) -> bool:
        """Whether it was found for at least as long as it has been carried by the picture since.

        A few false boxes may be carried for seconds by the road or by objects beside it, which come nearer. A
        lead that fills the picture, in contrast, was found for long before.
        """
        return self.carried_s <= self.found_s

    def see(self, seen_by: SeenBy, passed_s: float) -> None:
        """Record what saw the vehicle in a frame; `passed_s` is the time since the previous frame."""
        if seen_by is SeenBy.DETECTOR:
            self.found_s += passed_s
            self.carried_s = 0.0
        else:
            self.carried_s += passed_s


@dataclass(frozen=True, slots=True)
class _Due:
    """A level that a vehicle raises, and the rule that raises it."""

    level: WarningLevel
    rule: Rule
    threat: Threat


class RulePolicy:
    """Raises a level as soon as one of its rules holds for any vehicle, and lowers it late.

    Rules that use the closing speed never apply to a vehicle whose gap does not close, or that will have left
    our path before contact.

    Args:
        name: the policy's name in logs.
        rules: in any order. Of the rules that hold, the first one of the highest level counts.
        evidence: what it takes to raise a level.
    """

    def __init__(self, name: str, rules: Sequence[Rule], evidence: Evidence | None = None) -> None:
        self.name = name
        self._rules = sorted(rules, key=lambda rule: -rule.level)
        self._evidence = evidence or Evidence()
        self._state = WarningState(WarningLevel.NONE)
        self._memories: dict[int, _Memory] = {}
        self._rule: Rule | None = None
        self._since_ns = 0
        self._time_ns: int | None = None
        self._followed_ns = 0
        """When the vehicle that is warned of was last tracked."""
        self._shortest_ttc_s = math.inf
        """Shortest TTC of the vehicle that is warned of since the level was raised."""

    def begin_anew(self) -> None:
        """Forget all vehicles, as after a cut."""
        self._state, self._rule = WarningState(WarningLevel.NONE), None

    def update(self, time_ns: int, threats: Sequence[Threat], ego_speed_mps: float | None) -> WarningState:
        """The state at `time_ns`; see `WarningPolicy`.

        Raises:
            ValueError: `time_ns` is before the last one.
        """
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(
                f"time went back from {self._time_ns} to {time_ns} ns; a policy serves one drive: make "
                "another one for the next"
            )
        passed_s = 0.0 if self._time_ns is None else (time_ns - self._time_ns) / 1e9
        self._time_ns = time_ns
        self._memories = {
            threat.track.track_id: self._memories.get(threat.track.track_id, _Memory()) for threat in threats
        }
        shown, warned_id = self._state.level, self._state.track_id
        warned = next((threat for threat in threats if threat.track.track_id == warned_id), None)
        if warned is not None:
            self._followed_ns = time_ns
            if warned.track.ttc_s is not None:
                self._shortest_ttc_s = min(self._shortest_ttc_s, warned.track.ttc_s)
        for threat in threats:
            self._memories[threat.track.track_id].see(threat.track.seen_by, passed_s)
        due = [found for threat in threats if (found := self._judge(time_ns, threat, ego_speed_mps))]
        # At equal levels, keep the vehicle already warned of, else take the most urgent, which comes first.
        best = max(due, key=lambda one: (one.level, one.threat is warned), default=None)
        level = WarningLevel.NONE if best is None else best.level
        young = (time_ns - self._since_ns) / 1e9 < self._evidence.minimum_duration_s
        if level < shown and (young or self._still_dangerous(time_ns, warned)):
            assert self._rule is not None
            self._state = (
                self._state_of(shown, self._rule, warned, ego_speed_mps)
                if warned is not None
                else _extrapolated(self._state, passed_s, ego_speed_mps)
            )
            return self._state
        if best is None:
            self._state, self._rule = WarningState(WarningLevel.NONE), None
        else:
            self._rule = best.rule
            self._state = self._state_of(level, best.rule, best.threat, ego_speed_mps)
        if (level, self._state.track_id) != (shown, warned_id):
            self._shortest_ttc_s = math.inf if self._state.ttc_s is None else self._state.ttc_s
        if level != shown:
            self._since_ns = time_ns
        return self._state

    def _still_dangerous(self, time_ns: int, warned: Threat | None) -> bool:
        """Whether the warned vehicle still comes nearer although no rule holds any more.

        If the lead brakes less than before, the thresholds allow a smaller gap for a while. The warning would
        end and return a second later, though nobody has acted. The same would happen if the vehicle was lost
        from sight and found again as a new track.
        """
        evidence = self._evidence
        if warned is None:
            raised = self._state.level >= WarningLevel.CAUTION
            recent = not _lasts(self._followed_ns, time_ns, evidence.lost_s)
            return raised and recent and evidence.was_in_our_way(self._state)
        if warned.track.ttc_s is None:
            return False
        longest_s = min(evidence.held_below_ttc_s, evidence.grown_ttc * self._shortest_ttc_s)
        return (
            self._state.level >= WarningLevel.CAUTION
            and warned.track.ttc_s < longest_s
            and evidence.surely_closes(warned)
            and evidence.is_on_course(warned, holding=True)
        )

    def _judge(self, time_ns: int, threat: Threat, own_mps: float | None) -> _Due | None:
        """The highest level that a vehicle raises. Up to the level shown for it, thresholds are wider."""
        evidence, vehicle = self._evidence, threat.track
        memory = self._memories[vehicle.track_id]
        is_shown = vehicle.track_id == self._state.track_id
        shown = self._state.level if is_shown else WarningLevel.NONE
        was_on_course = memory.on_course
        # It takes less evidence to hold a level than to raise one.
        comes_on_course = evidence.is_on_course(threat, False, was_on_course)
        on_course = comes_on_course or (is_shown and evidence.is_on_course(threat, True, was_on_course))
        memory.on_course = on_course
        memory.lead_ns = _since(memory.lead_ns, time_ns, threat.is_lead)
        # For a vehicle that comes in, time on course counts from before it became the lead.
        comes = on_course and (not threat.is_lead or memory.course_ns is not None)
        memory.course_ns = _since(memory.course_ns, time_ns, comes)
        seen = memory.is_vouched_for and evidence.is_seen(vehicle, own_mps)
        may_follow = seen and _lasts(memory.lead_ns, time_ns, evidence.minimum_lead_s)
        may_close = (
            seen
            and (
                _lasts(memory.lead_ns, time_ns, evidence.lead_evidence_s(threat))
                or _lasts(memory.course_ns, time_ns, evidence.course_evidence_s(threat))
            )
            and evidence.surely_closes(threat)
        )
        found = None
        for rule in self._rules:
            concerned = (
                on_course and vehicle.closing_speed_mps > 0 and not evidence.may_steer(threat, rule.level)
                if rule.by_closing
                else threat.is_lead
            )
            may_be_raised = may_close and comes_on_course if rule.by_closing else may_follow
            for holding, allowed in ((True, rule.level <= shown), (False, may_be_raised)):
                if concerned and allowed:
                    due_m = evidence.due_below_m(rule, vehicle, own_mps, holding)
                    if found is None and vehicle.distance_m < due_m:
                        found = rule
        alarmed = found is not None and found.level >= WarningLevel.CAUTION
        memory.alarm_ns = _since(memory.alarm_ns, time_ns, alarmed)
        level = WarningLevel.NONE if found is None else found.level
        if found is not None and found.by_closing and level == WarningLevel.WARNING > shown:
            cautioned = _lasts(memory.alarm_ns, time_ns, evidence.caution_first_s)
            if evidence.is_too_early(threat, found, own_mps) or (evidence.has_time(threat) and not cautioned):
                level = WarningLevel.CAUTION
        if not vehicle.coasting:  # else nothing new is known
            memory.due_ns = _since(memory.due_ns, time_ns, level == WarningLevel.WARNING)
        if found is None:
            return None
        surely_due = _lasts(memory.due_ns, time_ns, evidence.due_evidence_s(vehicle))
        if level == WarningLevel.WARNING > shown and not surely_due:
            level = WarningLevel.CAUTION
        return _Due(level, found, threat)

    def _state_of(
        self, level: WarningLevel, rule: Rule, threat: Threat, own_mps: float | None
    ) -> WarningState:
        vehicle = threat.track
        approach = self._evidence.approach(vehicle, own_mps, holding=False)
        if_it_stays = rule.by_closing and threat.clear_s and self._evidence.leaves_late(threat)
        return WarningState(
            level=level,
            track_id=vehicle.track_id,
            rule=rule.name,
            ttc_s=vehicle.ttc_s,
            required_deceleration_mps2=threat.required_deceleration_mps2,
            headway_s=vehicle.distance_m / own_mps if own_mps else None,
            distance_m=vehicle.distance_m,
            distance_low_m=vehicle.distance_low_m,
            distance_high_m=vehicle.distance_high_m,
            closing_speed_mps=vehicle.closing_speed_mps,
            overlap_m=threat.overlap_m,
            collision_probability=threat.collision_probability,
            needed_distance_m=rule.needed_distance_m(approach, holding=True),
            assumes=f"{rule.assumes} (if it stays in your way)" if if_it_stays else rule.assumes,
        )


def _since(before_ns: int | None, time_ns: int, holds: bool) -> int | None:
    if not holds:
        return None
    return time_ns if before_ns is None else before_ns


def _lasts(since_ns: int | None, time_ns: int, long_s: float) -> bool:
    return since_ns is not None and (time_ns - since_ns) / 1e9 >= long_s


def _extrapolated(state: WarningState, passed_s: float, own_mps: float | None) -> WarningState:
    """The warning of a vehicle that is no longer tracked, extrapolated by `passed_s`."""
    assert state.distance_m is not None
    assert state.distance_low_m is not None
    assert state.distance_high_m is not None
    assert state.closing_speed_mps is not None
    nearer_m = state.closing_speed_mps * passed_s
    distance_m = max(state.distance_m - nearer_m, 0.0)
    return replace(
        state,
        distance_m=distance_m,
        distance_low_m=max(state.distance_low_m - nearer_m, 0.0),
        distance_high_m=max(state.distance_high_m - nearer_m, 0.0),
        ttc_s=None if state.ttc_s is None else max(state.ttc_s - passed_s, 0.0),
        required_deceleration_mps2=required_deceleration_mps2(distance_m, state.closing_speed_mps),
        headway_s=distance_m / own_mps if own_mps else None,
        extrapolated=True,
    )
