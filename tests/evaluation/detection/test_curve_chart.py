"""The picture of a curve shows the curve."""

import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from fcw.detection.matching import DetectionCurve
from fcw.evaluation.detection.curve_chart import GRID_FPPI, PlottedCurve, curve_chart

CURVE = DetectionCurve(np.array([3.0, 2.0, 1.0]), np.array([True, False, True]), 2, 10)


def drawn(*curves: PlottedCurve) -> ElementTree.Element:
    return ElementTree.fromstring(curve_chart(curves).svg())


def on_axes(root: ElementTree.Element, x: float, y: float) -> tuple[float, float]:
    """False positives per image and rate of a place, by the words of the axes."""
    words = {text.text: text for text in root.iterfind(".//{*}text")}
    left, right = (float(words[name].attrib["x"]) for name in ("0.01", "10"))
    floor, ceiling = (float(words[name].attrib["y"]) - 4 for name in ("0", "1"))
    return 0.01 * 1000 ** ((x - left) / (right - left)), (floor - y) / (floor - ceiling)


def corners(root: ElementTree.Element, tag: str) -> list[tuple[float, float]]:
    (element,) = root.findall(f".//{{*}}{tag}")
    places = (tuple(map(float, pair.split(","))) for pair in element.attrib["points"].split())
    return [on_axes(root, x, y) for x, y in places]


def test_the_line_is_a_staircase_through_all_thresholds():
    root = drawn(PlottedCurve("acf", "#000", CURVE, CURVE.at_threshold(2.0)))
    line = corners(root, "polyline")
    found = [corner for number, corner in enumerate(line) if number == 0 or corner != line[number - 1]]
    expected = [(0.005, 0), (0.005, 0.5), (0.1, 0.5), (0.1, 1), (20, 1)]
    assert np.array(found) == pytest.approx(np.array(expected), rel=2e-3, abs=1e-3)
    (mark,) = root.findall(".//{*}circle")
    place = on_axes(root, float(mark.attrib["cx"]), float(mark.attrib["cy"]))
    assert place == pytest.approx((0.1, 0.5), rel=1e-3)


def test_a_band_lies_between_its_rates():
    root = drawn(PlottedCurve("acf", "#000", CURVE, band=[(0.2, 0.8)] * len(GRID_FPPI)))
    band = corners(root, "polygon")
    assert {round(rate, 3) for _, rate in band} == {0.2, 0.8}
    assert [min(band)[0], max(band)[0]] == pytest.approx([0.005, 20.0], rel=2e-3)


def test_names_are_text_and_every_curve_has_one():
    root = drawn(PlottedCurve("a < b & c", "#000", CURVE), PlottedCurve("plain", "#111", CURVE))
    texts = [text.text for text in root.iterfind(".//{*}text")]
    assert {"a < b & c", "plain"} <= set(texts)
    assert len(root.findall(".//{*}polyline")) == 2


def test_without_vehicles_there_is_no_line():
    nothing = DetectionCurve(np.array([3.0]), np.array([False]), 0, 10)
    assert math.isnan(nothing.points()[0].detection_rate)
    for line in drawn(PlottedCurve("acf", "#000", nothing, nothing.at_threshold(2.0))).iter():
        assert "nan" not in " ".join(line.attrib.values())
