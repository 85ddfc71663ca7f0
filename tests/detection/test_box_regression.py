"""Box regression: its target and its use are inverse; ridge regression minimises what it says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.box_regression import LARGEST_ENLARGEMENT, box_offsets, fit_regressor, regressed_boxes
from fcw.detection.model import BoxRegressor

near = st.floats(-0.3, 0.3)


def constant_regressor(offsets: np.ndarray, bottom: float = 0.0) -> BoxRegressor:
    return BoxRegressor(np.zeros((6, 3), np.float32), offsets.astype(np.float32), bottom)


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
    placements = np.array([[middle, bottom, size]])
    again = regressed_boxes(constant_regressor(found[0], dy), np.zeros((1, 6), np.uint8), placements)
    np.testing.assert_allclose(again, box, atol=1e-4 * size)


def test_no_box_grows_or_shrinks_beyond_the_limit():
    placements = np.array([[100.0, 100.0, 40.0]])
    for sign in (-1, 1):
        regressor = constant_regressor(np.array([0, 9.0 * sign, 9.0 * sign]))
        box = regressed_boxes(regressor, np.zeros((1, 6), np.uint8), placements)[0]
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
