"""The measuring tool against the simulation's camera, Calibration's interval, and sampling."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.solve import calibrate
from fcw.frame import ImageSize
from fcw.simulation.drive import true_calibration
from fcw.simulation.world.scenario import load_scenario
from fcw_viz.calibrate_app.measure import (
    GroundLength,
    GroundMeasurement,
    length_words,
    measure_length,
    measure_point,
    point_words,
)

SIMULATED = true_calibration(load_scenario("demo"))
SIGMA_PX = 0.7


def measured(calibration: Calibration, column_px: float, row_px: float) -> GroundMeasurement:
    point = measure_point(calibration, column_px, row_px, SIGMA_PX)
    assert point is not None
    return point


@given(st.floats(3, 150), st.floats(-20, 20))
def test_a_point_placed_by_the_simulations_camera_measures_where_it_is(distance_m: float, lateral_m: float):
    camera, offset_m = load_scenario("demo").camera.camera(), SIMULATED.reference_offset_m
    column_px = camera.column_at(lateral_m, distance_m + offset_m)
    row_px = camera.row_at(distance_m + offset_m)
    exact = Calibration.from_camera(camera, SIMULATED.image_size, offset_m)
    point = measured(exact, column_px, row_px)
    assert point.distance_m == pytest.approx(distance_m, abs=1e-9)
    assert point.lateral_m == pytest.approx(lateral_m, abs=1e-9)


@pytest.mark.parametrize("row_px", [720.0, 500.0, 400.0, 345.0, 331.0])
def test_the_interval_is_the_calibrations_with_the_clicks_own_noise(row_px: float):
    point = measured(SIMULATED, 600.0, row_px)
    assert (point.low_m, point.high_m) == SIMULATED.distance_interval(row_px, SIGMA_PX)
    assert point.low_m < point.distance_m < point.high_m
    bare = SIMULATED.distance_interval(row_px)
    assert point.low_m < bare[0]
    assert point.high_m >= bare[1]


@pytest.mark.parametrize("above_px", [0.0, 0.1, 300.0])
def test_sky_has_no_distance(above_px: float):
    assert measure_point(SIMULATED, 640.0, SIMULATED.horizon_row_px - above_px, SIGMA_PX) is None


def test_a_length_is_the_difference_of_two_points():
    places = ((8.0, 1.5), (17.0, -2.0))
    start, end = (
        measured(SIMULATED, SIMULATED.column_at(lateral_m, distance_m), SIMULATED.row_at(distance_m))
        for distance_m, lateral_m in places
    )
    length = measure_length(SIMULATED, start, end, SIGMA_PX)
    assert length.along_m == pytest.approx(9.0, abs=1e-9)
    assert length.across_m == pytest.approx(-3.5, abs=1e-9)
    assert length.total_m == pytest.approx(math.hypot(9.0, 3.5), abs=1e-9)
    back = measure_length(SIMULATED, end, start, SIGMA_PX)
    assert back.along_m == pytest.approx(-9.0, abs=1e-9)
    assert back.along_sigma_m == pytest.approx(length.along_sigma_m)


@pytest.mark.slow
def test_the_lengths_sigma_is_what_new_clicks_of_everything_would_scatter():
    size, height_m, click_px = ImageSize(1280, 720), 1.3, 0.3
    distances_m = np.array([6.0, 15.0, 30.0])
    camera = load_scenario("demo").camera.camera()
    rows_px = camera.row_at(distances_m)
    clicks_px = camera.row_at(np.array([10.0, 19.0]))

    def calibrated(noise_px: np.ndarray) -> Calibration:
        points = [GroundPoint(d, v) for d, v in zip(distances_m, rows_px + noise_px, strict=True)]
        return calibrate(tuple(points), size, height_m, row_sigma_px=click_px, tape_error=0.0, exact=True)

    generator = np.random.default_rng(4)
    lengths_m = []
    for _ in range(3000):
        noisy = calibrated(generator.normal(0, click_px, 3))
        near_m, far_m = noisy.distance_at(clicks_px + generator.normal(0, click_px, 2))
        lengths_m.append(far_m - near_m)
    calibration = calibrated(np.zeros(3))
    start, end = (measured(calibration, 640.0, float(row_px)) for row_px in clicks_px)
    length = measure_length(calibration, start, end, click_px)
    # Of 3000 draws the standard deviation is known to 1.3 %; what is left is the second order.
    assert length.along_sigma_m == pytest.approx(float(np.std(lengths_m)), rel=0.06)


def test_words_of_a_point():
    point = GroundMeasurement(0, 0, 23.44, 22.91, 24.02, 1.23)
    assert point_words(point) == "23.4 m (22.9 to 24.0), 1.2 m to the left"
    assert point_words(replace(point, lateral_m=-0.6)) == "23.4 m (22.9 to 24.0), 0.6 m to the right"
    assert point_words(replace(point, lateral_m=0.01)) == "23.4 m (22.9 to 24.0), straight ahead"
    assert point_words(replace(point, lateral_m=0), imperial=True) == "76.9 ft (75.2 to 78.8), straight ahead"
    far = replace(point, distance_m=130.2, low_m=71.3, high_m=math.inf)
    assert point_words(far) == "130 m (71 and beyond), 1.2 m to the left"
    assert point_words(None) == "above the horizon: sky"


def test_words_of_a_length():
    assert length_words(GroundLength(9.04, 0.21, 0.44)) == (
        "9.0 ± 0.2 m along the road, 0.4 m to the left, 9.1 m in all"
    )
    assert (
        length_words(GroundLength(-50.3, 6.2, -0.01)) == "50 ± 6 m along the road, none across, 50 m in all"
    )
    assert length_words(GroundLength(0.0, math.inf, 2.0)) == (
        "too far away to say how far apart, 2.0 m to the left"
    )
