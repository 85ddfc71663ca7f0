"""A body that nods, told or not: distances by boxes whose rows go up and down with it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

CAMERA = GroundPlaneCamera(0.02, 740.0, 359.5, 1.4, 639.5)
CALIBRATION = Calibration.from_camera(CAMERA, ImageSize(1280, 720))
NOISE = BoxNoise(edge_floor_px=1.0, edge_fraction=0.0, width_bias_sigma=0.0, at_tyres=False)
CAR, STEP_S = RangeModel().rears[0], 0.1


def distances_m(nods_rad, told, true_m=25.0):
    """What is believed after each box of a car at a constant distance, by a body that nods like this."""
    range_filter, believed_m = RangeFilter(CALIBRATION, NOISE, RangeModel()), []
    rear = CAMERA.ground_box(true_m, 0.0, CAR.width_m, CAR.height_m)
    assert range_filter.add(rear, None)
    for nod_rad, pitch_rad in zip(nods_rad, told, strict=True):
        range_filter.predict(STEP_S, body_pitch_rad=pitch_rad)
        box = Box(rear.x, rear.y - CAMERA.focal_y_px * nod_rad, rear.w, rear.h)
        range_filter.update([(0, box)], STEP_S)
        believed_m.append(range_filter.state(0).distance_m)
    return np.array(believed_m)


@given(st.lists(st.floats(-0.04, 0.04), min_size=1, max_size=12), st.floats(1e-4, 0.01))
def test_nods_that_are_told_exactly_change_nothing(nods_rad, sigma_rad):
    level = distances_m([0.0] * len(nods_rad), [Gaussian(0.0, sigma_rad)] * len(nods_rad))
    told = distances_m(nods_rad, [Gaussian(nod_rad, sigma_rad) for nod_rad in nods_rad])
    assert told == pytest.approx(level, rel=1e-9)


@pytest.mark.parametrize("nod_deg", [-1.5, 1.5])
def test_a_car_that_is_found_in_a_bump_is_where_it_is_if_the_bump_is_told_roughly(nod_deg):
    nods_rad = np.radians([nod_deg] * 6 + [0.0] * 10)
    told = [Gaussian(0.85 * nod_rad, math.radians(0.15)) for nod_rad in nods_rad]
    off, untold_off = (distances_m(nods_rad, said) / 25.0 - 1 for said in (told, [None] * len(nods_rad)))
    assert np.abs(off).max() < 0.03 < 0.06 < np.abs(untold_off).max()


def test_once_nothing_is_told_any_more_the_body_is_level_again():
    nods_rad = [0.0] * 20 + [0.03] * 5 + [0.0] * 5
    told = [None] * 20 + [Gaussian(0.03, 0.002)] * 5 + [None] * 5
    assert distances_m(nods_rad, told)[-5:] == pytest.approx(25.0, rel=0.05)
