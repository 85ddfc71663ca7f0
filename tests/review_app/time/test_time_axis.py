"""Where moments stand along the page's axes of time."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw_viz.review_app.drive import duration_text, time_text
from fcw_viz.review_app.time.axis import TICK_GAP_PX, TimeAxis, window_around

durations = st.floats(1.0, 40_000.0)


@given(durations, st.floats(0, 1), st.none() | st.floats(0.5, 10_000))
def test_a_window_holds_its_moment_and_stays_in_the_drive(duration_s, part, window_s):
    time_s = part * duration_s
    start_s, end_s = window_around(time_s, window_s, duration_s)
    assert -1e-9 <= start_s <= time_s + 1e-6
    assert time_s - 1e-6 <= end_s <= duration_s + 1e-6
    assert end_s - start_s == pytest.approx(min(window_s or duration_s, duration_s))


@given(st.floats(0, 5000), st.floats(0.5, 40_000), st.floats(100, 3000))
def test_ticks_are_on_the_axis_and_leave_room_for_their_words(start_s, span_s, width_px):
    axis = TimeAxis(start_s, start_s + span_s, width_px)
    ticks_s = axis.ticks_s()
    assert all(start_s - 1e-6 * span_s <= tick_s <= start_s + span_s * (1 + 1e-6) for tick_s in ticks_s)
    steps = [later - earlier for earlier, later in pairwise(ticks_s)]
    assert all(axis.x(start_s + step) >= min(TICK_GAP_PX, width_px) * 0.999 for step in steps)


@pytest.mark.parametrize(
    ("time_s", "decimals", "text"),
    [
        (7.46, 1, "7.5 s"),
        (59.96, 1, "1:00.0"),
        (67.5, 1, "1:07.5"),
        (3727.5, 2, "1:02:07.50"),
        (600, 0, "10:00"),
        (-0.01, 1, "0.0 s"),
    ],
)
def test_moments_in_words(time_s: float, decimals: int, text: str):
    assert time_text(time_s, decimals) == text


@pytest.mark.parametrize(("duration_s", "text"), [(40, "40 s"), (754, "13 min"), (5400, "1.5 h")])
def test_durations_in_words(duration_s: float, text: str):
    assert duration_text(duration_s) == text
