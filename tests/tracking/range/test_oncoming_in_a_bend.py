"""Oncoming cars turn towards us in a bend: their boxes grow less than they come nearer."""

import cmath

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.motion.state import OwnPath
from fcw.tracking.box_measurement import BoxGeometry
from fcw.tracking.range.filter import RangeFilter
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise

CAMERA = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.3, 639.5)
SIZE = ImageSize(1280, 720)
MODEL = RangeModel()
CAR = MODEL.rears[0]
STEP_S, OWN_MPS, ITS_MPS, LANE_M = 1 / 30, 15.0, 18.0, 3.5


def depth_and_box(along_m: float, radius_m: float) -> tuple[float, Box]:
    """A car in the oncoming lane to our left so far along a bend, whose radius is positive to the left.

    The depth is that of its front, and the box is around all of it, exact.
    """

    def place_m(behind_m: float, left_m: float) -> complex:
        turned = cmath.exp(1j * along_m / radius_m)
        return 1j * radius_m + (behind_m + 1j * (left_m + LANE_M - radius_m)) * turned

    half_m = CAR.width_m / 2
    corners = [place_m(behind_m, left_m) for behind_m in (0.0, CAR.length_m) for left_m in (-half_m, half_m)]
    columns = [CAMERA.column_at(corner.imag, corner.real) for corner in corners]
    depth_m = place_m(0.0, 0.0).real
    top = CAMERA.ground_box(depth_m, 0.0, CAR.width_m, CAR.height_m).y
    bottom = CAMERA.row_at(depth_m + CAR.overhang_m)
    return depth_m, Box(min(columns), top, max(columns) - min(columns), bottom - top)


def worst_sigmas(radius_m: float) -> float:
    """How many sigmas the closing speed is below the true one at worst, from one second on."""
    range_filter = RangeFilter(Calibration.from_camera(CAMERA, SIZE), BoxNoise(), MODEL)
    path, worst = OwnPath(curvature_per_m=1 / radius_m), 0.0
    for step in range(60):
        along_m = 80.0 - (OWN_MPS + ITS_MPS) * step * STEP_S
        depth_m, box = depth_and_box(along_m, radius_m)
        nearer_m, _ = depth_and_box(along_m - 0.01, radius_m)
        true_mps = (depth_m - nearer_m) / 0.01 * (OWN_MPS + ITS_MPS)
        if step == 0:
            assert range_filter.add(box, OWN_MPS)
            continue
        range_filter.predict(STEP_S, path=path)
        range_filter.update([(0, box)], STEP_S)
        if step * STEP_S > 1.0:
            state = range_filter.state(0)
            worst = max(worst, (true_mps - state.closing_speed_mps) / state.closing_speed_sigma_mps)
    return worst


@pytest.mark.parametrize("radius_m", [1e6, 300.0, 200.0, 150.0, 120.0, -120.0, -150.0, -200.0, -300.0])
def test_its_closing_speed_is_known_no_better_than_it_is(radius_m):
    # Before anything is measured it is anything between standing and as fast as we are.
    first_sigmas = (ITS_MPS + OWN_MPS / 2) / (OWN_MPS / 2 + MODEL.closing_margin_mps)
    assert worst_sigmas(radius_m) < 2 * first_sigmas


@pytest.mark.parametrize("side", [-1, 1])
def test_what_a_bend_shows_of_a_side_is_unsure_where_the_place_beside_us_hides_it(side):
    geometry = BoxGeometry(CAMERA, SIZE, BoxNoise(), MODEL)
    geometry.path = OwnPath(curvature_per_m=side / 300.0)
    distance_m = 60.0
    # It stands along the road there, just where the road leads straight away from the camera.
    box = CAMERA.ground_box(distance_m, side * 0.2 * distance_m, CAR.width_m, CAR.height_m)
    view = geometry.view(box, 0, distance_m, CAR.width_m, CAMERA.focal_y_px)
    turned_m = 0.2 * CAR.length_m
    assert view.aspect_sigma > 0.9 * MODEL.side_sigma * turned_m / (CAR.width_m + turned_m)
