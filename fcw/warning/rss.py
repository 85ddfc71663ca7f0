"""Responsibility-sensitive safety: the distance that is safe whatever the lead does.

Shalev-Shwartz, Shammah, Shashua 2017, "On a formal model of safe and scalable self-driving cars" (arXiv
1708.06374), the longitudinal distance of vehicles in one direction:

    d = v t + a t^2 / 2 + (v + a t)^2 / (2 b_own) - v_lead^2 / (2 b_lead)

with the values of Intel's ad-rss-lib ("Parameter Discussion" in its documentation).
"""

from dataclasses import dataclass

from fcw.units import STANDARD_GRAVITY_MPS2
from fcw.warning.rule import Approach
from fcw.warning.types import WarningLevel

RESPONSE_S = 1.0
SPEEDING_UP_MPS2 = 3.5
OWN_BRAKING_MPS2 = 4.0
LEAD_BRAKING_MPS2 = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RssRule:
    """The level is due below the safe distance; never if the own speed is unknown.

    Attributes:
        level: the level that this rule raises.
        speeding_up_mps2: our acceleration during the response time.
        lead_braking_mps2: how hard the lead might brake.
        response_s: time until we brake.
    """

    level: WarningLevel
    speeding_up_mps2: float
    lead_braking_mps2: float
    name: str = "rss"
    by_closing: bool = False
    response_s: float = RESPONSE_S

    @property
    def assumes(self) -> str:
        """See `Rule`."""
        braking_g, lead_g = (
            mps2 / STANDARD_GRAVITY_MPS2 for mps2 in (OWN_BRAKING_MPS2, self.lead_braking_mps2)
        )
        return f"{self.response_s:.1f} s to react and {braking_g:.2f} g if it brakes at {lead_g:.2f} g"

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """See `Rule`."""
        own_mps = approach.own_mps
        if own_mps is None:
            return 0.0
        lead_mps = max(own_mps - approach.closing_mps, 0.0)
        faster_mps = own_mps + self.speeding_up_mps2 * self.response_s
        response_m = (own_mps + faster_mps) / 2 * self.response_s
        stopping_m = faster_mps**2 / (2 * OWN_BRAKING_MPS2)
        return max(response_m + stopping_m - lead_mps**2 / (2 * self.lead_braking_mps2), 0.0)


def rss_rules(earlier_s: float = 0.0) -> tuple[RssRule, ...]:
    """`advisory` below the safe distance, and two higher levels that RSS does not have.

    People follow closer than the safe distance. So `caution` is for a gap that is unsafe even if we do not
    speed up, and `warning` for one that is unsafe even if, in addition, the lead brakes no harder than we do.
    """
    response_s = max(RESPONSE_S + earlier_s, 0.0)
    return (
        RssRule(
            response_s=response_s,
            level=WarningLevel.ADVISORY,
            speeding_up_mps2=SPEEDING_UP_MPS2,
            lead_braking_mps2=LEAD_BRAKING_MPS2,
        ),
        RssRule(
            response_s=response_s,
            level=WarningLevel.CAUTION,
            speeding_up_mps2=0.0,
            lead_braking_mps2=LEAD_BRAKING_MPS2,
        ),
        RssRule(
            response_s=response_s,
            level=WarningLevel.WARNING,
            speeding_up_mps2=0.0,
            lead_braking_mps2=OWN_BRAKING_MPS2,
        ),
    )
