"""The picture of a curve shows the curve."""

import math
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from fcw.detection.matching import DetectionCurve
from fcw_viz.charts.detection_curve import GRID_FPPI, HEIGHT, LEFT, TOP, WIDTH, PlottedCurve, svg_curve

CURVE = DetectionCurve(np.array([3.0, 2.0, 1.0]), np.array([True, False, True]), 2, 10)


def position(fppi, rate):
    """The axis runs from 0.005 to 20 false positives per image, logarithmically."""
    return LEFT + WIDTH * math.log(fppi / 0.005) / math.log(4000), TOP + HEIGHT * (1 - rate)


def points(element):
    return [tuple(map(float, pair.split(","))) for pair in element.attrib["points"].split()]


def test_the_line_is_a_staircase_through_all_thresholds():
    root = ElementTree.fromstring(svg_curve([PlottedCurve("acf", "#000", CURVE, CURVE.at_threshold(2.0))]))
    (line,) = root.findall("polyline")
    corners = [(0.005, 0), (0.005, 0), (0.005, 0.5), (0.1, 0.5), (0.1, 0.5), (0.1, 0.5), (0.1, 1), (20, 1)]
    drawn = [point for number, point in enumerate(points(line)) if point not in points(line)[:number]]
    expected = [position(*corner) for number, corner in enumerate(corners) if corner not in corners[:number]]
    assert np.array(drawn) == pytest.approx(np.array(expected), abs=0.06)
    (mark,) = root.findall("circle")
    assert (float(mark.attrib["cx"]), float(mark.attrib["cy"])) == pytest.approx(position(0.1, 0.5), abs=0.06)


def test_a_band_lies_between_its_rates():
    band = [(0.2, 0.8)] * len(GRID_FPPI)
    root = ElementTree.fromstring(svg_curve([PlottedCurve("acf", "#000", CURVE, band=band)]))
    (polygon,) = root.findall("polygon")
    assert {y for _, y in points(polygon)} == {round(position(1, rate)[1], 1) for rate in (0.2, 0.8)}


def test_names_are_text_and_every_curve_has_one():
    drawn = svg_curve([PlottedCurve("a < b & c", "#000", CURVE), PlottedCurve("plain", "#111", CURVE)])
    texts = [element.text for element in ElementTree.fromstring(drawn).findall("text")]
    assert "a < b & c" in texts
    assert "plain" in texts
    assert len(re.findall("<polyline", drawn)) == 2
