"""A policy is asked what to warn of. It may be anybody's, so its answer is checked."""

from collections.abc import Sequence

from fcw.errors import UserError
from fcw.frame import Frame
from fcw.threat.threat import Threat
from fcw.warning.types import WarningLevel, WarningPolicy, WarningState


def state_by(
    policy: WarningPolicy, frame: Frame, threats: Sequence[Threat], ego_speed_mps: float | None
) -> WarningState:
    """What a policy says at a frame.

    Args:
        policy: who is asked.
        frame: whose time counts.
        threats: see `WarningPolicy.update`.
        ego_speed_mps: own speed; None when unknown.

    Raises:
        UserError: it gives something else than a state with a level.
    """
    state: object = policy.update(frame.time_ns, threats, ego_speed_mps)
    if not isinstance(state, WarningState):
        expected = "an fcw.WarningState, that of fcw.WarningLevel.NONE for no warning"
        raise _wrong(policy, frame, f"gave {state!r:.80}", expected)
    level: object = state.level
    if not isinstance(level, WarningLevel):
        raise _wrong(policy, frame, f"gave the level {level!r:.80}", "one of fcw.WarningLevel")
    return state


def _wrong(policy: WarningPolicy, frame: Frame, what: str, expected: str) -> UserError:
    kind = type(policy).__name__
    return UserError(f"warning policy of the type {kind}, frame {frame.index}: {what}; expected {expected}")
