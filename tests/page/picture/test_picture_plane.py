"""Pixels in the scene: a ray from anywhere through a pixel's place meets the plane at that pixel."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.frame import ImageSize
from fcw_viz.page.picture.plane import FIELD_OF_VIEW_RAD, PicturePlane, layer_offset

SIZES = st.builds(ImageSize, st.integers(2, 8000), st.integers(2, 8000))
SHARE = st.floats(0, 1)


@given(SIZES, SHARE, SHARE, st.tuples(st.floats(-9, 9), st.floats(-90, -0.01), st.floats(-9, 9)))
def test_a_ray_through_a_pixels_place_meets_that_pixel(size, across, down, eye):
    plane = PicturePlane(size)
    pixel = (across * size.width - 0.5, down * size.height - 0.5)
    origin = np.array(eye)
    met = plane.pixel_under(origin, np.array(plane.world(*pixel)) - origin)
    assert met == pytest.approx(pixel, abs=1e-6)
    assert plane.is_inside(*pixel)


@given(SIZES, st.floats(0.01, 20), st.integers(100, 4000))
def test_a_view_from_its_distance_is_as_high_as_the_field_of_view(size, pixels_per_screen_pixel, height_px):
    plane = PicturePlane(size)
    distance = plane.distance(pixels_per_screen_pixel, height_px)
    seen = 2 * distance * math.tan(FIELD_OF_VIEW_RAD / 2)
    assert seen == pytest.approx(pixels_per_screen_pixel * height_px * plane.scale)
    assert plane.pixels_per_screen_pixel(distance, height_px) == pytest.approx(pixels_per_screen_pixel)


def test_rows_go_down_columns_right_and_layers_towards_the_eye():
    plane = PicturePlane(ImageSize(1280, 720))
    x, y, z = plane.world(639.5, 359.5)
    assert (x, y, z) == pytest.approx((0, 0, 0))
    assert plane.world(640.5, 359.5)[0] > 0
    assert plane.world(639.5, 360.5)[2] < 0
    assert plane.world(0, 0, layer=3)[1] == pytest.approx(layer_offset(3)[1])
    assert plane.world(0, 0, layer=3)[1] < plane.world(0, 0, layer=2)[1] < 0
    assert not plane.is_inside(-0.6, 10)
    assert not plane.is_inside(10, 719.6)
