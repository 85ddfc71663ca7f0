"""Ask a warning policy for its warning and check the answer, as the policy may be a user's own."""

from collections.abc import Sequence

from fcw.errors import UserError
from fcw.frame import Frame
from fcw.threat.threat import Threat
from fcw.warning.types import WarningLevel, WarningPolicy, WarningState


def state_by(
    policy: WarningPolicy, frame: Frame, threats: Sequence[Threat], ego_speed_mps: float | None
) -> WarningState:
    """Ask a policy for its warning at a frame, and check the answer.

    Args:
        policy: the policy to ask.
        frame: the frame; only its time is used.
        threats: see `WarningPolicy.update`.
        ego_speed_mps: own speed; None when unknown.

    Raises:
        UserError: the answer is not a `WarningState` with a `WarningLevel`.
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
