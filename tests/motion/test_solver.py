"""The solver against exact points, and its covariance against sampling."""

import numpy as np
import pytest

from fcw.motion.solver import PITCH_TURN, ROAD_PITCH, TRAVEL, UNKNOWNS, YAW, YAW_TURN, solve

HEIGHT_M = 1.4
SIGMA = 0.3 / 500
SCALES = (16.0, 8.0, 4.0, 2.5, 2.5, 2.5)
TRUE = np.array([0.002, -0.01, 0.001, 0.9, 0.02, -0.01, 0.004, 0.01])
PRIOR_SIGMAS = np.array([0.01, 0.02, 0.01, 0.5, 0.05, 0.05, 0.01, 0.02])


def points(rng, unknowns, count=80):
    """Rays before and after a motion, by rotation matrices of scipy; half of them are road."""
    from scipy.spatial.transform import Rotation

    road = np.arange(count) < count // 2
    x = rng.uniform(-0.5, 0.5, count)
    y = np.where(road, rng.uniform(0.06, 0.3, count), rng.uniform(-0.3, 0.1, count))
    depth_m = np.where(road, HEIGHT_M / (unknowns[7] * x + y + unknowns[6]), rng.uniform(8.0, 60.0, count))
    before = np.column_stack((x, y))
    places = np.column_stack((x, y, np.ones(count))) * depth_m[:, None]
    travel = unknowns[3] * np.array([unknowns[4], -unknowns[5], 1.0])
    seen = (places - travel) @ Rotation.from_rotvec(unknowns[:3]).as_matrix()
    return before, seen[:, :2] / seen[:, 2:], road


def solved(before, after, road, mean):
    count = len(road)
    precision = np.tile([SIGMA**-2, SIGMA**-2, 0.0], (count, 1))
    return solve(
        before,
        after,
        road,
        np.full(count, 0.03),
        np.where(road, 0.01, 0.05),
        precision,
        HEIGHT_M,
        mean,
        np.diag(PRIOR_SIGMAS**2),
        SCALES,
    )


def test_exact_points_give_the_motion_back():
    rng = np.random.default_rng(1)
    mean = TRUE + PRIOR_SIGMAS * 0.5
    solution = solved(*points(rng, TRUE), mean)
    assert solution.unknowns[TRAVEL] == pytest.approx(TRUE[TRAVEL], rel=0.01)
    for place in (PITCH_TURN, YAW_TURN, YAW, ROAD_PITCH):
        assert solution.unknowns[place] == pytest.approx(TRUE[place], abs=0.002)


def test_points_astray_are_found_out():
    rng = np.random.default_rng(2)
    before, after, road = points(rng, TRUE)
    astray = np.arange(len(road)) % 4 == 0
    after[astray] += rng.uniform(-0.1, 0.1, (astray.sum(), 2))
    solution = solved(before, after, road, TRUE + PRIOR_SIGMAS * 0.3)
    assert solution.unknowns[TRAVEL] == pytest.approx(TRUE[TRAVEL], rel=0.02)
    assert solution.inlying[~astray].mean() > 0.8
    assert solution.inlying[astray & road].mean() < 0.3


def test_the_covariance_is_that_of_sampled_noise():
    rng = np.random.default_rng(3)
    before, after, road = points(rng, TRUE)
    errors, sigmas = [], []
    for _ in range(200):
        noisy = after + SIGMA * rng.standard_normal(after.shape)
        solution = solved(before, noisy, road, TRUE)
        errors.append(solution.unknowns - TRUE)
        posterior = np.linalg.inv(solution.information + np.diag(PRIOR_SIGMAS**-2))
        sigmas.append(np.sqrt(posterior.diagonal()))
    sampled, predicted = np.std(errors, axis=0), np.mean(sigmas, axis=0)
    assert np.shape(errors) == (200, UNKNOWNS)
    # The road's own unevenness is in the prediction and was not drawn: what is predicted is no smaller.
    assert (sampled[[0, 1, TRAVEL]] < 1.3 * predicted[[0, 1, TRAVEL]]).all()
    assert (sampled[[0, 1]] > 0.4 * predicted[[0, 1]]).all()


MIRROR = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0])
"""Of the solver's unknowns: what turns or tilts to one side, to the other."""


@pytest.mark.parametrize("seed", range(5))
def test_the_motion_of_mirrored_points_is_mirrored(seed):
    rng = np.random.default_rng(seed)
    before, after, road = points(rng, TRUE)
    after[:10] += rng.uniform(-0.1, 0.1, (10, 2))  # astray
    mean = TRUE + PRIOR_SIGMAS * rng.standard_normal(UNKNOWNS) / 2
    flip = np.array([-1.0, 1.0])
    one, other = solved(before, after, road, mean), solved(before * flip, after * flip, road, mean * MIRROR)
    np.testing.assert_allclose(other.unknowns, one.unknowns * MIRROR, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(other.inlying, one.inlying, atol=1e-7)
