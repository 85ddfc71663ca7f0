"""The cheapest way to give rows their columns."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.optimize import linear_sum_assignment

from fcw.kernels.assignment import assign
from fcw.tracking.association import NEVER

COSTS = arrays(
    np.float64,
    array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=9),
    elements=st.one_of(st.floats(-2.0, 2.0), st.integers(0, 3).map(float), st.just(NEVER)),
)


@given(COSTS)
def test_as_many_pairs_as_there_can_be_cost_no_more_than_scipys(cost):
    pairs = assign(cost)
    rows, columns = [row for row, _ in pairs], [column for _, column in pairs]
    assert len(pairs) == min(cost.shape)
    assert rows == sorted(set(rows))
    assert len(set(columns)) == len(columns)
    least = cost[linear_sum_assignment(cost)].sum()
    assert cost[rows, columns].sum() == pytest.approx(least, abs=1e-6)


def test_a_drive_imports_none_of_scipys_large_packages():
    """They would take 26 MB of a run, for two functions."""
    program = "import sys, fcw_viz.jobs.drive, fcw.detection.choice; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert not {"scipy.optimize", "scipy.special"} & set(done.stdout.split())
