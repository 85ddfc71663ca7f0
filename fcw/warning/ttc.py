"""Time to collision: distance over closing speed."""

from dataclasses import dataclass

from fcw.warning.rule import Approach
from fcw.warning.types import WarningLevel

MINIMUM_CLOSING_MPS = 4.2
"""The smallest relative speed at which ISO 15623 asks for warnings. A slow approach has a short TTC for
seconds without any danger."""
WARNING_TTC_S = 2.7
"""NHTSA's tests require 2.4 s for a braking lead, 2.1 s for a standing and 2.0 s for a slow one. 0.3 s are
added for the lag of the estimated closing speed."""
CAUTION_TTC_S = 3.0
"""Mobileye's aftermarket unit warns within 3.0 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TtcRule:
    """The level is due below a TTC, if the closing speed is high enough.

    Attributes:
        level: the level that this rule raises.
        ttc_s: the threshold.
        minimum_closing_mps: the least closing speed for which the rule applies.
    """

    level: WarningLevel
    ttc_s: float
    minimum_closing_mps: float = MINIMUM_CLOSING_MPS
    name: str = "ttc"
    by_closing: bool = True

    @property
    def assumes(self) -> str:
        """See `Rule`."""
        return f"{self.ttc_s:.1f} s"

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """See `Rule`; 0 for a slow approach."""
        fast_enough = approach.closing_mps >= self.minimum_closing_mps
        return approach.closing_mps * self.ttc_s if fast_enough else 0.0


def ttc_rules(earlier_s: float = 0.0) -> tuple[TtcRule, ...]:
    """`warning` below 2.7 s, `caution` below 3.0 s."""
    return (
        TtcRule(level=WarningLevel.WARNING, ttc_s=WARNING_TTC_S + earlier_s),
        TtcRule(level=WarningLevel.CAUTION, ttc_s=CAUTION_TTC_S + earlier_s),
    )
