"""Our turning now and the bend ahead: what sweeps, and how a bend that grows goes on."""

import cmath
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.motion.bend.turn import ALONG_PATH_MPS2, USUAL_MPS, Turn, sweep_mps, turn_of
from fcw.motion.bend.turning import AHEAD_S, Turning
from fcw.motion.state import OwnMotion, OwnPath

DT_NS = 33_333_333


@given(st.floats(-0.02, 0.02), st.floats(3, 30), st.floats(0, 30), st.floats(2, 60))
def test_on_a_steady_bend_turning_and_path_say_the_same(bend_per_m, own_mps, closing_mps, distance_m):
    path = OwnPath(curvature_per_m=bend_per_m, heading_rad=0.01)
    turn = Turn(own_mps=own_mps, yaw_rate_radps=bend_per_m * own_mps)
    closing_mps = min(closing_mps, own_mps)
    assert sweep_mps(path, turn, distance_m, closing_mps) == pytest.approx(
        sweep_mps(path, None, distance_m, closing_mps)
    )


@pytest.mark.parametrize("its_mps", [14.0, 7.0, 0.0, -7.0, -14.0])
@pytest.mark.parametrize("beside_m", [0.0, 3.5])
def test_who_drives_along_a_bend_either_way_moves_across_as_its_arc_does(its_mps: float, beside_m: float):
    """R = 300 m to the left, we at 14 m/s; a vehicle on its own circle about the same middle."""
    radius_m, own_mps = 300.0, 14.0

    def seen(time_s: float) -> complex:
        """Ahead and to the left of us."""
        its = (radius_m - beside_m) * 1j * (1 - cmath.exp(1j * (30 + its_mps * time_s) / radius_m))
        turned = cmath.exp(1j * own_mps * time_s / radius_m)
        our = radius_m * 1j * (1 - turned)
        return (beside_m * 1j + its - our) / turned

    moved = (seen(1e-4) - seen(-1e-4)) / 2e-4
    turn = Turn(own_mps=own_mps, yaw_rate_radps=own_mps / radius_m)
    swept_mps = sweep_mps(
        OwnPath(curvature_per_m=1 / radius_m), turn, seen(0).real, -moved.real, oncoming=its_mps < 0
    )
    assert swept_mps == pytest.approx(moved.imag, rel=0.05, abs=0.05)


def test_what_stands_sweeps_by_our_turning_whatever_the_path_does_ahead():
    turn = Turn(own_mps=10.0, yaw_rate_radps=0.05)
    for bend_per_m in (0.0, 0.01):
        assert sweep_mps(OwnPath(curvature_per_m=bend_per_m), turn, 30.0, 10.0) == pytest.approx(-1.5)


def test_turning_is_known_with_the_yaw_rate():
    assert turn_of(OwnMotion(speed_mps=10.0)) is None
    assert turn_of(OwnMotion(speed_mps=10.0, yaw_rate_radps=0.1)) == Turn(own_mps=10.0, yaw_rate_radps=0.1)
    assert turn_of(OwnMotion(yaw_rate_radps=0.1)) == Turn(own_mps=USUAL_MPS, yaw_rate_radps=0.1)


def test_what_stands_sweeps_by_our_turning_at_whatever_speed():
    for own_mps in (5.0, 30.0):
        turn = Turn(own_mps=own_mps, yaw_rate_radps=0.2)
        assert sweep_mps(OwnPath(), turn, 10.0, 4.0) == pytest.approx(-2.0)


@given(st.floats(-0.01, 0.01), st.floats(-0.2, 0.2), st.floats(0, 0.1), st.floats(3, 40))
def test_our_turning_lies_between_what_was_measured_and_what_our_path_says(
    bend_per_m, rate_radps, sigma_radps, own_mps
):
    path = OwnPath(curvature_per_m=bend_per_m)
    turn = Turn(own_mps=own_mps, yaw_rate_radps=rate_radps, sigma_radps=sigma_radps)
    low, high = sorted((rate_radps, bend_per_m * own_mps))
    assert low - 1e-12 <= turn.rate_radps(path) <= high + 1e-12


def test_what_is_measured_exactly_counts_alone_and_what_is_as_sure_as_the_path_by_half():
    path = OwnPath(curvature_per_m=0.001)
    exact = Turn(own_mps=20.0, yaw_rate_radps=0.1)
    assert exact.rate_radps(path) == 0.1
    as_sure = Turn(own_mps=20.0, yaw_rate_radps=0.1, sigma_radps=ALONG_PATH_MPS2 / 20.0)
    assert as_sure.rate_radps(path) == pytest.approx((0.1 + 0.02) / 2)
    standing = Turn(own_mps=0.0, yaw_rate_radps=0.1, sigma_radps=0.1)
    assert standing.rate_radps(path) == 0.1


def test_a_bend_that_grows_goes_on_and_a_steady_one_stays():
    growing, steady, change, none = Turning(), Turning(), 0.0, 1.0
    sigma = math.radians(0.1)
    for k in range(60):
        change = growing.update(k * DT_NS, 12.0, 0.03 * k * DT_NS / 1e9, sigma)
        none = steady.update(k * DT_NS, 12.0, 0.05, sigma)
    assert change == pytest.approx(0.03 * AHEAD_S, rel=0.25)
    assert none == pytest.approx(0.0, abs=1e-3)
    assert growing.update(61 * DT_NS, None, None, sigma) == 0.0
    assert growing.update(62 * DT_NS, 12.0, 0.06, sigma) == 0.0
