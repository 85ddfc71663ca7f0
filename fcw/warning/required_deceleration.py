"""ISO 15623's required deceleration: how hard we must brake, after a delay, to avoid the collision.

    a_req = a_lead + v^2 / (2 (d - v t))

If we keep our speed, the lead's deceleration a_lead is the rate at which the closing speed v grows. A lead
that speeds up counts as one that keeps its speed.
"""

import math
from dataclasses import dataclass

from fcw.units import STANDARD_GRAVITY_MPS2
from fcw.warning.driver import SLOWEST_DRIVER
from fcw.warning.rule import Approach
from fcw.warning.types import WarningLevel

HIGHEST_THRESHOLD_MPS2 = 0.68 * STANDARD_GRAVITY_MPS2
"""ISO 15623: on a dry road, the warning must come before more than this is required."""
EXPECTED_REACTION_S = 0.75
"""Reaction time of a driver who expects something (Green 2000)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RequiredDecelerationRule:
    """The level is due when the required deceleration exceeds a threshold.

    Attributes:
        level: the level that this rule raises.
        threshold_mps2: the threshold.
        delay_s: delay of driver and brakes together.
    """

    level: WarningLevel
    threshold_mps2: float
    delay_s: float
    name: str = "required_deceleration"
    by_closing: bool = True

    @property
    def assumes(self) -> str:
        """See `Rule`."""
        return f"{self.threshold_mps2 / STANDARD_GRAVITY_MPS2:.2f} g after {self.delay_s:.2f} s"

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """See `Rule`; inf where the lead brakes harder than the threshold."""
        closing_mps = max(approach.closing_mps, 0.0)
        spare_mps2 = self.threshold_mps2 - max(approach.acceleration_mps2, 0.0)
        return closing_mps * self.delay_s + closing_mps**2 / (2 * spare_mps2) if spare_mps2 > 0 else math.inf


def required_deceleration_rules(earlier_s: float = 0.0) -> tuple[RequiredDecelerationRule, ...]:
    """`warning` above 0.68 g after 0.75 s, `caution` for the slowest and gentlest of ISO's drivers."""
    return (
        RequiredDecelerationRule(
            level=WarningLevel.WARNING,
            threshold_mps2=HIGHEST_THRESHOLD_MPS2,
            delay_s=max(EXPECTED_REACTION_S + earlier_s, 0.0),
        ),
        RequiredDecelerationRule(
            level=WarningLevel.CAUTION,
            threshold_mps2=SLOWEST_DRIVER.braking_mps2,
            delay_s=SLOWEST_DRIVER.slower(earlier_s).reaction_s,
        ),
    )
