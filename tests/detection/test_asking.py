"""What a detector of one's own gives is taken, or one message says what is wrong with it in which frame."""

import math
from typing import Any

import numpy as np
import pytest

import fcw
from fcw.detection.asking import vehicles_in

BOX = fcw.Box(400, 300, 40, 30)
_SINGLE: Any = np.float32  # as nets give them
IN_SINGLE_PRECISION = fcw.Box(_SINGLE(1), _SINGLE(2), _SINGLE(3), _SINGLE(4))


class Mine:
    """Gives what it is told to."""

    name = "mine"

    def __init__(self, gives: Any) -> None:
        self._gives = gives

    def detect(self, image: np.ndarray) -> Any:
        return self._gives


def found(gives: Any) -> tuple[fcw.Detection, ...]:
    return vehicles_in(Mine(gives), fcw.Frame(9, 0, np.zeros((48, 64, 3), np.uint8)))


@pytest.mark.parametrize("box", [BOX, fcw.Box(-500, -500, 5000, 5000), IN_SINGLE_PRECISION])
def test_detections_are_taken_as_they_are_also_in_a_list(box: fcw.Box) -> None:
    detection = fcw.Detection(box, -1.5)
    assert found((detection,)) == found([detection]) == (detection,)
    assert found(()) == found([]) == ()


@pytest.mark.parametrize(
    ("gives", "message"),
    [
        (None, "gave None; expected a tuple of fcw.Detection, empty for none"),
        (np.zeros((1, 4)), "gave [[0. 0. 0. 0.]]; expected a tuple of fcw.Detection, empty for none"),
        ([(1, 2, 3, 4)], "gave (1, 2, 3, 4) in the tuple; expected an fcw.Detection with an fcw.Box"),
        (
            (fcw.Detection((1, 2, 3, 4), 1.0),),  # pyright: ignore[reportArgumentType]
            "gave Detection(box=(1, 2, 3, 4), score=1.0, faint=False) in the tuple; "
            "expected an fcw.Detection with an fcw.Box",
        ),
    ],
)
def test_what_are_no_detections_is_named(gives: Any, message: str) -> None:
    with pytest.raises(fcw.UserError) as raised:
        found(gives)
    assert str(raised.value) == f"detector 'mine', frame 9: {message}"


def shown(number: Any) -> str:
    return str(number) if len(str(number)) <= 80 else f"{str(number)[:80]}..."


@pytest.mark.parametrize(
    "numbers",
    [
        (400, 300, -5, -5),
        (400, 300, 0.0, 30),
        (math.nan, 1, 50, 50),
        (1, 1, 50, math.nan),
        (-math.inf, 1, 50, 50),
        (1, 1, 50, 1e30),
        (1, "2", 50, 50),
        (1, None, 50, 50),
        (1, np.zeros(2), 50, 50),
        (1, np.ones(1), 50, 50),
        (1, 1, 50, 10**400),
    ],
)
def test_a_box_that_is_none_is_named(numbers: tuple[Any, ...]) -> None:
    with pytest.raises(fcw.UserError) as raised:
        found((fcw.Detection(BOX, 1.0), fcw.Detection(fcw.Box(*numbers), 1.0)))
    assert str(raised.value) == (
        f"detector 'mine', frame 9: box ({', '.join(map(shown, numbers))}); "
        "expected finite numbers, below 1,000,000 px, and a positive size"
    )


@pytest.mark.parametrize("score", [math.nan, math.inf, None, "0.5", ()])
def test_a_score_that_is_none_is_named(score: Any) -> None:
    with pytest.raises(fcw.UserError) as raised:
        found((fcw.Detection(BOX, score),))
    assert str(raised.value) == f"detector 'mine', frame 9: score {score}; expected a finite number"


@pytest.mark.parametrize("kind", [np.uint8, np.int8, np.int16, np.float16, np.float32, np.int64, int])
def test_numbers_of_any_type_are_taken_as_what_they_are(kind: Any) -> None:
    """An edge at 220 is more than an int8 holds, and an area of 12,000 more than a uint8."""
    box = fcw.Box(*map(kind, (120, 100, 100, 120)))
    (taken,) = found([fcw.Detection(box, kind(1), faint=True)])
    assert taken == fcw.Detection(fcw.Box(120.0, 100.0, 100.0, 120.0), 1.0, faint=True)
    assert (taken.box.right, taken.box.bottom, taken.box.w * taken.box.h) == (220.0, 220.0, 12_000.0)
    numbers = (taken.box.x, taken.box.y, taken.box.w, taken.box.h, taken.score)
    assert [type(number) for number in numbers] == [float] * 5
