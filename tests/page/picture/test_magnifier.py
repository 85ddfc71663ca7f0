"""The glass is seen whole, and leaves the pixel under it in sight, on windows from a phone's to a desk's."""

import math

import pytest

from fcw_viz.page.picture.label_layout import Window
from fcw_viz.page.picture.magnifier import place_beside

RADIUS_PX, ROOM_PX, BESIDE_PX = 85.0, 93.0, 155.0


@pytest.mark.parametrize(("width_px", "height_px"), [(1040, 900), (640, 700), (768, 470), (390, 388)])
def test_the_glass_is_whole_and_not_over_its_pixel(width_px: int, height_px: int):
    window = Window(0.0, 0.0, width_px, height_px, 1.0)
    for column_px in range(0, width_px, 13):
        for row_px in range(0, height_px, 13):
            column, row = place_beside((column_px, row_px), window, BESIDE_PX, ROOM_PX)
            assert ROOM_PX <= column <= width_px - ROOM_PX
            assert ROOM_PX <= row <= height_px - ROOM_PX
            assert math.dist((column, row), (column_px, row_px)) > RADIUS_PX
