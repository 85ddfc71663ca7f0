"""Simulated drives with a mount that turns, through the tracker."""

import math

import numpy as np
import pytest

from fcw.evaluation.distance.mount import first_said_s


@pytest.mark.slow
def test_a_mount_that_turns_far_is_said_soon_and_one_that_stays_is_not():
    turned_rad = math.radians(1.5)
    for direction in (1, -1):
        said_s = first_said_s(np.random.default_rng(2), 120.0, 2.0, direction * turned_rad, 30.0)
        assert said_s is not None
        assert 30.0 <= said_s <= 90.0
    assert first_said_s(np.random.default_rng(2), 90.0, 2.0) is None
