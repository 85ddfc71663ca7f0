"""Bundle adjustment of a window, and where it starts."""

import math

import numpy as np
import pytest
from helpers.drives.turning import AXIS_PX, SIZE, driven, one_bend

from fcw.self_calibration.turning.bundle import Bundle
from fcw.self_calibration.turning.lens import PlainLens
from fcw.self_calibration.turning.pair import motion_between
from fcw.self_calibration.turning.windows import turning_windows

LENS = PlainLens(400.0, 0.0, AXIS_PX)


@pytest.fixture
def bundle() -> Bundle:
    (window, *_) = turning_windows(driven(LENS, one_bend, 3.0), SIZE[0])
    return Bundle(window.times_s, window.places, SIZE, 330.0)


def test_slopes_by_lens_are_those_of_finite_differences(bundle):
    at = bundle._at
    _, of_lens, _, _ = bundle._slopes(at)
    for k, name in enumerate(("log_focal", "bend")):
        up, down = (at._replace(**{name: getattr(at, name) + step}) for step in (1e-5, -1e-5))
        expected = (bundle._misfits_px(up) - bundle._misfits_px(down)) / 2e-5
        np.testing.assert_allclose(of_lens[:, :, k], expected, rtol=1e-4, atol=1e-4)


def test_slopes_by_pose_and_point_are_those_of_finite_differences(bundle):
    at, step = bundle._at, 1e-6
    of_pose, _, of_point, basis = bundle._slopes(at)
    count, points = 6 * bundle._keys + 2, bundle._points
    base = bundle._misfits_px(at)
    for k in range(6):
        change = np.zeros(count)
        change[k:-2:6] = step
        moved = bundle._moved(change, np.zeros((points, 3)), basis)
        np.testing.assert_allclose(
            of_pose[:, :, k], (bundle._misfits_px(moved) - base) / step, rtol=1e-2, atol=0.5
        )
    inner = at.inverse_depths > 2 * step  # at infinity a point stays
    for k in range(3):
        change = np.zeros((points, 3))
        change[:, k] = step
        slopes = (bundle._misfits_px(bundle._moved(np.zeros(count), change, basis)) - base) / step
        seen = inner[bundle._point]
        np.testing.assert_allclose(of_point[seen][:, :, k], slopes[seen], rtol=1e-2, atol=0.5)


def test_it_goes_down_and_finds_the_lens(bundle):
    before = bundle.fit(((1.0, 0),), focal_open=False)
    after = bundle.fit(((8.0, 3), (3.0, 4), (1.0, 25)), focal_open=True)
    assert after.cost < before.cost
    assert after.inlying > 0.9
    assert after.log_focal.value == pytest.approx(math.log(400), abs=4 * after.log_focal.sigma + 0.02)


def test_a_closed_focal_length_stays(bundle):
    assert bundle.fit(((3.0, 4),), focal_open=False).log_focal.value == pytest.approx(math.log(330))


def test_two_pictures_tell_how_the_camera_turned_between_them():
    first, *_, last = driven(LENS, lambda _: 0.2, 0.5, noise_px=0.05)
    _, before, after = np.intersect1d(first.numbers, last.numbers, return_indices=True)
    turn, shift = motion_between(first.places[before].astype(float), last.places[after].astype(float), LENS)
    angle_rad = math.acos((np.trace(turn) - 1) / 2)
    assert angle_rad == pytest.approx(0.2 * 0.4, abs=0.005)
    assert turn[0, 2] > 0  # a car that turns left sees all go to the right
    assert shift[2] < -0.99
