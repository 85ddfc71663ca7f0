"""Warning levels, the state of the warning at a frame, and the protocol of warning policies."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol, runtime_checkable

from fcw.threat.threat import Threat


class WarningLevel(IntEnum):
    """How urgent: nothing, following too closely, get ready, act now."""

    NONE = 0
    ADVISORY = 1
    CAUTION = 2
    WARNING = 3


@dataclass(frozen=True, slots=True)
class WarningState:
    """The warning shown at one frame, with every figure of the vehicle that it is about.

    If the vehicle is no longer tracked while its warning is still shown, the figures are extrapolated, and
    `extrapolated` is set.

    Attributes:
        level: the level shown, after hysteresis.
        track_id: the vehicle it is about. When the level is NONE, this and all figures below are None.
        rule: the rule behind the level, e.g. `ttc` or `required_deceleration`; empty for NONE.
        ttc_s: time to collision with that vehicle; None when not closing.
        required_deceleration_mps2: braking needed to avoid the collision; None when none is needed.
        headway_s: distance over ego speed; None when the ego speed is unknown or zero.
        distance_m: distance of its rear from the calibration's reference point.
        distance_low_m: 16th percentile of the distance.
        distance_high_m: 84th percentile; inf when unbounded.
        closing_speed_mps: rate at which the distance shrinks.
        overlap_m: overlap of its width and ours when we reach it; if negative, the room between them.
        collision_probability: probability that we hit it if nobody acts.
        needed_distance_m: the gap that the rule requires, computed from the mean of each estimate.
        assumes: what the rule assumes, or its threshold, in words without a unit of length: `1.2 s to react
            and 0.40 g`.
        extrapolated: whether the vehicle is no longer tracked.
    """

    level: WarningLevel
    track_id: int | None = None
    rule: str = ""
    ttc_s: float | None = None
    required_deceleration_mps2: float | None = None
    headway_s: float | None = None
    distance_m: float | None = None
    distance_low_m: float | None = None
    distance_high_m: float | None = None
    closing_speed_mps: float | None = None
    overlap_m: float | None = None
    collision_probability: float | None = None
    needed_distance_m: float | None = None
    assumes: str = ""
    extrapolated: bool = False


class WarningPolicy(Protocol):
    """Decides the warning from the threats of all vehicles; has hysteresis, so each drive needs its own."""

    @property
    def name(self) -> str:
        """Name in logs."""
        ...

    def update(self, time_ns: int, threats: Sequence[Threat], ego_speed_mps: float | None) -> WarningState:
        """Decide the warning at a frame. Times must not decrease; repeated pictures are left out.

        Args:
            time_ns: time of the frame.
            threats: the threats of all vehicles, the most urgent first; `Threat.is_lead` marks the lead.
            ego_speed_mps: own speed; None when unknown.
        """
        ...


@runtime_checkable
class BeginsAnew(Protocol):
    """A policy that is told of cuts. Others may hold a warning from before a cut for a moment."""

    def begin_anew(self) -> None:
        """Forget all vehicles, as the clip was cut and none of them is there any more."""
        ...
