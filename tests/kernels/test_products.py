"""Tiles of sums of products, as a product of matrices has them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fcw.kernels.jit import kernel
from fcw.kernels.products import TILE_COLUMNS, TILE_ROWS, sum_products


@kernel()
def _one_tile(
    values: np.ndarray,
    first_value: int,
    offsets: np.ndarray,
    weights: np.ndarray,
    first_weight: int,
    weight_pitch: int,
    sums: np.ndarray,
    first_sum: int,
    sum_pitch: int,
) -> None:
    sum_products(
        values, first_value, offsets, weights, first_weight, weight_pitch, sums, first_sum, sum_pitch
    )


@given(
    offsets=st.lists(st.integers(0, 200), min_size=1, max_size=60),
    firsts=st.tuples(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40)),
    gaps=st.tuples(st.integers(0, 9), st.integers(0, 9)),
    seed=st.integers(0, 99),
)
def test_a_tile_is_a_product_of_matrices_and_nothing_beside_it_is_written(offsets, firsts, gaps, seed):
    random = np.random.default_rng(seed)
    first_value, first_weight, first_sum = firsts
    weight_pitch, sum_pitch = TILE_ROWS + gaps[0], TILE_COLUMNS + gaps[1]
    values = random.normal(size=first_value + max(offsets) + TILE_COLUMNS).astype(np.float32)
    weights = random.normal(size=first_weight + len(offsets) * weight_pitch).astype(np.float32)
    sums = np.full(first_sum + TILE_ROWS * sum_pitch, np.nan, np.float32)
    places = np.array(offsets)
    _one_tile(values, first_value, places, weights, first_weight, weight_pitch, sums, first_sum, sum_pitch)
    rows = values[first_value + places[:, None] + np.arange(TILE_COLUMNS)]
    columns = weights[first_weight:].reshape(-1, weight_pitch)[:, :TILE_ROWS]
    tile = sums[first_sum:].reshape(TILE_ROWS, sum_pitch)
    np.testing.assert_allclose(tile[:, :TILE_COLUMNS], columns.T @ rows, rtol=1e-5, atol=1e-4)
    assert np.isnan(tile[:, TILE_COLUMNS:]).all()
    assert np.isnan(sums[:first_sum]).all()
