"""What a rule is: how large the gap must be, and what it assumes."""

from dataclasses import dataclass
from typing import Protocol

from fcw.warning.types import WarningLevel


@dataclass(frozen=True, slots=True, kw_only=True)
class Approach:
    """The motion of a vehicle relative to us, as a rule sees it.

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
        """Whether it uses the closing speed, which needs evidence; False if it uses the own speed only."""
        ...

    @property
    def assumes(self) -> str:
        """Its threshold or what it assumes of the driver, in words; see `WarningState.assumes`."""
        ...

    def needed_distance_m(self, approach: Approach, holding: bool) -> float:
        """The level is due when the gap is smaller than this.

        Args:
            approach: the vehicle.
            holding: whether the level has been raised already and may only be held.

        Returns:
            The gap; 0 if the rule does not apply, as no gap is smaller than that.
        """
        ...
