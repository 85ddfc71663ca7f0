"""Latencies count from the picture's coming to the program."""

import math

import pytest

from fcw_viz.live_app.latency import REMEMBERED, LatencyMeter


def test_nothing_is_known_at_first():
    figures = LatencyMeter().figures
    assert math.isnan(figures.result_s)
    assert math.isnan(figures.drawn_s)
    assert figures.words() == "result –, on the screen –"


def test_medians_and_worst_of_results_and_drawn_pictures():
    meter = LatencyMeter()
    for number, (result_s, drawn_s) in enumerate([(0.020, 0.050), (0.030, 0.090), (0.100, 0.400)]):
        captured_s = 100.0 + number
        meter.sent(captured_s, captured_s + result_s)
        meter.drawn(captured_s + drawn_s)
    figures = meter.figures
    assert (figures.result_s, figures.result_worst_s) == pytest.approx((0.030, 0.100))
    assert (figures.drawn_s, figures.drawn_worst_s) == pytest.approx((0.090, 0.400))
    assert figures.words() == "result 30 ms (at most 100), on the screen 90 ms (at most 400)"


def test_a_picture_that_the_browser_never_confirms_is_not_counted():
    meter = LatencyMeter()
    meter.sent(10.0, 10.02)
    meter.given_up()
    meter.drawn(12.0)
    assert math.isnan(meter.figures.drawn_s)
    meter.sent(13.0, 13.02)
    meter.drawn(13.1)
    meter.drawn(15.0)  # said twice
    assert meter.figures.drawn_worst_s == pytest.approx(0.1)


def test_only_the_last_pictures_count():
    meter = LatencyMeter()
    meter.sent(0.0, 9.0)
    meter.drawn(9.0)
    for number in range(REMEMBERED):
        meter.sent(10.0 + number, 10.01 + number)
        meter.drawn(10.02 + number)
    assert meter.figures.result_worst_s == pytest.approx(0.01)
    assert meter.figures.drawn_worst_s == pytest.approx(0.02)
