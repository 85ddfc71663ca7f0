"""Vehicles of which a corner is seen, and the camera that they could be taken to tell of."""

import math

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

CAMERA = GroundPlaneCamera(0.02, 740.0, 359.5, 1.4, 639.5)
NOISE = BoxNoise(edge_floor_px=1.0, edge_fraction=0.0, width_bias_sigma=0.0, at_tyres=False)
CAR = RangeModel().rears[0]


@pytest.mark.parametrize(
    ("lateral_m", "width_m", "teaches"),
    [(0.0, CAR.width_m, True), (3.0, CAR.width_m, True), (3.0, 3.0, False), (0.0, 3.0, True)],
    ids=["rear ahead", "rear beside us", "corner beside us", "across our way"],
)
def test_a_corner_beside_our_lane_says_nothing_of_the_camera(lateral_m, width_m, teaches):
    range_filter = RangeFilter(Calibration.from_camera(CAMERA, ImageSize(1280, 720)), NOISE, RangeModel())
    lead, other = (
        CAMERA.ground_box(30.0, 0.0, CAR.width_m, CAR.height_m),
        CAMERA.ground_box(20.0, lateral_m, width_m, CAR.height_m),
    )
    assert all(range_filter.add(box, None) for box in (lead, other))
    for lower_px in np.linspace(0.0, 20.0, 50):
        sunk = Box(other.x, other.y + lower_px, other.w, other.h)
        range_filter.predict(0.04)
        range_filter.update([(0, lead), (1, sunk)], 0.04)
    assert (abs(range_filter.pitch_rad) > math.radians(0.1)) == teaches
