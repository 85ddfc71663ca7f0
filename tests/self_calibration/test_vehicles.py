"""Vehicles of a clip as rulers."""

from dataclasses import replace

from fcw.box import Box
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
    ):
        assert ruler_of(box, SIZE) is None


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
