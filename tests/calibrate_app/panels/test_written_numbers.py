"""Numbers as the panels write them."""

import math

import pytest

from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
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
    assert alone == "At 40 m: ± 4.2% with it; without it nothing is determined."
    assert effect_words(None, document) == ""
