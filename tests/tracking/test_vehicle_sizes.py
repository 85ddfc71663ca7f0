"""Kinds of vehicles: evidence and the swap of priors, against the exact product of Gaussians."""

import math

import numpy as np
import pytest

from fcw.tracking.range.model import RangeModel, VehicleKind
from fcw.tracking.vehicle_sizes import SizePrior

CAR = VehicleKind(0.9, 1.7, 0.08, 1.5, 0.1)
LORRY = VehicleKind(0.1, 2.6, 0.1, 3.4, 0.15)
MODEL = RangeModel(rears=(CAR, LORRY), turned=())
PRIOR = SizePrior(MODEL, with_height=True, at_tyres=False)


def posterior(kind, seen, sigma):
    """Mean and covariance of log sizes after seeing them with independent noise."""
    prior = np.array([math.log(kind.width_m), math.log(kind.height_m)])
    weights = np.array([kind.width_sigma, kind.height_sigma]) ** -2.0
    precision = weights + sigma**-2.0
    mean = (weights * prior + np.array(seen) * sigma**-2.0) / precision
    return mean, precision


def test_the_swap_gives_the_posterior_of_the_other_prior():
    seen = (math.log(2.5), math.log(3.3))
    mean, precision = posterior(CAR, seen, 0.1)
    swap = PRIOR.likelier(0, (mean[0], mean[1]), ((1 / precision[0], 0.0), (0.0, 1 / precision[1])))
    assert swap is not None
    assert swap.kind == 1
    expected_mean, expected_precision = posterior(LORRY, seen, 0.1)
    assert precision + swap.precision == pytest.approx(expected_precision)
    information = precision * mean + swap.information
    assert information / expected_precision == pytest.approx(expected_mean)


@pytest.mark.parametrize("sizes", [(1.7, 1.5), (1.85, 1.6), (1.5, 1.4)])
def test_a_car_stays_a_car(sizes):
    mean, precision = posterior(CAR, tuple(map(math.log, sizes)), 0.1)
    covariance = ((1 / precision[0], 0.0), (0.0, 1 / precision[1]))
    assert PRIOR.likelier(0, (mean[0], mean[1]), covariance) is None


def test_nothing_seen_changes_nothing():
    covariance = ((CAR.width_sigma**2, 0.0), (0.0, CAR.height_sigma**2))
    assert PRIOR.likelier(0, (math.log(1.7), math.log(1.5)), covariance) is None


def test_at_first_sight_the_shape_of_the_box_tells_the_kind():
    focal_px, depth_m = 700.0, 40.0
    for kind, truth in enumerate((CAR, LORRY)):
        width_px, height_px = focal_px * truth.width_m / depth_m, focal_px * truth.height_m / depth_m
        found, found_m = PRIOR.first_sight(
            (math.log(focal_px / width_px), 0.05), (math.log(focal_px / height_px), 0.05), None, 1000.0
        )
        assert found == kind
        assert found_m == pytest.approx(depth_m, rel=0.02)


def test_without_heights_the_row_tells_the_kind():
    prior = SizePrior(MODEL, with_height=False, at_tyres=False)
    focal_px, depth_m, scale_m_px = 700.0, 15.0, 1000.0
    width_px = focal_px * LORRY.width_m / depth_m
    by_width = math.log(focal_px / width_px), 0.03
    kind, found_m = prior.first_sight(by_width, None, (scale_m_px / depth_m, 4.0), scale_m_px)
    assert kind == 1
    assert found_m == pytest.approx(depth_m, rel=0.05)
