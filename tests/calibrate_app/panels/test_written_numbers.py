"""Numbers as the panels write them."""

import math

import pytest

from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.numbers_text import with_lengths
from fcw_viz.calibrate_app.document.state import BeliefEffect
from fcw_viz.calibrate_app.panels.camera.belief import effect_words
from fcw_viz.calibrate_app.panels.result import plus_minus


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
    assert alone == "At 40 m: ± 4.2% with it; without it, nothing is determined."
    assert effect_words(None, document) == ""


@pytest.mark.parametrize(
    ("text", "in_feet"),
    [
        ("their period is 12 m: click", "their period is 39.4 ft: click"),
        ("the height of 1.6 ± 0.03 m", "the height of 5.25 ± 0.0984 ft"),
        ("a rectangle of 2.5 by 5 m on", "a rectangle of 8.2 by 16.4 ft on"),
        ("(2.1 to 2.4 m are plausible)", "(6.89 to 7.87 ft are plausible)"),
        ("point 3 lies 12.5 px below", "point 3 lies 12.5 px below"),
        ("5 metres and 20 mm", "5 metres and 20 mm"),
    ],
)
def test_lengths_in_a_sentence_are_all_turned_into_feet(text: str, in_feet: str):
    assert with_lengths(text, True) == in_feet
    assert with_lengths(text, False) == text
