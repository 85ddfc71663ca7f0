"""More than three points, and priors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian, GroundPoint, Priors
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import _Fit, calibrate, row_jacobian
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
TRUTH = GroundPlaneCamera(0.06, 1000, 370, 1.3, 639.5)
FIELD_OF_VIEW = Gaussian(2 * math.atan(640 / 1000), 0.05)
PRINCIPAL_ROW = Gaussian(370, 20)
HORIZON_ROW = Gaussian(TRUTH.horizon_row_px, 2)


def points_at(*distances_m: float) -> list[GroundPoint]:
    return [GroundPoint(d, TRUTH.row_at(d)) for d in distances_m]


@given(
    st.floats(-0.1, 0.35),
    st.floats(400, 2000),
    st.floats(0.8, 3.0),
    st.integers(4, 8),
)
def test_exact_rows_of_many_points_give_the_camera_back(pitch_rad, focal_px, height_m, count):
    truth = GroundPlaneCamera(pitch_rad, focal_px, 359.5, height_m, 639.5)
    points = [GroundPoint(float(d), truth.row_at(float(d))) for d in np.geomspace(6, 45, count)]
    # Clicks of a hundredth of a pixel leave nothing to what is believed of every lens.
    size = ImageSize(1280, 1440)
    calibration = calibrate(points, size, height_m, row_sigma_px=1e-5, tape_error=0.0)
    for distance_m in (5.0, 20.0, 50.0):
        assert calibration.distance_at(truth.row_at(distance_m)) == pytest.approx(distance_m, rel=1e-6)
    assert calibration.residuals_px == pytest.approx([0] * count, abs=1e-6)


@pytest.mark.parametrize(
    ("points", "priors"),
    [
        (points_at(5, 30), {"principal_row": PRINCIPAL_ROW}),
        (points_at(5, 30), {"horizon_row": HORIZON_ROW, "principal_row": PRINCIPAL_ROW}),
        (points_at(8), {"field_of_view": FIELD_OF_VIEW, "principal_row": PRINCIPAL_ROW}),
        (points_at(8), {"horizon_row": HORIZON_ROW, "principal_row": PRINCIPAL_ROW}),
        ([], {"field_of_view": FIELD_OF_VIEW, "horizon_row": HORIZON_ROW, "principal_row": PRINCIPAL_ROW}),
    ],
)
def test_priors_replace_points(points, priors):
    calibration = calibrate(points, SIZE, 1.3, **({"field_of_view": FIELD_OF_VIEW} | priors))
    # What is believed of every camera's pitch pulls by a small part of what a click of a pixel leaves open.
    assert calibration.camera.pitch_rad == pytest.approx(0.06, abs=5e-4)
    assert calibration.camera.focal_y_px == pytest.approx(1000, rel=1e-3)
    low_m, high_m = calibration.distance_interval(TRUTH.row_at(20.0))
    assert low_m < 20 < high_m < math.inf


def test_prior_of_the_principal_row_halves_the_far_error_of_three_clicks():
    """The notes: 8.5 % to 4.2 % at 50 m for clicks at 5, 10, 20 m with v0 fixed."""
    truth = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)
    points = [GroundPoint(d, truth.row_at(d)) for d in (5.0, 10.0, 20.0)]

    def relative_error(principal_row: Gaussian | None = None) -> float:
        if principal_row is None:
            calibration = calibrate(points, SIZE, 1.225, tape_error=0.0, exact=True)
        else:
            lens = Gaussian(2 * math.atan(640 / 1100), 10.0)
            calibration = calibrate(points, SIZE, 1.225, 0.0, 1.0, lens, principal_row, tape_error=0.0)
        low_m, high_m = calibration.distance_interval(truth.row_at(50.0))
        return (high_m - low_m) / 2 / 50

    assert relative_error() == pytest.approx(0.085, abs=0.004)
    assert relative_error(Gaussian(359.5, 0.001)) == pytest.approx(0.042, abs=0.004)


def test_prior_pulls_by_its_sigma():
    points = points_at(5, 9, 20)
    believed = TRUTH.horizon_row_px + 6
    horizons = [
        calibrate(
            points, SIZE, 1.3, 0.0, 1.0, FIELD_OF_VIEW, PRINCIPAL_ROW, Gaussian(believed, sigma)
        ).horizon_row_px
        for sigma in (1e-3, 2.0, 1e3)
    ]
    assert horizons[0] == pytest.approx(believed, abs=1e-3)
    assert horizons[2] == pytest.approx(TRUTH.horizon_row_px, abs=0.02)  # the pull of every camera's pitch
    assert TRUTH.horizon_row_px + 0.1 < horizons[1] < believed - 0.1


def test_one_wrong_click_among_five_keeps_its_residual():
    points = points_at(5, 8, 13, 21, 34)
    points[2] = GroundPoint(13.0, points[2].row_px + 10)
    calibration = calibrate(points, SIZE, 1.3)
    assert int(np.argmax(np.abs(calibration.residuals_px))) == 2
    assert calibration.residuals_px[2] > 5


def test_repeated_clicks_on_one_mark_count_as_more_information():
    once = calibrate(points_at(5, 10, 30, 40), SIZE, 1.3)
    twice = calibrate(points_at(5, 10, 30, 40, 40), SIZE, 1.3)
    row_px = TRUTH.row_at(60.0)
    widths_m = [high - low for low, high in (c.distance_interval(row_px) for c in (once, twice))]
    assert widths_m[1] < widths_m[0]


def test_far_points_out_of_order_by_their_noise_are_averaged():
    points = points_at(6, 12, 25)
    row_px = TRUTH.row_at(45.0)
    calibration = calibrate([*points, GroundPoint(44, row_px), GroundPoint(46, row_px + 0.5)], SIZE, 1.3)
    assert calibration.distance_at(row_px) == pytest.approx(45.0, rel=0.03)


def test_jacobian_of_the_rows_agrees_with_finite_differences():
    distances_m = np.array([4.0, 11.0, 60.0])
    step = 1e-6

    def rows(tangent: float, log_focal: float, horizon_px: float) -> np.ndarray:
        focal_px = math.exp(log_focal)
        camera = GroundPlaneCamera(math.atan(tangent), focal_px, horizon_px + focal_px * tangent, 1.3, 0)
        return camera.row_at(distances_m)

    at = np.array([math.tan(0.06), math.log(1000), TRUTH.horizon_row_px])
    expected = np.column_stack(
        [(rows(*(at + step * unit)) - rows(*(at - step * unit))) / (2 * step) for unit in np.eye(3)]
    )
    assert row_jacobian(TRUTH, distances_m) == pytest.approx(expected, rel=1e-5, abs=1e-4)


def test_jacobian_of_the_fit_agrees_with_finite_differences():
    priors = Priors(FIELD_OF_VIEW, PRINCIPAL_ROW, HORIZON_ROW)
    distances_m = np.array([4.0, 11.0, 60.0])
    fit = _Fit(distances_m, TRUTH.row_at(distances_m) + 3, SIZE, 1.3, 0.7, priors)
    at, step = np.array([0.11, math.log(900), 301.0]), 1e-6
    expected = np.column_stack(
        [
            (fit.residuals(at + step * unit) - fit.residuals(at - step * unit)) / (2 * step)
            for unit in np.eye(3)
        ]
    )
    assert expected.shape == (6, 3)
    assert fit.jacobian(at) == pytest.approx(expected, rel=1e-5, abs=1e-4)


def test_what_every_lens_has_makes_up_for_near_clicks():
    """Without it three clicks at 4, 5, 7 m leave 40 m open: 29.9 to 64.1 m (notes)."""
    near = [GroundPoint(d, TRUTH.row_at(d)) for d in (4.0, 5.0, 7.0)]
    free = calibrate(near, SIZE, 1.3, tape_error=0.0, exact=True)
    usual = calibrate(near, SIZE, 1.3, tape_error=0.0)
    widths = []
    for calibration in (free, usual):
        low_m, high_m = calibration.distance_interval(TRUTH.row_at(40.0))
        widths.append(high_m - low_m)
    assert widths[1] < widths[0] / 3
    assert usual.assumed.count == 2
    assert free.assumed.count == 0


def test_a_tape_that_errs_widens_every_interval_of_the_clicked_distances():
    points = points_at(6, 15, 40)
    for distance_m in (6.0, 15.0, 40.0):
        widths = [
            high_m - low_m
            for tape_error in (0.0, 0.01, 0.05)
            for low_m, high_m in (
                calibrate(points, SIZE, 1.3, tape_error=tape_error).distance_interval(
                    TRUTH.row_at(distance_m)
                ),
            )
        ]
        assert widths[0] < widths[1] < widths[2]


@pytest.mark.parametrize("tape_error", [-0.01, 0.5, math.nan])
def test_an_error_of_the_tape_without_meaning_is_refused(tape_error):
    with pytest.raises(UserError, match=r"tape error .*: expected a part of the distance from 0 to 0\.5"):
        calibrate(points_at(6, 15, 40), SIZE, 1.3, tape_error=tape_error)


def test_the_exact_solution_takes_three_points_and_nothing_else():
    with pytest.raises(UserError, match="takes 3 points, not 4"):
        calibrate(points_at(6, 9, 15, 40), SIZE, 1.3, exact=True)
    with pytest.raises(UserError, match="takes 3 points and nothing else of the camera"):
        calibrate(points_at(6, 15, 40), SIZE, 1.3, principal_row=PRINCIPAL_ROW, exact=True)


def test_rows_alone_leave_open_how_the_camera_is_turned_besides():
    """Which a file must not call known: a camera put up by eye looks aside by degrees."""
    turned = calibrate(points_at(6.0, 15.0, 40.0), SIZE, 1.3).orientation
    assert (turned.yaw_rad, turned.roll_rad) == (0.0, 0.0)
    assert math.degrees(turned.yaw_sigma_rad) == pytest.approx(5.0)
    assert math.degrees(turned.roll_sigma_rad) == pytest.approx(1.5)
