"""How often a vehicle was found of late."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.belief.lately import Lately

FRAME_S = 1 / 30


def after(frames: str, time_constant_s: float = 4.0) -> float:
    """The part after frames in which it was found (n), missed (.), or faint (-), from the first one on."""
    lately = Lately(time_constant_s)
    for frame in frames:
        lately.miss(FRAME_S)
        if frame != ".":
            lately.find(faint=frame == "-")
    return lately.part


def test_of_a_few_frames_it_is_their_mean():
    assert after("n.n") == pytest.approx(3 / 4, abs=0.01)
    assert after("..-") == pytest.approx(1 / 3, abs=0.01)


def test_what_was_long_ago_counts_no_more():
    rarely = "n...." * 240
    assert after(rarely) == pytest.approx(0.2, abs=0.02)
    # A first-order low-pass: 0.8 of the way is left times exp(-t / 4 s).
    assert after(rarely + "n" * 60) == pytest.approx(1 - 0.8 * 0.6065, abs=0.02)


@given(st.text("n.-", max_size=300), st.floats(0.1, 100.0))
def test_it_is_a_part(frames: str, time_constant_s: float):
    assert 0 < after(frames, time_constant_s) <= 1
