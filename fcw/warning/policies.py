"""The warning policies by name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from fcw.errors import UserError
from fcw.warning.driver import EXPECTED_DRIVER, SLOWEST_DRIVER, DriverRule, euro_ncap_rules
from fcw.warning.evidence import Evidence
from fcw.warning.headway import headway_rules
from fcw.warning.policy import RulePolicy
from fcw.warning.required_deceleration import required_deceleration_rules
from fcw.warning.rss import rss_rules
from fcw.warning.rule import Rule
from fcw.warning.ttc import CAUTION_TTC_S, TtcRule, ttc_rules
from fcw.warning.types import WarningLevel, WarningPolicy

DEFAULT_POLICY = "timely-braking"


def timely_braking_rules(earlier_s: float = 0.0) -> tuple[Rule, ...]:
    """The default policy; `docs/warning.md` says why.

    `warning` when a driver with 1.2 s of reaction time and 0.4 g of braking must brake, behind a lead that
    continues as it does now; `caution` when ISO 15623's slowest and gentlest driver must, or below a TTC of
    3.0 s; `advisory` below a headway of 0.6 s.
    """
    return (
        DriverRule(level=WarningLevel.WARNING, driver=EXPECTED_DRIVER.slower(earlier_s), lead_goes_on=True),
        DriverRule(level=WarningLevel.CAUTION, driver=SLOWEST_DRIVER.slower(earlier_s), lead_goes_on=True),
        TtcRule(level=WarningLevel.CAUTION, ttc_s=CAUTION_TTC_S + earlier_s),
        *(rule for rule in headway_rules(earlier_s) if rule.level == WarningLevel.ADVISORY),
    )


@dataclass(frozen=True, slots=True)
class PolicyEntry:
    """A policy that can be chosen by name.

    Attributes:
        rules: makes its rules; takes the number of seconds by which warnings are to come earlier.
        needs_own_speed: whether it can give no warning at all without the own speed.
    """

    rules: Callable[[float], Sequence[Rule]]
    needs_own_speed: bool = False


POLICIES: dict[str, PolicyEntry] = {
    DEFAULT_POLICY: PolicyEntry(timely_braking_rules),
    "ttc": PolicyEntry(ttc_rules),
    "required-deceleration": PolicyEntry(required_deceleration_rules),
    "euro-ncap-driver": PolicyEntry(euro_ncap_rules),
    "headway": PolicyEntry(headway_rules, needs_own_speed=True),
    "rss": PolicyEntry(rss_rules, needs_own_speed=True),
}


TIMINGS_S = {"early": 0.5, "normal": 0.0, "late": -0.4}
"""Seconds added to the driver's assumed reaction time, so that warnings come earlier. Cars offer three such
settings. `late` leaves 0.8 s, for a driver who expects something (0.75 s, Green 2000); `early` allows for
more than the surprise of an unexpected event (1.5 s)."""
DEFAULT_TIMING = "normal"


def make_policy(name: str = DEFAULT_POLICY, timing: str = DEFAULT_TIMING) -> WarningPolicy:
    """A fresh policy by its name and timing.

    Raises:
        UserError: there is no such policy or timing.
    """
    if timing not in TIMINGS_S:
        raise UserError(f"--warning-timing {timing}: expected one of {', '.join(TIMINGS_S)}")
    if name not in POLICIES:
        raise UserError(f"--warning-policy {name}: no such policy; expected one of {', '.join(POLICIES)}")
    earlier_s, usual = TIMINGS_S[timing], Evidence()
    evidence = replace(
        usual,
        latest_warning_s=usual.latest_warning_s + earlier_s,
        latest_braking_s=usual.latest_braking_s + earlier_s,
    )
    return RulePolicy(name, POLICIES[name].rules(earlier_s), evidence)


def without_own_speed(name: str) -> str:
    """What the policy cannot do if the own speed is unknown, as a sentence for the user.

    Raises:
        UserError: the policy can do nothing at all without the own speed.
    """
    if POLICIES[name].needs_own_speed:
        raise UserError(
            f"--warning-policy {name}: needs the own speed; give it with --ego-speed, have it estimated "
            f"from the picture (leave out --no-own-motion), or choose {DEFAULT_POLICY}"
        )
    return (
        "own speed unknown: warnings use distance, closing speed and TTC only; there is no advisory for "
        "following too closely, a braking lead is assumed to brake until you do, and oncoming vehicles are "
        "recognised by their position alone; give --ego-speed, or leave out --no-own-motion"
    )
