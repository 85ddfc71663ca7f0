"""Latencies count from the picture's coming to the program."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw_viz.live_app.age import BrowserClock
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


def test_a_drawn_picture_counts_once_however_late_and_for_no_other():
    meter = LatencyMeter()
    meter.sent(10.0, 10.02)
    meter.sent(15.0, 15.02)  # another one before the browser has said anything
    meter.drawn(16.0)
    meter.drawn(17.0)  # said twice
    assert meter.figures.drawn_worst_s == pytest.approx(6.0)
    meter.sent(18.0, 18.02)
    meter.drawn(18.1)
    assert meter.figures.drawn_s == pytest.approx(6.0)  # the upper one of two


@given(
    ahead_s=st.floats(-1e5, 1e5),
    ways_s=st.lists(st.floats(0.0, 10.0), min_size=1, max_size=REMEMBERED),
)
def test_a_browsers_clock_is_known_to_within_what_the_quickest_word_took(ahead_s: float, ways_s: list[float]):
    clock = BrowserClock()
    assert not clock.known
    for number, way_s in enumerate(ways_s):
        clock.heard(number + ahead_s, number + way_s)
    error_s = clock.of_ours(100.0 + ahead_s) - 100.0
    assert error_s == pytest.approx(min(ways_s), abs=1e-6)
    assert clock.of_ours(clock.of_browser(7.0)) == pytest.approx(7.0)


def test_only_the_last_pictures_count():
    meter = LatencyMeter()
    meter.sent(0.0, 9.0)
    meter.drawn(9.0)
    for number in range(REMEMBERED):
        meter.sent(10.0 + number, 10.01 + number)
        meter.drawn(10.02 + number)
    assert meter.figures.result_worst_s == pytest.approx(0.01)
    assert meter.figures.drawn_worst_s == pytest.approx(0.02)
