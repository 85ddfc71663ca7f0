"""Where two lane markings meet is the horizon, and as well known as their clicks."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.vanishing import Segment, combined, vanishing_row
from fcw.errors import UserError

CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)


def marking(lateral_m: float, near_m: float, far_m: float) -> Segment:
    near, far = ((CAMERA.column_at(lateral_m, d), CAMERA.row_at(d)) for d in (near_m, far_m))
    return near, far


def segment(ends: np.ndarray) -> Segment:
    (left, top), (right, bottom) = ends.tolist()
    return (left, top), (right, bottom)


@given(st.floats(0.5, 4), st.floats(-4, -0.5), st.floats(3, 10), st.floats(12, 60))
def test_markings_of_a_straight_lane_meet_at_the_horizon(left_m, right_m, near_m, far_m):
    horizon = vanishing_row(marking(left_m, near_m, far_m), marking(right_m, near_m + 1, far_m), 0.01)
    assert horizon.value == pytest.approx(CAMERA.horizon_row_px, abs=1e-6)


@pytest.mark.parametrize("far_m", [12.0, 25.0, 50.0])
def test_the_error_is_what_noisy_clicks_give(far_m):
    lines = np.array([marking(1.8, 6.0, far_m), marking(-1.8, 7.0, far_m)])
    stated = vanishing_row(segment(lines[0]), segment(lines[1]), 0.3)
    noise = np.random.default_rng(4)
    rows = []
    for _ in range(4000):
        first, second = lines + noise.normal(0, 0.3, lines.shape)
        rows.append(vanishing_row(segment(first), segment(second), 0.3).value)
    # 4000 draws give their standard deviation to 1.1 %; the rest is curvature.
    assert np.std(rows) == pytest.approx(stated.sigma, rel=0.05)
    assert np.mean(rows) == pytest.approx(stated.value, abs=0.2 * stated.sigma)


def test_longer_lines_know_the_horizon_better():
    short, long = (
        vanishing_row(marking(1.8, 6.0, far_m), marking(-1.8, 6.0, far_m), 1.0).sigma for far_m in (9.0, 40.0)
    )
    assert long < short / 2


def test_the_order_of_lines_and_of_their_ends_does_not_matter():
    first, second = marking(1.8, 6.0, 30.0), marking(-1.8, 7.0, 40.0)
    stated = vanishing_row(first, second, 1.0)
    for other in (
        vanishing_row(second, first, 1.0),
        vanishing_row((first[1], first[0]), second, 1.0),
        vanishing_row(first, (second[1], second[0]), 1.0),
    ):
        assert (other.value, other.sigma) == pytest.approx((stated.value, stated.sigma), rel=1e-9)


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (((100, 700), (110, 400)), ((300, 700), (310, 400)), "nearly parallel"),
        (((100, 700), (110, 400)), ((300, 700), (309, 400)), "nearly parallel"),
        (((100, 700), (100, 400)), ((100, 700), (100, 400)), "nearly parallel"),
        (((600, 700), (200, 400)), ((700, 700), (1100, 400)), "do not meet ahead"),
        (((200, 700), (900, 400)), ((900, 700), (200, 400)), "do not meet ahead"),
        (((200, 700), (200.5, 700)), ((900, 700), (700, 400)), "shorter than the error of a click"),
    ],
)
def test_lines_that_say_nothing_are_refused_with_the_mend(first, second, message):
    with pytest.raises(UserError, match=message) as error:
        vanishing_row(first, second, 1.0)
    assert "draw" in str(error.value)


ENDS = st.tuples(st.floats(0, 1279), st.floats(0, 719))


# A level line: where it meets the other one rounds to its own row.
@example(
    (0.0, 1.0),
    (406.56248570156066, 1.0),
    (420.3934866615732, 613.5633693494591),
    (827.1839353551982, 638.0),
    1.0,
)
@given(ENDS, ENDS, ENDS, ENDS, st.floats(0.05, 20))
def test_any_lines_give_a_finite_row_above_them_or_a_message(a, b, c, d, sigma_px):
    try:
        horizon = vanishing_row((a, b), (c, d), sigma_px)
    except UserError:
        return
    assert math.isfinite(horizon.value)
    assert 0 < horizon.sigma < math.inf
    assert horizon.value < min(a[1], b[1], c[1], d[1])


@given(st.floats(-500, 500), st.floats(0.1, 50), st.floats(-500, 500), st.floats(0.1, 50))
def test_two_beliefs_combine_by_inverse_variance(first, first_sigma, second, second_sigma):
    assume(first != second)
    both = combined([Gaussian(first, first_sigma), Gaussian(second, second_sigma)])
    assert both is not None
    assert min(first, second) - 1e-9 <= both.value <= max(first, second) + 1e-9
    assert both.sigma == pytest.approx(1 / math.hypot(1 / first_sigma, 1 / second_sigma))
    # The better known one pulls in proportion.
    assert (both.value - first) * second_sigma**2 == pytest.approx(
        (second - both.value) * first_sigma**2, rel=1e-6, abs=1e-6
    )


def test_no_beliefs_say_nothing():
    assert combined([]) is None
