"""Vehicles of a clip as rulers."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.frame import ImageSize
from fcw.self_calibration.vehicles import RULER_COUNT, VehicleRulers, ruler_of

SIZE = ImageSize(1280, 720)
CAR = Box(600, 400, 80, 60)


def test_boxes_that_are_cut_small_or_aside_are_no_rulers():
    assert ruler_of(Box(600, 400, 80, 60), SIZE) is not None
    for box in (
        Box(600, 400, 20, 15),
        Box(0, 400, 200, 100),
        Box(1100, 400, 80, 60),
        Box(600, 700, 80, 60),
        Box(600, 640, 80, 60),  # it ends where bonnets are
    ):
        assert ruler_of(box, SIZE) is None


@given(width_px=st.floats(30, 200), aspect=st.floats(0.35, 0.69))
def test_what_is_wider_than_a_rear_is_as_wide_as_its_height_tells(width_px: float, aspect: float):
    ruler = ruler_of(Box(640 - width_px / 2, 400, width_px, aspect * width_px), SIZE)
    assert ruler is not None
    assert ruler.side_known
    assert ruler.width_m.value == pytest.approx(1.5 / aspect)
    assert ruler.width_m.sigma == pytest.approx(0.15 / aspect)


def test_rears_and_what_is_taller_than_wide_are_of_their_kinds_width():
    rear, lorry = (ruler_of(Box(600, 400, 80, height_px), SIZE) for height_px in (70, 100))
    assert rear is not None
    assert lorry is not None
    assert (rear.width_m.value, rear.side_known) == (1.8, False)
    assert lorry.width_m.value - lorry.width_m.sigma < 1.9 < 2.6 < lorry.width_m.value + lorry.width_m.sigma


def test_cars_that_cross_do_not_lift_the_horizon():
    """As before a camera that stands at a crossing: by the width of rears it would be 4 degrees higher."""
    camera = GroundPlaneCamera(0.02, 1000.0, 359.5, 1.3, 639.5)
    rulers = []
    for distance_m, lateral_m in ((11.0, -2.0), (14.0, 2.0), (19.0, 0.0), (25.0, 4.0)):
        ruler = ruler_of(camera.ground_box(distance_m, lateral_m, 4.2, 1.5), SIZE)
        assert ruler is not None
        rulers.append(ruler)
    found = calibrate_jointly(Known(Evidence(rulers=tuple(rulers)), SIZE, Gaussian(1.3, 0.12)))
    assert found.horizon_row_px == pytest.approx(camera.horizon_row_px, abs=1000 * math.radians(0.5))


def test_a_vehicle_is_one_ruler_while_it_stays_and_when_it_comes_back():
    vehicles = VehicleRulers(SIZE)
    assert len(vehicles.look([CAR])) == 1
    for step in range(1, 10):  # in half a second each, until it is somewhere else and larger
        assert vehicles.look([Box(600 - 20 * step, 400, 80 + 10 * step, 60 + 8 * step)]) == []
    assert vehicles.look([]) == []
    assert vehicles.look([replace(CAR, x=602.0, w=78.0)]) == []
    assert len(vehicles.spread()) == 1


def test_another_vehicle_is_another_ruler():
    vehicles = VehicleRulers(SIZE)
    vehicles.look([CAR])
    assert len(vehicles.look([CAR, Box(700, 390, 50, 40)])) == 1
    vehicles.look([])
    assert len(vehicles.look([Box(590, 400, 130, 100)])) == 1  # where the first one was, and twice as near


def test_rulers_are_chosen_from_the_narrowest_to_the_widest():
    vehicles = VehicleRulers(SIZE)
    for number in range(RULER_COUNT + 20):
        vehicles.look([])
        vehicles.look([Box(300 + 10 * number, 200 + 4 * number, 30 + 2 * number, 30)])
    widths_px = [ruler.width_px for ruler in vehicles.spread()]
    assert len(widths_px) == RULER_COUNT
    assert widths_px == sorted(widths_px)
    assert (widths_px[0], widths_px[-1]) == (30, 30 + 2 * (RULER_COUNT + 19))
