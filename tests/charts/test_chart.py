"""Charts: values stand where their axes say, and what is not on the axes is left out."""

import math
from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.charts.chart import WIDTH_PX, Chart, Series
from fcw.charts.scale import Scale, round_values
from fcw.charts.svg import element, words


def drawn(*series: Series) -> ElementTree.Element:
    return ElementTree.fromstring(Chart("a < b", "x", "y", (0, 10), (0, 2), series).svg())


def test_a_scale_is_straight_or_by_ratios_and_holds_what_is_beyond():
    straight, by_ratios = Scale(2, 4, 100, 0), Scale(1, 100, 0, 60, logarithmic=True)
    assert [straight.px(value) for value in (2, 3, 4, 5, -math.inf)] == [100, 50, 0, 0, 100]
    assert [by_ratios.px(value) for value in (1, 10, 100, 0)] == pytest.approx([0, 30, 60, 0])
    assert np.isnan(straight.places_px(np.array([math.nan, 3.0]))).tolist() == [True, False]


@pytest.mark.parametrize(
    ("low", "high", "values"),
    [
        (0, 80, [0, 10, 20, 30, 40, 50, 60, 70, 80]),
        (0, 1, [0, 0.2, 0.4, 0.6, 0.8, 1]),
        (-3, 7, range(-2, 7, 2)),
    ],
)
def test_ticks_are_round(low: float, high: float, values: Sequence[float]):
    assert round_values(low, high, 8) == pytest.approx(list(values))


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e4), st.integers(4, 12))
def test_ticks_are_neither_many_nor_few(low: float, span: float, most: int):
    assert most / 2.5 - 1 <= len(round_values(low, low + span, most)) <= most + 1


def test_points_outside_the_axes_are_left_out():
    root = drawn(Series("s", [(1.0, 1.0), (2.0, math.inf), (3.0, math.nan), (50.0, 1.0)]))
    assert len(root.findall(".//{*}circle")) == 1
    assert [title.text for title in root.findall("{*}title")] == ["a < b"]


def test_a_point_has_its_own_name_also_where_others_are_left_out():
    points = [(1.0, math.nan), (2.0, 1.0), (50.0, 1.0), (4.0, 1.0)]
    root = drawn(Series("", points, point_names=["none", "b & c", "far", ""]))
    circles = root.findall(".//{*}circle")
    assert [circle.findtext("{*}title") for circle in circles] == ["b & c", None]


def test_names_that_do_not_fit_beside_each_other_stand_below_each_other():
    names = ["a name as long as half of the chart, and more than that"] * 3
    root = drawn(*(Series(name, [(1.0, 1.0), (2.0, 1.5)], line=True) for name in names))
    places = {(t.get("x"), t.get("y")) for t in root.iterfind(".//{*}text") if t.text == names[0]}
    assert len(places) == 3
    assert len({x for x, _ in places}) == 1
    assert all(float(x or "nan") < WIDTH_PX / 4 for x, _ in places)


def test_words_and_attributes_are_escaped_and_spaces_kept():
    assert element("g", data_name='<"&>', fill=None) == '<g data-name="&lt;&quot;&amp;&gt;"/>'
    assert "a\u2002&lt;b" in words(0, 0, "a  <b")
