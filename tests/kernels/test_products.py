"""Tiles of sums of products of bytes, as a product of matrices has them."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.kernels import products
from fcw.kernels.products import (
    TILE_COLUMNS,
    TILE_ROWS,
    WORD_BYTES,
    as_weights,
    sum_products,
    sum_products_of_pairs,
    sum_products_of_signed,
)


def compiled(tile):
    """For one tile, compiled anew."""

    @numba.njit
    def one_tile(
        values, first_value, offsets, weights, first_weight, weight_pitch, sums, first_sum, sum_pitch
    ):
        tile(values, first_value, offsets, weights, first_weight, weight_pitch, sums, first_sum, sum_pitch)

    return one_tile


BYTES, SIGNED_BYTES, PAIRS = np.uint8, np.int8, np.int16
KINDS = {
    "unsigned": (sum_products, BYTES, SIGNED_BYTES),
    "signed": (sum_products_of_signed, SIGNED_BYTES, BYTES),
    "pairs": (sum_products_of_pairs, PAIRS, PAIRS),
}
"""Of tiles: what lies in the words of their values and of their weights."""
COMPILED = {kind: compiled(tile) for kind, (tile, _, _) in KINDS.items()}
FILLED = {BYTES: (0, 255), SIGNED_BYTES: (-128, 127), PAIRS: (-1024, 1023)}
"""The least and the largest number; of 60 products of larger pairs the sum might not fit a word."""


def words(random, count, number):
    """(count, numbers in a word) so many words; the outermost numbers come often."""
    least, largest = FILLED[number]
    numbers = random.integers(least, largest + 1, (count, WORD_BYTES // np.dtype(number).itemsize))
    outermost = random.random(numbers.shape) < 0.2
    numbers[outermost] = random.choice([least, largest], outermost.sum())
    return numbers.astype(number)


def check(one_tile, kind, offsets, firsts, gaps, seed):
    random = np.random.default_rng(seed)
    first_value, first_weight, first_sum = firsts
    weight_pitch, sum_pitch = TILE_ROWS + gaps[0], TILE_COLUMNS + gaps[1]
    _, of_values, of_weights = KINDS[kind]
    values = words(random, first_value + max(offsets) + TILE_COLUMNS, of_values)
    weights = words(random, first_weight + len(offsets) * weight_pitch, of_weights)
    sums = np.full(first_sum + TILE_ROWS * sum_pitch, -1, np.int32)
    places = np.array(offsets)
    one_tile(
        values.reshape(-1).view(np.int32),
        first_value,
        places,
        as_weights(weights) if of_weights is SIGNED_BYTES else weights.reshape(-1).view(np.int32),
        first_weight,
        weight_pitch,
        sums,
        first_sum,
        sum_pitch,
    )
    rows = values[first_value + places[:, None] + np.arange(TILE_COLUMNS)].astype(int)
    columns = weights[first_weight:].reshape(len(offsets), weight_pitch, -1)[:, :TILE_ROWS].astype(int)
    tile = sums[first_sum:].reshape(TILE_ROWS, sum_pitch)
    assert np.array_equal(tile[:, :TILE_COLUMNS], np.einsum("krb,kcb->rc", columns, rows))
    assert (tile[:, TILE_COLUMNS:] == -1).all()
    assert (sums[:first_sum] == -1).all()


@given(
    kind=st.sampled_from(list(KINDS)),
    offsets=st.lists(st.integers(0, 200), min_size=1, max_size=60),
    firsts=st.tuples(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40)),
    gaps=st.tuples(st.integers(0, 9), st.integers(0, 9)),
    seed=st.integers(0, 99),
)
def test_a_tile_is_a_product_of_matrices_and_nothing_beside_it_is_written(kind, offsets, firsts, gaps, seed):
    check(COMPILED[kind], kind, offsets, firsts, gaps, seed)


@pytest.mark.parametrize("lacking", [("ONE_INSTRUCTION",), ("ONE_INSTRUCTION", "PAIRS")])
@pytest.mark.parametrize("kind", KINDS)
def test_processors_that_lack_the_instructions_come_to_the_same_sums(lacking, kind, monkeypatch):
    for name in lacking:
        monkeypatch.setattr(products, f"_HAS_{name}", False)
    one_tile = compiled(KINDS[kind][0])
    for seed in range(20):
        check(one_tile, kind, [0, 7, 100, 7, seed], (3, 5, 2), (1, 2), seed)


@pytest.mark.parametrize(
    "told", [{"NUMBA_CPU_NAME": "generic"}, {"NUMBA_CPU_NAME": "haswell"}, {"NUMBA_CPU_FEATURES": "+sse2"}]
)
def test_sums_are_the_same_for_a_processor_that_numba_was_told_of(told):
    # In a process of its own: numba reads this once, and LLVM ends it where an instruction is missing.
    program = (
        "import test_products as t\n"
        "for kind, tile in t.COMPILED.items():\n"
        "    t.check(tile, kind, [0, 7], (3, 5, 2), (1, 2), 0)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parent,
        env=os.environ | told,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
