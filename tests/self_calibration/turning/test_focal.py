"""The focal length by turns, on drives whose lens is known exactly."""

import math

import numpy as np
import pytest
from helpers.drives.turning import AXIS_PX, SIZE, bends, driven, one_bend, straight

from fcw.camera.calibration import Gaussian
from fcw.self_calibration.turning.bundle import Told
from fcw.self_calibration.turning.focal import COMMON_SIGMA, WINDOW_SIGMA, agreed_focal, lens_of_window
from fcw.self_calibration.turning.lens import PlainLens
from fcw.self_calibration.turning.windows import turning_windows


def told(focal_px: float, sigma: float = 0.03) -> Told:
    return Told(Gaussian(math.log(focal_px), sigma), Gaussian(0.0, 0.02), 0.8, 100.0)


@pytest.mark.slow
@pytest.mark.parametrize(("focal_px", "bend"), [(280.0, -0.1), (400.0, 0.0), (600.0, -0.1)])
def test_a_bend_tells_the_focal_length_whether_or_not_the_lens_bends_the_picture(focal_px, bend):
    pictures = driven(PlainLens(focal_px, bend, AXIS_PX), one_bend, 4.0)
    windows = turning_windows(pictures, SIZE[0])
    assert windows
    found = agreed_focal([lens for window in windows if (lens := lens_of_window(window, SIZE)) is not None])
    assert found is not None
    off = found.value - math.log(focal_px)
    assert abs(off) < 2 * found.sigma
    assert abs(off) < 0.1


@pytest.mark.slow
def test_turns_to_and_fro_tell_it_more_surely_than_one_bend():
    pictures = driven(PlainLens(400.0, -0.1, AXIS_PX), bends, 8.0, seed=1)
    lenses = [lens_of_window(window, SIZE) for window in turning_windows(pictures, SIZE[0])]
    found = agreed_focal([lens for lens in lenses if lens is not None])
    assert found is not None
    assert abs(found.value - math.log(400.0)) < 2 * found.sigma
    assert found.sigma < 0.15


@pytest.mark.parametrize("speed_mps", [0.0, 10.0])
def test_a_straight_drive_and_a_standing_car_tell_nothing(speed_mps):
    pictures = driven(PlainLens(400.0, 0.0, AXIS_PX), straight, 6.0, speed_mps=speed_mps)
    assert turning_windows(pictures, SIZE[0]) == []
    assert turning_windows([], SIZE[0]) == []
    assert agreed_focal([]) is None


class Equidistant(PlainLens):
    """A fisheye: places go with the angle from the axis."""

    def bent(self, rays):
        tangents = np.linalg.norm(rays, axis=1)[:, None]
        return rays * np.arctan(tangents) / np.maximum(tangents, 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("focal_px", [333.0, 550.0])
def test_a_fisheye_which_k1_does_not_describe_tells_nothing(focal_px):
    pictures = driven(Equidistant(focal_px, 0.0, AXIS_PX), one_bend, 3.0)
    (window, *_) = turning_windows(pictures, SIZE[0])
    assert lens_of_window(window, SIZE) is None


def test_points_of_no_rigid_world_tell_nothing():
    pictures = driven(PlainLens(400.0, 0.0, AXIS_PX), one_bend, 3.0)
    (window, *_) = turning_windows(pictures, SIZE[0])
    window.places[:] += np.random.default_rng(0).normal(0, 6.0, window.places.shape)
    assert lens_of_window(window, SIZE) is None


def test_one_window_tells_nothing_two_are_as_unsure_as_windows_differ_and_many_are_surer():
    assert agreed_focal([told(400)]) is None
    two, many = agreed_focal([told(400)] * 2), agreed_focal([told(400)] * 8)
    assert two is not None
    assert many is not None
    assert two.value == pytest.approx(math.log(400))
    assert two.sigma > math.hypot(WINDOW_SIGMA / math.sqrt(2), COMMON_SIGMA)
    assert COMMON_SIGMA < many.sigma < two.sigma / 1.4


def test_windows_that_contradict_each_other_are_less_sure_together():
    agreed = agreed_focal([told(390), told(400), told(410), told(400)])
    apart = agreed_focal([told(200), told(330), told(480), told(800)])
    assert agreed is not None
    assert apart is not None
    assert apart.sigma > 2 * agreed.sigma


def test_a_window_far_from_all_others_moves_less_than_the_error_that_is_stated():
    found = agreed_focal([told(400)] * 6 + [told(1600)])
    assert found is not None
    assert abs(found.value - math.log(400)) < found.sigma
