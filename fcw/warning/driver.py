"""Drivers who react to a warning and brake, and the rule that warns one of them just in time."""

import math
from dataclasses import dataclass, replace

from fcw.units import STANDARD_GRAVITY_MPS2
from fcw.warning.rule import Approach
from fcw.warning.types import WarningLevel

RULE_BRAKING_DUE = "braking_due"
HARDEST_BRAKING_MPS2 = 8.0
"""The hardest that a car can brake (as in RSS). A closing speed that seems to change faster is noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Driver:
    """A driver who reacts to the warning and brakes.

    Attributes:
        reaction_s: time from the warning to full braking.
        braking_mps2: deceleration from then on.
    """

    reaction_s: float
    braking_mps2: float

    def slower(self, by_s: float) -> "Driver":
        """The same driver reacting `by_s` later, or sooner if it is negative."""
        return replace(self, reaction_s=max(self.reaction_s + by_s, 0.0))

    @property
    def words(self) -> str:
        """Reaction time and braking in words, for a person to read."""
        return f"{self.reaction_s:.1f} s to react and {self.braking_mps2 / STANDARD_GRAVITY_MPS2:.2f} g"

    def needed_distance_m(self, closing_speed_mps: float) -> float:
        """Gap that this driver needs to brake off a closing speed: v t + v^2 / (2 a).

        At that gap d, the required deceleration v^2 / (2 (d - v t)) is just a.
        """
        return closing_speed_mps * self.reaction_s + closing_speed_mps**2 / (2 * self.braking_mps2)


EXPECTED_DRIVER = Driver(reaction_s=1.2, braking_mps2=0.4 * STANDARD_GRAVITY_MPS2)
"""The Euro NCAP driver as in MathWorks' forward-collision example. The protocol's braking robot (AEB
Car-to-Car 4.3.1, section 8.4.6) brakes 1.2 s after the warning, at 4.0 to 4.5 m/s^2."""
SLOWEST_DRIVER = Driver(reaction_s=2.0, braking_mps2=3.6)
"""The slowest and gentlest of the drivers that ISO 15623 considers."""


def needed_distance_m(approach: Approach, driver: Driver) -> float:
    """Gap that the driver needs behind a lead that continues as it does now.

    During the reaction time the closing speed keeps growing or shrinking at its present rate. Then the driver
    brakes; a braking lead keeps braking until it stands. If the own speed is unknown, so is the moment at
    which the lead stands, and the lead is assumed to brake during the reaction time only. For a constant
    closing speed the result is `Driver.needed_distance_m`.
    """
    closing_mps, used_m = max(approach.closing_mps, 0.0), 0.0
    for duration_s, growth_mps2 in _phases(approach, driver):
        if growth_mps2 < 0 and closing_mps <= -growth_mps2 * duration_s:
            return used_m + closing_mps**2 / (-2 * growth_mps2)
        used_m += closing_mps * duration_s + growth_mps2 * duration_s**2 / 2
        closing_mps += growth_mps2 * duration_s
    raise AssertionError("the closing ends in the last phase")


def _phases(approach: Approach, driver: Driver) -> tuple[tuple[float, float], ...]:
    """Phases of the closing speed, as (duration, growth); the last one, in which we brake, is endless."""
    growth_mps2 = max(-HARDEST_BRAKING_MPS2, min(approach.acceleration_mps2, HARDEST_BRAKING_MPS2))
    if growth_mps2 <= 0 or approach.own_mps is None:
        return (driver.reaction_s, growth_mps2), (math.inf, -driver.braking_mps2)
    # The lead brakes and will stand.
    moving_s = max(approach.own_mps - approach.closing_mps, 0.0) / growth_mps2
    if moving_s <= driver.reaction_s:
        return (moving_s, growth_mps2), (driver.reaction_s - moving_s, 0.0), (math.inf, -driver.braking_mps2)
    return (
        (driver.reaction_s, growth_mps2),
        (moving_s - driver.reaction_s, growth_mps2 - driver.braking_mps2),
        (math.inf, -driver.braking_mps2),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverRule:
    """The level is due when a driver who is warned now would only just avoid the crash.

    Attributes:
        level: the level that this rule raises.
        driver: the driver who is warned.
        lead_goes_on: whether the closing speed is assumed to keep changing as it does now. If not, this is
            the Euro NCAP driver model of MathWorks' example.
    """

    level: WarningLevel
    driver: Driver
    lead_goes_on: bool = False
    name: str = RULE_BRAKING_DUE
    by_closing: bool = True

    @property
    def assumes(self) -> str:
        """See `Rule`."""
        return self.driver.words

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """See `Rule`."""
        if not self.lead_goes_on:
            return self.driver.needed_distance_m(max(approach.closing_mps, 0.0))
        return needed_distance_m(approach, self.driver)


def euro_ncap_rules(earlier_s: float = 0.0) -> tuple[DriverRule, ...]:
    """`warning` for the driver of 1.2 s and 0.4 g, `caution` for the slowest and gentlest one."""
    return (
        DriverRule(level=WarningLevel.WARNING, driver=EXPECTED_DRIVER.slower(earlier_s)),
        DriverRule(level=WarningLevel.CAUTION, driver=SLOWEST_DRIVER.slower(earlier_s)),
    )
