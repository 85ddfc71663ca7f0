"""The focal length by turns, on drives whose lens is known exactly."""

import math

import numpy as np
import pytest
from helpers.drives.turning import AXIS_PX, SIZE, bends, driven, one_bend, straight

from fcw.camera.calibration import Gaussian
from fcw.self_calibration.turning.bundle import Told
from fcw.self_calibration.turning.by_turns import (
    COMMON_SIGMA,
    WINDOW_SIGMA,
    agreed_focal,
    agreed_lens,
    lens_of_window,
)
from fcw.self_calibration.turning.lens import PlainLens
from fcw.self_calibration.turning.windows import turning_windows


def told(focal_px: float, sigma: float = 0.03, bend: float = 0.0) -> Told:
    return Told(Gaussian(math.log(focal_px), sigma), Gaussian(bend, 0.02), 0.8, 100.0)


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


@pytest.mark.slow
@pytest.mark.parametrize("focal_px", [250.0, 333.0, 550.0])
def test_a_fisheye_is_known_by_its_bends(focal_px):
    pictures = driven(PlainLens(focal_px, -1 / 3, AXIS_PX), bends, 5.0)
    windows = turning_windows(pictures, SIZE[0])
    found = agreed_lens(
        [lens for window in windows if (lens := lens_of_window(window, SIZE)) is not None], SIZE[0]
    )
    assert found is not None
    assert found.bend == pytest.approx(-1 / 3, abs=0.02)
    assert found.focal_px.value == pytest.approx(focal_px, rel=0.03)


class Brown(PlainLens):
    """A lens that is not of the family."""

    def bent(self, rays):
        return rays * (1 + self.bend * (rays**2).sum(axis=1))[:, None]


@pytest.mark.slow
def test_a_lens_that_is_not_of_the_family_has_its_focal_length_too():
    pictures = driven(Brown(600.0, -0.25, AXIS_PX), bends, 8.0, seed=1)
    windows = turning_windows(pictures, SIZE[0])
    found = agreed_lens(
        [lens for window in windows if (lens := lens_of_window(window, SIZE)) is not None], SIZE[0]
    )
    assert found is not None
    assert found.focal_px.value == pytest.approx(600.0, rel=0.05)


def test_a_lens_bends_the_picture_where_most_windows_agree_on_it():
    straight, bent = [told(400, bend=-0.02)], [told(330, bend=-0.34), told(335, bend=-0.35)]
    one = agreed_lens(straight * 2 + bent[:1], 640)
    assert one is not None
    assert one.bend is None
    assert one.focal_px.value == pytest.approx(400)
    two = agreed_lens(straight + bent, 640)
    assert two is not None
    assert two.bend == pytest.approx(-0.345)
    assert two.focal_px.value == pytest.approx(332.5, rel=0.01)


def test_a_lens_that_bends_a_narrow_picture_leaves_it_nearly_straight():
    found = agreed_lens([told(700, bend=-0.3), told(710, bend=-0.31)], 640)
    assert found is not None
    assert found.bend is None


def test_windows_that_disagree_on_the_bend_tell_no_lens():
    assert agreed_lens([told(400, bend=bend) for bend in (-0.2, -0.3, -0.4)], 640) is None


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
