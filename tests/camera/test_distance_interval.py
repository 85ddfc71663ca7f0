"""Predicted uncertainty against sampled clicks."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate, exact_camera
from fcw.camera.uncertainty import best_next_click, camera_sigmas
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
TRUTH = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)


def points_at(distances_m, noise_px: float | np.ndarray = 0.0) -> list[GroundPoint]:
    rows = TRUTH.row_at(np.array(distances_m, float)) + noise_px
    return [GroundPoint(float(d), float(row)) for d, row in zip(distances_m, rows, strict=True)]


def percentiles(samples) -> tuple[float, float]:
    low, high = np.quantile(samples, [0.16, 0.84], method="inverted_cdf")
    return low, high


exact = partial(calibrate, exact=True, tape_error=0.0)
"""Three free points, whose distances are known."""


def sampled_distances(clicked_m, sigma_px, distance_m, draws, seed) -> np.ndarray:
    """Distances that noisy three-click calibrations give the row of a distance; inf past the horizon."""
    rng = np.random.default_rng(seed)
    clicked = np.array(clicked_m, float)
    rows, row_px = TRUTH.row_at(clicked), TRUTH.row_at(distance_m)
    return np.array(
        [
            exact_camera(clicked, rows + rng.normal(0, sigma_px, 3), 1.225, 0.0).distance_at(row_px)
            for _ in range(draws)
        ]
    )


@pytest.mark.parametrize("distance_m", [10.0, 20.0, 40.0])
def test_interval_of_three_clicks_agrees_with_4000_draws_within_a_tenth(distance_m):
    calibration = exact(points_at((6, 15, 40)), SIZE, 1.225, row_sigma_px=1.0)
    low_m, high_m = calibration.distance_interval(TRUTH.row_at(distance_m))
    sampled_low_m, sampled_high_m = percentiles(sampled_distances((6, 15, 40), 1.0, distance_m, 4000, seed=1))
    assert distance_m - low_m == pytest.approx(distance_m - sampled_low_m, rel=0.1)
    assert high_m - distance_m == pytest.approx(sampled_high_m - distance_m, rel=0.1)


@pytest.mark.parametrize(
    ("clicked_m", "sigma_px", "intervals"),
    [
        ((4, 5, 7), 1.0, {10: (9.8, 10.3), 20: (17.8, 23.1), 40: (29.9, 64.1)}),
        ((5, 10, 20), 1.0, {10: (9.9, 10.1), 20: (19.7, 20.3), 40: (37.9, 42.6), 80: (69.6, 95.3)}),
        ((6, 15, 40), 1.0, {10: (9.9, 10.1), 20: (19.8, 20.2), 40: (38.9, 41.3), 80: (73.8, 88.0)}),
        ((4, 5, 7), 0.25, {10: (9.9, 10.1), 20: (19.4, 20.7), 40: (36.7, 43.9), 80: (66, 101)}),
    ],
)
def test_intervals_follow_the_sampled_table_also_where_clicks_are_ill_conditioned(
    clicked_m, sigma_px, intervals
):
    """The table of 20,000 draws in the calibration notes, printed to a decimal; its own error is 1 to 2 %."""
    calibration = exact(points_at(clicked_m), SIZE, 1.225, row_sigma_px=sigma_px)
    for distance_m, expected_m in intervals.items():
        assert calibration.distance_interval(TRUTH.row_at(float(distance_m))) == pytest.approx(
            expected_m, rel=0.012, abs=0.05
        )


def test_interval_of_near_clicks_reaches_hundreds_of_metres_at_80_m():
    low_m, high_m = exact(points_at((4, 5, 7)), SIZE, 1.225).distance_interval(TRUTH.row_at(80.0))
    assert low_m == pytest.approx(45, abs=0.5)
    assert 400 < high_m < 1000


@pytest.mark.slow
def test_interval_covers_the_truth_in_68_of_100_calibrations_of_a_row_with_noise_of_its_own():
    rng = np.random.default_rng(3)
    draws, inside = 1500, 0
    for _ in range(draws):
        calibration = exact(points_at((6, 15, 40), rng.normal(0, 1, 3)), SIZE, 1.225)
        low_m, high_m = calibration.distance_interval(TRUTH.row_at(25.0) + rng.normal(0, 1.5), 1.5)
        inside += low_m <= 25.0 <= high_m
    # Three binomial sigmas of 1500 draws are 0.036.
    assert inside / draws == pytest.approx(0.68, abs=0.036)


def test_interval_is_unbounded_at_the_horizon_and_infinite_well_above_it():
    calibration = exact(points_at((6, 15, 40)), SIZE, 1.225)
    low_m, high_m = calibration.distance_interval(calibration.horizon_row_px)
    assert 100 < low_m < math.inf
    assert high_m == math.inf
    assert calibration.distance_interval(calibration.horizon_row_px - 50) == (math.inf, math.inf)


@given(
    st.floats(-0.1, 0.3),
    st.floats(400, 2000),
    st.floats(4.0, 8.0),
    st.floats(1.2, 2.5),
    st.floats(0.1, 5.0),
    st.floats(0.0, 5.0),
    st.floats(-100, 900),
)
def test_interval_holds_the_distance_itself(
    pitch_rad, focal_px, nearest_m, ratio, sigma_px, row_sigma_px, row_px
):
    truth = GroundPlaneCamera(pitch_rad, focal_px, 359.5, 1.3, 639.5)
    points = [GroundPoint(nearest_m * ratio**k, truth.row_at(nearest_m * ratio**k)) for k in range(3)]
    calibration = exact(points, ImageSize(1280, 1440), 1.3, row_sigma_px=sigma_px)
    low_m, high_m = calibration.distance_interval(row_px, row_sigma_px)
    distance_m = calibration.distance_at(row_px)
    assert low_m <= distance_m * (1 + 1e-9) + 1e-9
    assert high_m >= distance_m * (1 - 1e-9) - 1e-9


def test_known_camera_has_an_interval_of_no_width_but_for_the_rows_own_noise():
    calibration = Calibration.from_camera(TRUTH, SIZE)
    row_px = TRUTH.row_at(30.0)
    assert calibration.distance_interval(row_px) == pytest.approx((30.0, 30.0))
    low_m, high_m = calibration.distance_interval(row_px, 2.0)
    # The row's percentiles lie 0.99446 sigmas either side, and distance is monotone in the row.
    assert low_m == pytest.approx(TRUTH.distance_at(row_px + 0.994458 * 2), rel=1e-5)
    assert high_m == pytest.approx(TRUTH.distance_at(row_px - 0.994458 * 2), rel=1e-5)
    assert calibration.distance_interval(TRUTH.horizon_row_px) == (math.inf, math.inf)


def test_row_gradient_is_the_derivative_of_the_exact_solution():
    clicked = np.array([6.0, 15.0, 40.0])
    rows = TRUTH.row_at(clicked)
    calibration = exact(points_at(clicked), SIZE, 1.225)
    distances_m = np.array([5.0, 10.0, 30.0, 80.0])
    for distance_m, gradient in zip(distances_m, calibration.row_gradients(distances_m), strict=True):
        step_px = 1e-3
        differences = [
            (
                exact_camera(clicked, rows + step_px * unit, 1.225, 0).row_at(distance_m)
                - exact_camera(clicked, rows - step_px * unit, 1.225, 0).row_at(distance_m)
            )
            / (2 * step_px)
            for unit in np.eye(3)
        ]
        assert gradient == pytest.approx(differences, rel=1e-5, abs=1e-7)


@pytest.mark.slow
def test_fit_of_five_points_and_priors_has_the_sampled_covariance():
    """Measured and believed values drawn anew each time; the distances scatter as the covariance says."""
    rng = np.random.default_rng(5)
    field_of_view = 2 * math.atan(640 / 1100)
    clicked_m, sigma_px = (6, 9, 14, 22, 35), 1.5

    def drawn(noise: float) -> Calibration:
        return calibrate(
            points_at(clicked_m, noise * rng.normal(0, sigma_px, 5)),
            SIZE,
            1.225,
            row_sigma_px=sigma_px,
            field_of_view=Gaussian(field_of_view + noise * rng.normal(0, 0.05), 0.05),
            principal_row=Gaussian(359.5 + noise * rng.normal(0, 15), 15),
            horizon_row=Gaussian(TRUTH.horizon_row_px + noise * rng.normal(0, 3), 3),
            tape_error=0.0,
        )

    true = drawn(0.0)
    draws = [drawn(1.0) for _ in range(300)]
    for distance_m in (10.0, 25.0, 60.0):
        row_px = TRUTH.row_at(distance_m)
        low_m, high_m = true.distance_interval(row_px)
        sampled_low_m, sampled_high_m = percentiles([draw.distance_at(row_px) for draw in draws])
        # A percentile of 300 draws has a standard error of 9 % of the sigma.
        assert high_m - low_m == pytest.approx(sampled_high_m - sampled_low_m, rel=0.25)
    sigmas = camera_sigmas(true)
    for name in ("pitch_rad", "focal_y_px", "principal_row_px", "horizon_row_px"):
        owner = "camera" if name != "horizon_row_px" else None
        values = [getattr(getattr(draw, owner) if owner else draw, name) for draw in draws]
        assert getattr(sigmas, name) == pytest.approx(np.std(values), rel=0.25)


def test_next_click_is_far_for_near_clicks_and_its_promise_is_kept():
    near_clicks = points_at((4, 5, 7))
    # A lens believed no better than usual, but in the right place: so noiseless clicks give the truth.
    lens = Gaussian(2 * math.atan(640 / 1100), math.radians(20))
    calibration = calibrate(near_clicks, SIZE, 1.225, field_of_view=lens)
    advice = best_next_click(calibration)
    assert advice is not None
    assert advice.distance_m > 25
    assert advice.row_px == pytest.approx(TRUTH.row_at(advice.distance_m), abs=0.1)  # the weak priors' pull
    with_it = calibrate([*near_clicks, *points_at((advice.distance_m,))], SIZE, 1.225, field_of_view=lens)
    again = best_next_click(with_it)
    assert again is not None
    assert again.error_before == pytest.approx(advice.error_after, rel=1e-3)
    for other_m in (4.0, 10.0, 20.0):
        other = best_next_click(
            calibrate([*near_clicks, *points_at((other_m,))], SIZE, 1.225, field_of_view=lens)
        )
        assert other is not None
        assert other.error_before > advice.error_after


def test_next_click_is_one_that_the_picture_shows():
    truth = GroundPlaneCamera(0.3, 1100, 359.5, 1.225, 639.5)
    points = [GroundPoint(d, truth.row_at(d)) for d in (4.0, 5.0, 7.0)]
    advice = best_next_click(calibrate(points, SIZE, 1.225))
    assert advice is not None
    assert -0.5 <= advice.row_px <= 719.5


def test_nothing_to_advise_where_nothing_is_uncertain():
    assert best_next_click(Calibration.from_camera(TRUTH, SIZE)) is None


def test_what_is_ahead_of_the_reference_is_not_also_behind_it():
    """Of a calibration that knows next to nothing, and of one whose bumper is 2 m ahead of the camera."""
    vague = ((4e4, 0.0, 0.0), (0.0, 4e4, 0.0), (0.0, 0.0, 4e4))
    for offset_m in (0.0, 2.0):
        known = Calibration.from_camera(TRUTH, SIZE, offset_m)
        for calibration in (known, replace(known, covariance=vague)):
            for distance_m in (0.1, 1.0, 10.0, 80.0, 1000.0):
                low_m, _ = calibration.distance_interval(calibration.row_at(distance_m))
                assert 0 <= low_m <= 1.001 * distance_m, (offset_m, distance_m)
            if offset_m:
                low_m, _ = calibration.distance_interval(calibration.row_at(-0.5))
                assert low_m <= -0.499
