"""Dynamics against their equations: braking distances, the driver model's equilibria, paths, shaking."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.simulation.world.motion import (
    DIVE_RAD_PER_MPS2,
    SHAKE_BAND_HZ,
    SHAKE_PITCH_RMS_RAD,
    STANDING_GAP_M,
    LaneChange,
    NoseDive,
    Reaction,
    RoadShake,
    Sway,
    following_acceleration_mps2,
    seeking_acceleration_mps2,
)

STEP_S = 1 / 240


def test_a_follower_on_a_free_road_settles_at_its_desired_speed():
    assert following_acceleration_mps2(25.0, 25.0, 1.5) == pytest.approx(0.0)
    assert following_acceleration_mps2(20.0, 25.0, 1.5) > 0
    assert following_acceleration_mps2(30.0, 25.0, 1.5) < 0


@given(st.floats(1.0, 30.0), st.floats(0.5, 2.5))
def test_the_driver_models_equilibrium_gap_is_the_published_one(speed_mps, headway_s):
    # Treiber et al. 2000, eq. 6: s = (s0 + T v) / sqrt(1 - (v / v0)^4).
    desired_mps = 40.0
    gap_m = (STANDING_GAP_M + headway_s * speed_mps) / math.sqrt(1 - (speed_mps / desired_mps) ** 4)
    assert following_acceleration_mps2(speed_mps, desired_mps, headway_s, gap_m, 0.0) == pytest.approx(0.0)


@given(st.floats(0.0, 30.0), st.floats(3.0, 100.0), st.floats(0.0, 10.0))
def test_a_smaller_gap_and_a_faster_approach_never_make_a_driver_accelerate_more(speed, gap, closing):
    wanted = following_acceleration_mps2(speed, 30.0, 1.5, gap, closing)
    assert following_acceleration_mps2(speed, 30.0, 1.5, gap * 0.9, closing) <= wanted
    assert following_acceleration_mps2(speed, 30.0, 1.5, gap, closing + 1.0) <= wanted


def test_seeking_a_speed_is_a_constant_rate_far_from_it_and_nothing_at_it():
    assert seeking_acceleration_mps2(20.0, 5.0, 4.0) == -4.0
    assert seeking_acceleration_mps2(5.0, 20.0, 1.5) == 1.5
    assert seeking_acceleration_mps2(10.0, 10.0, 3.0) == 0.0


def test_the_brakes_come_after_the_reaction_time_and_not_before():
    driver = Reaction(1.2)
    done = [driver.filtered(-4.0, STEP_S) for _ in range(round(2 / STEP_S))]
    first = done.index(-4.0)
    assert first * STEP_S == pytest.approx(1.2, abs=2 * STEP_S)
    assert set(done[:first]) == {0.0}
    assert driver.filtered(1.0, STEP_S) == 1.0
    assert driver.filtered(-4.0, STEP_S) == 0.0, "a new danger needs a new reaction"


@given(st.floats(-8.0, 8.0), st.floats(0.0, 6.0))
def test_a_lane_change_is_smooth_and_ends_where_it_should(to_m, time_s):
    change = LaneChange(1.0, 3.0, 0.5, to_m)
    assert change.at(0.0) == (0.5, 0.0)
    assert change.at(4.0) == (pytest.approx(to_m), pytest.approx(0.0))
    slope = (change.at(time_s + 1e-5)[0] - change.at(time_s - 1e-5)[0]) / 2e-5
    assert change.at(time_s)[1] == pytest.approx(slope, abs=1e-3)
    low, high = sorted((0.5, to_m))
    assert low - 1e-9 <= change.at(time_s)[0] <= high + 1e-9


@given(st.floats(0.0, 1000.0))
def test_swaying_has_its_own_slope(s_m):
    sway = Sway(0.12, 180.0, 0.7)
    slope = (sway.at(s_m + 1e-4)[0] - sway.at(s_m - 1e-4)[0]) / 2e-4
    assert sway.at(s_m)[1] == pytest.approx(slope, abs=1e-6)


def test_the_nose_dives_by_the_gradient_and_swings_back():
    dive = NoseDive()
    pitches = []
    for step in range(round(8 / STEP_S)):
        dive.step(-6.0 if step * STEP_S < 4 else 0.0, STEP_S)
        pitches.append(dive.pitch_rad)
    settled = 6 * DIVE_RAD_PER_MPS2
    assert pitches[round(3.9 / STEP_S)] == pytest.approx(settled, rel=0.02)
    # A damped spring overshoots by exp(-pi z / sqrt(1 - z^2)): 31 % for z = 0.35.
    assert max(pitches) == pytest.approx(settled * 1.31, rel=0.02)
    assert pitches[-1] == pytest.approx(0.0, abs=0.02 * settled)


def test_the_road_shakes_as_much_as_stated_within_its_band_and_not_while_standing():
    times_s = np.arange(0, 400, 1 / 30)
    shake = RoadShake(1.0, np.random.default_rng(3))
    pitch = np.array([shake.at(t, 25.0)[0] for t in times_s])
    assert pitch.std() == pytest.approx(SHAKE_PITCH_RMS_RAD, rel=0.05)
    power = np.abs(np.fft.rfft(pitch)) ** 2
    frequency = np.fft.rfftfreq(len(pitch), 1 / 30)
    inside = (frequency > SHAKE_BAND_HZ[0] - 0.05) & (frequency < SHAKE_BAND_HZ[1] + 0.05)
    assert power[inside].sum() > 0.98 * power.sum()
    assert shake.at(12.3, 0.0) == (0.0, 0.0)
