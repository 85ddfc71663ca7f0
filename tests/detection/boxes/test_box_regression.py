"""Box regression: its target and its use are inverse; ridge regression minimises what it says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.boxes.regression import LARGEST_ENLARGEMENT, box_offsets, fit_regressor, place_box
from fcw.detection.model import BoxRegressor

near = st.floats(-0.3, 0.3)


def constant_regressor(offsets: np.ndarray, bottom: float = 0.0) -> BoxRegressor:
    return BoxRegressor(np.zeros((6, 3), np.float32), offsets.astype(np.float32), bottom)


def placed(regressor: BoxRegressor, features: np.ndarray, placement: np.ndarray) -> np.ndarray:
    box, weights = np.empty(4), np.ascontiguousarray(regressor.weights.T)
    place_box(weights, regressor.constant, regressor.bottom, features, placement, box)
    return box


def plain_box(regressor: BoxRegressor, features: np.ndarray, placement: np.ndarray) -> np.ndarray:
    """`place_box` in numpy, in double precision."""
    dx, log_w, log_h = features.astype(float) @ regressor.weights.astype(float) + regressor.constant
    middle, bottom, size = placement
    w, h = size * np.exp(np.clip([log_w, log_h], -LARGEST_ENLARGEMENT, LARGEST_ENLARGEMENT))
    return np.array([middle + dx * size - w / 2, bottom + regressor.bottom * size - h, w, h])


@pytest.mark.parametrize("feature_count", [1, 40, 2560])
def test_the_kernel_agrees_with_plain_arithmetic(feature_count):
    generator = np.random.default_rng(2)
    for _ in range(20):
        weights = generator.normal(0, 0.3 / 128 / np.sqrt(feature_count), (feature_count, 3))
        regressor = BoxRegressor(
            weights.astype(np.float32), generator.normal(0, 0.1, 3).astype(np.float32), -0.02
        )
        features = generator.integers(0, 256, feature_count, np.uint8)
        placement = np.array([300.0, 200.0, 60.0])
        box = placed(regressor, features, placement)
        np.testing.assert_allclose(box, plain_box(regressor, features, placement), rtol=1e-5)


@given(
    middle=st.floats(0, 1000),
    bottom=st.floats(0, 700),
    size=st.floats(15, 300),
    offsets=st.tuples(near, near, near, near),
)
def test_a_box_comes_back_from_its_offsets(middle, bottom, size, offsets):
    dx, dy, log_w, log_h = offsets
    w, h = size * np.exp(log_w), size * np.exp(log_h)
    box = np.array([[middle + dx * size - w / 2, bottom + dy * size - h, w, h]])
    found = box_offsets(box, np.array([middle]), np.array([size]))
    np.testing.assert_allclose(found[0], [dx, log_w, log_h], atol=1e-9)
    placement = np.array([middle, bottom, size])
    again = placed(constant_regressor(found[0], dy), np.zeros(6, np.uint8), placement)
    np.testing.assert_allclose(again, box[0], atol=1e-4 * size)


def test_no_box_grows_or_shrinks_beyond_the_limit():
    placement = np.array([100.0, 100.0, 40.0])
    for sign in (-1, 1):
        regressor = constant_regressor(np.array([0, 9.0 * sign, 9.0 * sign]))
        box = placed(regressor, np.zeros(6, np.uint8), placement)
        assert box[2:] == pytest.approx([40 * np.exp(sign * LARGEST_ENLARGEMENT)] * 2)


def test_the_weights_make_the_penalised_squares_least():
    generator = np.random.default_rng(0)
    features = generator.integers(0, 256, (200, 12), np.uint8)
    offsets = generator.normal(size=(200, 3))
    ridge = 0.7
    regressor = fit_regressor(features, offsets, ridge)
    values = features.astype(float)
    centred = values - values.mean(axis=0)
    weights = regressor.weights.astype(float)
    residuals = offsets - values @ weights - regressor.constant
    # At the least, the gradient vanishes: in the weights, and in the constant.
    penalty = ridge * (centred**2).sum() / 12
    np.testing.assert_allclose(centred.T @ residuals, penalty * weights, atol=1e-2)
    np.testing.assert_allclose(residuals.mean(axis=0), 0, atol=1e-4)


def test_a_linear_law_is_found_and_more_so_with_more_windows():
    generator = np.random.default_rng(1)
    law = generator.normal(size=(12, 3)) / 300

    def error(count):
        features = generator.integers(0, 256, (count, 12), np.uint8)
        offsets = features @ law + generator.normal(0, 0.05, (count, 3))
        return np.abs(fit_regressor(features, offsets, 1e-6).weights - law).max()

    assert error(20_000) < 3e-5 < error(100)
