"""What people type is understood, and what is not is answered with what was expected."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.errors import UserError
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.quantities import DISTANCE, FIELD_OF_VIEW, HEIGHT, ROW, Quantity

FOOT_M = 0.3048


@pytest.mark.parametrize(
    ("text", "expected_m"),
    [
        ("15", 15.0),
        (" 15 m", 15.0),
        ("15,5", 15.5),
        ("15.5m", 15.5),
        (".5", 0.5),
        ("50 ft", 50 * FOOT_M),
        ("50feet", 50 * FOOT_M),
        ("50'", 50 * FOOT_M),
        ("20 yd", 20 * 3 * FOOT_M),
        ("450 cm", 4.5),
        ("4500 mm", 4.5),
        ("4 ft 3 in", 4.25 * FOOT_M),
        ("4'3\"", 4.25 * FOOT_M),
        ("", None),
        ("  ", None),
    ],
)
def test_a_distance_with_or_without_its_unit(text: str, expected_m: float | None):
    assert DISTANCE.read(text) == (None if expected_m is None else pytest.approx(expected_m))


def test_a_height_in_millimetres_is_taken_with_its_unit_and_without():
    assert HEIGHT.read("1300 mm") == pytest.approx(1.3)
    assert HEIGHT.read("1300") == 1300.0, "which a button then takes for millimetres"


def test_a_number_without_a_unit_counts_in_that_of_the_page():
    assert DISTANCE.read("50", 1 / FEET_PER_METRE) == pytest.approx(50 * FOOT_M)
    assert DISTANCE.read("15 m", 1 / FEET_PER_METRE) == 15.0
    assert FIELD_OF_VIEW.read("65°", math.radians(1)) == pytest.approx(math.radians(65))
    assert ROW.read("310.5 px") == 310.5


@pytest.mark.parametrize(
    "text", ["fifteen", "15 m 3", "15 kg", "1.000,5", "nan", "inf", "--3", "15 °", "1e400"]
)
def test_what_is_no_distance_is_answered_with_what_was_expected(text: str):
    with pytest.raises(UserError) as refused:
        DISTANCE.read(text)
    assert repr(text) in str(refused.value)
    assert "15, 4.5 m or 50 ft" in str(refused.value)


@pytest.mark.parametrize(
    ("quantity", "text", "limits"),
    [
        (DISTANCE, "1e9", "0.3 to 500 m"),
        (DISTANCE, "-3", "0.3 to 500 m"),
        (DISTANCE, "0", "0.3 to 500 m"),
        (HEIGHT, "0", "0.001 to 10000 m"),
    ],
)
def test_what_nobody_measures_is_refused_with_the_limits(quantity: Quantity, text: str, limits: str):
    with pytest.raises(UserError, match=f"expected {limits}"):
        quantity.read(text)


def test_limits_are_told_in_the_units_of_the_page():
    with pytest.raises(UserError, match=r"expected 0\.984 to 1640 ft"):
        DISTANCE.read("9999", 1 / FEET_PER_METRE)


@given(st.floats(0.3, 500.0), st.sampled_from(["m", "ft", "'", "yd", "cm"]))
def test_every_distance_comes_back_in_every_unit(distance_m: float, unit: str):
    text = f"{distance_m / DISTANCE.units[unit]!r} {unit}"
    if DISTANCE.lowest < distance_m * (1 - 1e-9) and distance_m * (1 + 1e-9) < DISTANCE.highest:
        assert DISTANCE.read(text) == pytest.approx(distance_m)
