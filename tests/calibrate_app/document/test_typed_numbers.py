"""Numbers as people type them, and as the page writes them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.state import BeliefEffect
from fcw_viz.calibrate_app.fields import parse_number
from fcw_viz.calibrate_app.panels.knowledge import effect_words
from fcw_viz.calibrate_app.panels.result import plus_minus


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_comma_and_point_are_the_same(number: float):
    assert parse_number(f" {number!r} ") == number
    assert parse_number(f"{number!r}".replace(".", ",")) == number


@pytest.mark.parametrize("text", ["", "  ", "\t"])
def test_an_empty_field_says_nothing_yet(text: str):
    assert parse_number(text) is None


@pytest.mark.parametrize("text", ["4 m", "1,5,2", "nan", "inf", "-", "0x10"])
def test_what_is_no_number_is_named(text: str):
    with pytest.raises(UserError, match="is not a number; type one such as 6"):
        parse_number(text)


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (991.4, 89.2, "991 ± 89"),
        (1.13, 6.82, "1.1 ± 6.8"),
        (0.5, 0.031, "0.50 ± 0.03"),
        (-0.3, 21.0, "0 ± 21"),
    ],
)
def test_a_value_has_the_digits_that_its_sigma_carries(value: float, sigma: float, text: str):
    assert plus_minus(value, sigma) == text


def test_the_effect_of_a_belief_in_words():
    document = Document(ImageSize(1280, 720))
    words = effect_words(BeliefEffect(0.085, 0.042, -0.012), document)
    assert words == "At 40 m: ± 4.2% with it, ± 8.5% without; it moves that distance by -1.2%."
    alone = effect_words(BeliefEffect(math.inf, 0.042, 0.0), document)
    assert alone == "At 40 m: ± 4.2% with it; without it nothing is determined."
    assert effect_words(None, document) == ""
