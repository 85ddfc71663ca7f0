"""The warning policies by name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fcw.errors import UserError
from fcw.warning.driver import EXPECTED_DRIVER, SLOWEST_DRIVER, DriverRule, euro_ncap_rules
from fcw.warning.headway import ADVISORY_HEADWAY_S, HeadwayRule, headway_rules
from fcw.warning.policy import Rule, RulePolicy
from fcw.warning.required_deceleration import required_deceleration_rules
from fcw.warning.rss import rss_rules
from fcw.warning.ttc import CAUTION_TTC_S, TtcRule, ttc_rules
from fcw.warning.types import WarningLevel, WarningPolicy

DEFAULT_POLICY = "timely-braking"


def timely_braking_rules() -> tuple[Rule, ...]:
    """The default; `docs/warning.md` says why.

    `warning` when a driver of 1.2 s and 0.4 g must brake, behind a lead that goes on as it does; `caution`
    when ISO 15623's slowest and gentlest driver must, or below a TTC of 3.0 s; `advisory` below a headway of
    0.6 s.
    """
    return (
        DriverRule(level=WarningLevel.WARNING, driver=EXPECTED_DRIVER, lead_goes_on=True),
        DriverRule(level=WarningLevel.CAUTION, driver=SLOWEST_DRIVER, lead_goes_on=True),
        TtcRule(level=WarningLevel.CAUTION, ttc_s=CAUTION_TTC_S),
        HeadwayRule(level=WarningLevel.ADVISORY, headway_s=ADVISORY_HEADWAY_S),
    )


@dataclass(frozen=True, slots=True)
class PolicyEntry:
    """A policy on the list.

    Attributes:
        rules: makes its rules.
        needs_own_speed: whether it says nothing at all without the own speed.
    """

    rules: Callable[[], Sequence[Rule]]
    needs_own_speed: bool = False


POLICIES: dict[str, PolicyEntry] = {
    DEFAULT_POLICY: PolicyEntry(timely_braking_rules),
    "ttc": PolicyEntry(ttc_rules),
    "required-deceleration": PolicyEntry(required_deceleration_rules),
    "euro-ncap-driver": PolicyEntry(euro_ncap_rules),
    "headway": PolicyEntry(headway_rules, needs_own_speed=True),
    "rss": PolicyEntry(rss_rules, needs_own_speed=True),
}


def make_policy(name: str = DEFAULT_POLICY) -> WarningPolicy:
    """A fresh policy by its name.

    Raises:
        UserError: there is none of that name.
    """
    if name not in POLICIES:
        raise UserError(f"--warning-policy {name}: no such policy; expected one of {', '.join(POLICIES)}")
    return RulePolicy(name, POLICIES[name].rules())


def without_own_speed(name: str) -> str:
    """What is lost where the own speed is unknown, for a person to read.

    Raises:
        UserError: the policy goes by nothing else.
    """
    if POLICIES[name].needs_own_speed:
        raise UserError(
            f"--warning-policy {name}: goes by the own speed; give it with --ego-speed, "
            f"or choose {DEFAULT_POLICY}"
        )
    return (
        "own speed unknown: warnings go by distance, closing speed and TTC only; following too closely is "
        "not advised, a lead that brakes counts as one that keeps its speed, and oncoming vehicles are told "
        "by their place alone; give --ego-speed"
    )
