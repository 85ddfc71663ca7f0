"""Drivers who react to a warning and brake."""

from dataclasses import dataclass

STANDARD_GRAVITY_MPS2 = 9.80665


@dataclass(frozen=True, slots=True, kw_only=True)
class Driver:
    """A driver who reacts to the warning and brakes.

    Attributes:
        reaction_s: from the warning to full braking.
        braking_mps2: deceleration then.
    """

    reaction_s: float
    braking_mps2: float

    def needed_distance_m(self, closing_speed_mps: float) -> float:
        """Gap this driver needs to take off a closing speed: v t + v^2 / (2 a).

        The same as the required deceleration v^2 / (2 (d - v t)) being a.
        """
        return closing_speed_mps * self.reaction_s + closing_speed_mps**2 / (2 * self.braking_mps2)


EXPECTED_DRIVER = Driver(reaction_s=1.2, braking_mps2=0.4 * STANDARD_GRAVITY_MPS2)
"""The Euro NCAP driver of MathWorks' forward-collision example: warned when this one must brake now."""
SLOWEST_DRIVER = Driver(reaction_s=2.0, braking_mps2=3.6)
"""The slowest and gentlest of the drivers that ISO 15623 considers."""
