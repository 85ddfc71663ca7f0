"""Where a calibration leaves the scale of distances open, vehicles leave it as it is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.camera.calibration import Calibration, matrix3
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(math.radians(-7), 1300.0, 359.5, 1.4, 639.5)
NOISE = BoxNoise(edge_floor_px=1.0, edge_fraction=0.0, width_bias_sigma=0.0, at_tyres=False)
CAR = RangeModel().rears[0]


def of_a_clip(horizon_px: float = 2.0, scale: float = 0.3, pole_m: float = 0.06) -> Calibration:
    """As clips are calibrated without a tape: the horizon is known, the focal length to a third.

    With a longer one this camera looks up less, to the same horizon: that ties K and C of the row map.
    """
    support_m = (5.0, 10.0, 20.0)
    depths_m = np.array(support_m) + CAMERA.pole_m
    below_px = CAMERA.row_scale_m_px / depths_m
    rows = np.column_stack((np.ones(3), below_px, -below_px / depths_m))
    tied = 0.8 * scale * pole_m
    covariance = np.array([[horizon_px**2, 0, 0], [0, scale**2, tied], [0, tied, pole_m**2]])
    told = matrix3(rows @ covariance @ rows.T)
    return replace(Calibration.from_camera(CAMERA, SIZE), support_distances_m=support_m, covariance=told)


@pytest.mark.parametrize("wrong", [0.7, 0.9, 1.1, 1.3])
@pytest.mark.parametrize("start_m", [(20.0,), (20.0, 26.0, 33.0, 41.0, 50.0)])
def test_looks_that_grow_too_fast_or_too_slowly_draw_no_distances(wrong: float, start_m: tuple[float, ...]):
    """Widths and rows say where the vehicles are; the scale, in which both tell it, is not theirs to say."""
    range_filter = RangeFilter(of_a_clip(), NOISE, RangeModel())
    distances_m = np.array(start_m)
    slots = range(len(start_m))
    for slot in slots:
        box = CAMERA.ground_box(distances_m[slot], 0.0, CAR.width_m, CAR.height_m)
        assert range_filter.add(box, None)
        range_filter.begin_growth(slot)
    remembered_m = distances_m + CAMERA.pole_m
    for frame in range(1, 101):
        distances_m = distances_m - 0.16
        boxes = [CAMERA.ground_box(d, 0.0, CAR.width_m, CAR.height_m) for d in distances_m]
        range_filter.predict(0.04)
        range_filter.update(list(zip(slots, boxes, strict=True)), 0.04)
        if frame % 10 == 0:
            now_m = distances_m + CAMERA.pole_m
            growths = wrong * np.log(remembered_m / now_m)
            range_filter.take_growths([(slot, float(growths[slot]), 0.003) for slot in slots], 0.04)
            for slot in slots:
                range_filter.begin_growth(slot)
            remembered_m = now_m
    for slot in slots:
        assert range_filter.state(slot).distance_m == pytest.approx(distances_m[slot], rel=0.1)
    assert range_filter.focal_px == pytest.approx(1300.0, rel=0.03)
