"""The own speed as the tracker takes it: exact where it was given, smoothed where the picture tells it."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.own_speed import ACCELERATION_S, ERRORS_LAST_S, OwnSpeed

DT_S = 1 / 30


@given(st.lists(st.floats(0, 50), min_size=2, max_size=20))
def test_what_was_given_is_taken_as_it_is(speeds_mps):
    own = OwnSpeed()
    own.update(0.0, speeds_mps[0], 0.0)
    for before_mps, speed_mps in pairwise(speeds_mps):
        assert own.update(DT_S, speed_mps, 0.0) == pytest.approx(speed_mps - before_mps, abs=1e-6)
        assert own.speed_mps == pytest.approx(speed_mps, abs=1e-6)


def test_the_pictures_errors_are_smoothed_and_braking_is_followed():
    rng, error, own, found = np.random.default_rng(0), 0.0, OwnSpeed(), []
    lasting = np.exp(-DT_S / ERRORS_LAST_S)
    for _ in range(3000):
        error = lasting * error + np.sqrt(1 - lasting**2) * rng.standard_normal()
        own.update(DT_S, 20.0 + 0.6 * error, 0.6)
        found.append(own.speed_mps)
    assert np.mean(found) == pytest.approx(20.0, abs=0.2)
    gained = np.array(found)[15:] - np.array(found)[:-15]
    # Of the errors themselves it is 0.6 sqrt(2 (1 - 1/e)) = 0.67 m/s.
    assert np.std(gained) < 0.45
    speed_mps = 20.0
    for _ in range(30):
        speed_mps -= 6.0 * DT_S
        own.update(DT_S, speed_mps, 0.6)
    assert own.speed_mps == pytest.approx(speed_mps, abs=2.0)


def test_a_speed_that_is_told_no_more_is_held_ever_less_surely_and_forgotten():
    own = OwnSpeed()
    own.update(0.0, 20.0, 0.5)
    held_s, before_mps = 0.0, 0.5
    while own.update(DT_S, None, 0.0) == 0.0 and own.speed_mps is not None:
        held_s += DT_S
        assert own.speed_mps == 20.0
        assert own.sigma_mps > before_mps
        before_mps = own.sigma_mps
    # From 0.5 m/s to 6, by 3 a second.
    assert held_s == pytest.approx(5.5 / 3, abs=2 * DT_S)
    assert own.speed_mps is None
    assert own.update(DT_S, 10.0, 0.5) == 0.0
    assert own.speed_mps == 10.0


@pytest.mark.parametrize(("before", "after"), [((20.0, 0.6), (22.0, 0.0)), ((22.0, 0.0), (20.0, 0.6))])
def test_by_what_a_given_speed_differs_from_the_pictures_we_became_no_faster(before, after):
    own = OwnSpeed()
    for _ in range(90):
        own.update(DT_S, *before)
    gains_mps = [own.update(DT_S, *after) for _ in range(30)]
    assert gains_mps == pytest.approx([0.0] * 30, abs=1e-9)
    assert own.speed_mps == pytest.approx(after[0])


def test_the_speed_that_is_told_after_a_gap_is_no_gain():
    own = OwnSpeed()
    own.update(0.0, 20.0, 0.5)
    own.update(DT_S, None, 0.0)
    assert own.update(DT_S, 18.0, 0.5) == 0.0
    assert own.speed_mps == 18.0


def test_another_speed_at_once_is_no_gain_and_is_believed_when_it_lasts():
    own = OwnSpeed()
    for _ in range(30):
        own.update(DT_S, 12.0, 0.3)
    gained_mps = [own.update(DT_S, 4.0, 0.3) for _ in range(14)]
    assert own.speed_mps == pytest.approx(12.0, abs=0.1)
    gained_mps += [own.update(DT_S, 4.0, 0.3) for _ in range(4)]
    assert own.speed_mps == pytest.approx(4.0, abs=0.1)
    assert sum(map(abs, gained_mps)) < 0.1


def test_a_misread_picture_now_and_then_changes_nothing():
    own = OwnSpeed()
    own.update(0.0, 12.0, 0.3)
    for frame in range(60):
        own.update(DT_S, 24.0 if frame % 7 == 3 else 12.0, 0.3)
        assert own.speed_mps == pytest.approx(12.0, abs=0.1)


@pytest.mark.parametrize("sigma_mps", [0.2, 0.6])
def test_the_hardest_braking_is_no_jump(sigma_mps):
    own, speed_mps = OwnSpeed(), 25.0
    gained_mps = own.update(0.0, speed_mps, sigma_mps)
    for _ in range(60):
        speed_mps -= 10.0 * DT_S
        gained_mps += own.update(DT_S, speed_mps, sigma_mps)
        # It lags, and no more than what would count as a jump.
        assert own.speed_mps == pytest.approx(speed_mps, abs=3.5)
    assert gained_mps == pytest.approx(-20.0, abs=3.5)


@given(st.lists(st.tuples(st.floats(9, 40), st.floats(0.08, 0.2)), min_size=2, max_size=12))
def test_a_speed_that_is_known_roughly_is_taken_as_told_and_is_no_gain(told):
    own = OwnSpeed()
    own.update(0.0, 20.0, 0.5)
    for speed_mps, part in told:
        assert own.update(DT_S, speed_mps, part * speed_mps) == 0.0
        assert (own.speed_mps, own.gain_sigma_mps) == (speed_mps, 0.0)
    # What is known well after it says nothing of what came before.
    assert own.update(DT_S, 17.0, 0.5) == 0.0
    assert own.update(DT_S, 17.2, 0.5) > 0.0


@pytest.mark.parametrize("sigma_mps", [0.0, 0.4])
@pytest.mark.parametrize("then_mps", [None, 12.0], ids=["no speed", "a rough one"])
def test_braking_of_which_no_more_is_told_runs_out(sigma_mps: float, then_mps: float | None):
    own, speed_mps = OwnSpeed(), 20.0
    for _ in range(60):
        speed_mps -= 4.0 * DT_S
        # In steps of 1 km/h, as most devices tell it.
        own.update(DT_S, round(3.6 * speed_mps) / 3.6, sigma_mps)
    gains = [own.update(DT_S, then_mps, 5.0) for _ in range(300)]
    # The filter takes an acceleration for one that passes, and so for a little less than it is.
    assert gains[0] / DT_S == pytest.approx(-4.0, abs=1.1)
    assert sum(gains) == pytest.approx(gains[0] / DT_S * ACCELERATION_S, rel=0.05)
    assert all(before <= after <= 0 for before, after in pairwise(gains))
