"""The range filter against analytical motion, and its covariance against sampling."""

import math

import numpy as np
import pytest

from fcw.tracking.range_filter import MotionNoise, RangeFilter
from fcw.tracking.ranging import BoxNoise, RowMeasurement

HEIGHT_M = 1.3
FOCAL_PX = 740.0
LOG_WIDTH_SIGMA = 0.05


def width_px(distance_m):
    return FOCAL_PX * 1.8 / distance_m


def filter_at(distance_m, box_noise=None, motion=None):
    return RangeFilter(
        RowMeasurement(1 / distance_m, 0.001),
        width_px(distance_m),
        LOG_WIDTH_SIGMA,
        HEIGHT_M,
        box_noise or BoxNoise(),
        motion or MotionNoise(),
    )


@pytest.mark.parametrize("dt_s", [1 / 30, 0.1])
def test_exact_measurements_of_constant_closing_speed_are_followed(dt_s):
    range_filter = filter_at(60.0)
    distance_m = 60.0
    while distance_m > 15:
        distance_m -= 12.0 * dt_s
        range_filter.predict(dt_s)
        range_filter.update_row(RowMeasurement(1 / distance_m, 0.001), dt_s)
        range_filter.update_width(width_px(distance_m), LOG_WIDTH_SIGMA, dt_s)
    assert range_filter.distance_m == pytest.approx(distance_m, rel=0.01)
    assert range_filter.closing_speed_mps == pytest.approx(12.0, rel=0.03)


def test_prediction_alone_is_constant_closing_speed_and_tells_the_growth_of_the_picture():
    range_filter = filter_at(40.0)
    for step in range(1, 60):
        distance_m = 40.0 - 10.0 * step / 30
        range_filter.predict(1 / 30)
        range_filter.update_row(RowMeasurement(1 / distance_m, 0.001), 1 / 30)
        range_filter.update_width(width_px(distance_m), LOG_WIDTH_SIGMA, 1 / 30)
    before_m, speed_mps = range_filter.distance_m, range_filter.closing_speed_mps
    growth = range_filter.predict(0.5)
    assert range_filter.distance_m == pytest.approx(before_m - speed_mps * 0.5)
    assert range_filter.closing_speed_mps == pytest.approx(speed_mps)
    assert growth == pytest.approx(before_m / range_filter.distance_m)


def test_width_alone_gives_time_to_collision_without_knowing_the_distance():
    # The first row puts the vehicle at twice its distance: TTC must not care (Dagan 2004).
    motion = MotionNoise(bounce_sigma_rad=math.radians(3))
    range_filter = RangeFilter(
        RowMeasurement(1 / 100, 0.01), width_px(50.0), LOG_WIDTH_SIGMA, HEIGHT_M, BoxNoise(), motion
    )
    distance_m = 50.0
    for _ in range(90):
        distance_m -= 10.0 / 30
        range_filter.predict(1 / 30)
        range_filter.update_width(width_px(distance_m), LOG_WIDTH_SIGMA, 1 / 30)
    ttc_s = range_filter.distance_m / range_filter.closing_speed_mps
    assert ttc_s == pytest.approx(distance_m / 10.0, rel=0.05)


def test_one_wild_box_moves_the_distance_little():
    range_filter = filter_at(30.0)
    for _ in range(30):
        range_filter.predict(1 / 30)
        range_filter.update_row(RowMeasurement(1 / 30, 0.001), 1 / 30)
        range_filter.update_width(width_px(30.0), LOG_WIDTH_SIGMA, 1 / 30)
    range_filter.predict(1 / 30)
    range_filter.update_row(RowMeasurement(1 / 10, 0.001), 1 / 30)
    range_filter.update_width(width_px(15.0), LOG_WIDTH_SIGMA, 1 / 30)
    # The box alone says 10 to 15 m.
    assert range_filter.distance_m == pytest.approx(30.0, rel=0.1)
    assert abs(range_filter.closing_speed_mps) < 2


def sampled_errors(tracks, seconds, dt_s, seed):
    """Normalised errors of log distance and closing speed, for tracks drawn from the filter's model."""
    rng = np.random.default_rng(seed)
    motion, box_noise = MotionNoise(), BoxNoise()
    row_sigma, bounce_sigma = 0.0015, motion.bounce_sigma_rad / HEIGHT_M
    keep_box = math.exp(-dt_s / box_noise.correlation_s)
    keep_bounce = math.exp(-dt_s / motion.bounce_correlation_s)
    slope_sigma = motion.slope_sigma_rad / HEIGHT_M
    errors = []
    while len(errors) < tracks:
        distance_m, closing_mps = rng.uniform(12, 50), rng.normal(0, 5)
        edges, bounce = rng.standard_normal(2), rng.standard_normal()
        slope, drift = slope_sigma * rng.standard_normal(), 0.0
        range_filter = None
        for step in range(round(seconds / dt_s) + 1):
            if step:
                change = rng.standard_normal() * math.sqrt(motion.acceleration_psd_m2ps3 * dt_s)
                distance_m -= (closing_mps + change / 2) * dt_s
                closing_mps += change
                edges = keep_box * edges + math.sqrt(1 - keep_box**2) * rng.standard_normal(2)
                bounce = keep_bounce * bounce + math.sqrt(1 - keep_bounce**2) * rng.standard_normal()
                drift += motion.width_drift_per_sqrt_s * math.sqrt(dt_s) * rng.standard_normal()
            if distance_m < 4:
                break
            inverse = 1 / distance_m + row_sigma * edges[0] + bounce_sigma * bounce + slope
            row = RowMeasurement(inverse, row_sigma)
            width = width_px(distance_m) * math.exp(LOG_WIDTH_SIGMA * edges[1] + drift)
            if range_filter is None:
                range_filter = RangeFilter(row, width, LOG_WIDTH_SIGMA, HEIGHT_M, box_noise, motion)
                continue
            range_filter.predict(dt_s)
            range_filter.update_row(row, dt_s)
            range_filter.update_width(width, LOG_WIDTH_SIGMA, dt_s)
        else:
            assert range_filter is not None
            sigma = range_filter.log_distance_sigma
            speed_sigma = range_filter.closing_speed_sigma_mps(sigma)
            errors.append(
                (
                    math.log(range_filter.distance_m / distance_m) / sigma,
                    (range_filter.closing_speed_mps - closing_mps) / speed_sigma,
                )
            )
    return np.abs(errors)


@pytest.mark.parametrize("dt_s", [1 / 30, 0.1])
def test_one_sigma_intervals_hold_the_truth_two_times_in_three(dt_s):
    # 68 % for a perfect filter; 300 tracks scatter by 2.7 %.
    coverage = (sampled_errors(300, 3.0, dt_s, seed=7) < 1).mean(axis=0)
    assert 0.60 <= coverage[0] <= 0.76
    assert 0.60 <= coverage[1] <= 0.76
