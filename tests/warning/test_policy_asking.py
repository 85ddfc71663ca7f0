"""What a policy of one's own gives is taken, or one message says what is wrong with it in which frame."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import fcw
from fcw.warning.asking import state_by
from fcw.warning.policies import make_policy

FRAME = fcw.Frame(9, 360_000_000, np.zeros((48, 64, 3), np.uint8))


class Mine:
    """Gives what it is told to."""

    name = "mine"

    def __init__(self, gives: Any) -> None:
        self._gives = gives

    def update(self, time_ns: int, threats: Sequence[fcw.Threat], ego_speed_mps: float | None) -> Any:
        assert (time_ns, threats, ego_speed_mps) == (FRAME.time_ns, (), 12.0)
        return self._gives


def test_a_state_is_taken_as_it_is() -> None:
    state = fcw.WarningState(fcw.WarningLevel.CAUTION, 3, "mine")
    assert state_by(Mine(state), FRAME, (), 12.0) is state


STATE = "an fcw.WarningState, that of fcw.WarningLevel.NONE for no warning"


@pytest.mark.parametrize(
    ("gives", "message"),
    [
        (None, f"gave None; expected {STATE}"),
        ("warning", f"gave 'warning'; expected {STATE}"),
        (fcw.WarningLevel.WARNING, f"gave <WarningLevel.WARNING: 3>; expected {STATE}"),
        (
            fcw.WarningState(3, 1),  # pyright: ignore[reportArgumentType]
            "gave the level 3; expected one of fcw.WarningLevel",
        ),
    ],
)
def test_what_is_no_state_is_named(gives: Any, message: str) -> None:
    with pytest.raises(fcw.UserError) as raised:
        state_by(Mine(gives), FRAME, (), 12.0)
    assert str(raised.value) == f"warning policy of the type Mine, frame 9: {message}"


def test_a_policy_of_an_earlier_drive_says_that_it_serves_one() -> None:
    policy = make_policy()
    policy.update(8_000_000_000, (), 12.0)
    with pytest.raises(ValueError, match="a policy serves one drive: make another one for the next"):
        policy.update(0, (), 12.0)
