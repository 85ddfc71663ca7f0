"""Headway: distance over own speed, whether the gap closes or not."""

from dataclasses import dataclass

from fcw.units import KMH_PER_MPS
from fcw.warning.rule import Approach
from fcw.warning.types import WarningLevel

ADVISORY_HEADWAY_S = 0.6
"""Mobileye's aftermarket unit has this by default (AWS-4000 manual, chapter 6)."""
CAUTION_HEADWAY_S = 0.4
"""The smallest setting of that unit; its largest is 2.0 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadwayRule:
    """The level is due when the headway is below a threshold; never if the own speed is unknown.

    Attributes:
        level: the level that this rule raises.
        headway_s: the threshold.
        on_mps: own speed from which the level is raised: 40 km/h, as in Mobileye's unit.
        off_mps: own speed below which it ends: 30 km/h, as in Mobileye's unit.
    """

    level: WarningLevel
    headway_s: float
    on_mps: float = 40 / KMH_PER_MPS
    off_mps: float = 30 / KMH_PER_MPS
    name: str = "headway"
    by_closing: bool = False

    @property
    def assumes(self) -> str:
        """See `Rule`."""
        return f"{self.headway_s:.2g} s"

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """See `Rule`; 0 below the speeds that count."""
        own_mps = approach.own_mps
        if own_mps is None or own_mps < (self.off_mps if holding else self.on_mps):
            return 0.0
        return own_mps * self.headway_s


def headway_rules(earlier_s: float = 0.0) -> tuple[HeadwayRule, ...]:
    """`advisory` below 0.6 s, `caution` below 0.4 s; `earlier_s` is added to the former only."""
    return (
        HeadwayRule(
            level=WarningLevel.ADVISORY, headway_s=max(ADVISORY_HEADWAY_S + earlier_s, CAUTION_HEADWAY_S)
        ),
        HeadwayRule(level=WarningLevel.CAUTION, headway_s=CAUTION_HEADWAY_S),
    )
