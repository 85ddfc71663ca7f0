"""Warning levels, the state of the warning at a frame, and the seam for warning policies."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from fcw.tracking.types import Track


class WarningLevel(IntEnum):
    """How urgent: nothing, following too closely, get ready, act now."""

    NONE = 0
    ADVISORY = 1
    CAUTION = 2
    WARNING = 3


@dataclass(frozen=True, slots=True)
class WarningState:
    """The warning shown at one frame.

    Attributes:
        level: the level shown, after hysteresis.
        track_id: the vehicle it is about; None when the level is NONE.
        rule: the rule that holds the level, e.g. `ttc` or `required_deceleration`; empty for NONE.
        ttc_s: time to collision with that vehicle; None when not closing.
        required_deceleration_mps2: braking needed to avoid the collision; None when none is needed.
        headway_s: distance over ego speed; None when the ego speed is unknown or zero.
    """

    level: WarningLevel
    track_id: int | None = None
    rule: str = ""
    ttc_s: float | None = None
    required_deceleration_mps2: float | None = None
    headway_s: float | None = None


class WarningPolicy(Protocol):
    """Decides the warning from the lead vehicle; keeps its own hysteresis."""

    @property
    def name(self) -> str:
        """Name in logs."""
        ...

    def update(self, time_ns: int, lead: Track | None, ego_speed_mps: float | None) -> WarningState:
        """The state at `time_ns`; times must not decrease."""
        ...
