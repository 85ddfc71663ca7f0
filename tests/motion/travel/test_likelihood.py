"""How likely two pictures are for each direction of travel."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fcw.motion.travel.likelihood import log_likelihoods

FOCAL_PX = 600.0
TURN_SIGMAS_RAD = np.radians((0.2, 2.4, 0.5))
ASIDE = (-0.06, 0.06)
small = st.floats(-0.15, 0.15)


def moved(direction, turn_rad, travel_m, seed, count=80):
    """Rays of points in front of a camera before and after it drove and turned."""
    random = np.random.default_rng(seed)
    depth_m = random.uniform(5, 60, count)
    rays = random.uniform((-0.5, -0.3), (0.5, 0.3), (count, 2))
    world = np.column_stack((rays, np.ones(count))) * depth_m[:, None]
    there = world - travel_m * np.array([*direction, 1.0])
    x, y, z = turn_rad
    # A small turn w moves a point by -w x P.
    there = there - np.cross(np.array([x, y, z]), there)
    return rays, there[:, :2] / there[:, 2:]


@given(small, small, st.floats(-0.02, 0.02), st.integers(0, 2**31))
def test_the_true_direction_is_likeliest_however_the_camera_turns(right, down, yaw_rad, seed):
    before, after = moved((right, down), (0.001, yaw_rad, 0.002), 2.0, seed)
    around = np.array([(0.0, 0.0), (0.0, -0.06), (0.0, 0.06), *itertools.product(ASIDE, (-0.06, 0.0, 0.06))])
    directions = around + np.array((right, down))
    found = log_likelihoods(before, after, directions, TURN_SIGMAS_RAD, 0.5, FOCAL_PX)
    assert found.argmax() == 0


def test_who_drives_backwards_drives_in_no_direction_ahead():
    before, after = moved((0.0, 0.0), (0.0, 0.0, 0.0), 2.0, 0)
    ahead, behind = (
        log_likelihoods(first, second, np.zeros((1, 2)), TURN_SIGMAS_RAD, 0.5, FOCAL_PX)[0]
        for first, second in ((before, after), (after, before))
    )
    assert ahead > behind + 100


def test_what_does_not_move_tells_no_direction():
    rays = np.random.default_rng(0).uniform(-0.4, 0.4, (60, 2))
    directions = np.array([(0.0, 0.0), (0.2, 0.0), (0.0, -0.2)])
    found = log_likelihoods(rays, rays, directions, TURN_SIGMAS_RAD, 0.5, FOCAL_PX)
    assert np.ptp(found) < 1e-6
