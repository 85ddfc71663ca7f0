"""Which edges of a box say something of range, in pictures of 1280x720."""

import math

import pytest

from fcw.box import Box
from fcw.frame import ImageSize
from fcw.tracking.ranging import BoxNoise, measures_height, measures_row, measures_width

SIZE = ImageSize(1280, 720)
SHARP = BoxNoise(edge_floor_px=0.5, edge_fraction=0.0)


@pytest.mark.parametrize(("bottom", "measures"), [(719.5, False), (718.0, False), (716.0, True)])
def test_a_box_cut_by_the_lower_border_is_no_row_measurement(bottom, measures):
    assert measures_row(Box(500, bottom - 200, 250, 200), SIZE, SHARP) == measures


@pytest.mark.parametrize(("x", "measures"), [(-0.5, False), (1.0, False), (3.0, True), (1180.0, False)])
def test_a_box_cut_by_a_side_is_no_width_measurement(x, measures):
    assert measures_width(Box(x, 300, 100, 80), SIZE, SHARP) == measures


def test_an_edge_within_its_own_noise_of_the_border_may_be_the_border():
    rough = BoxNoise(edge_floor_px=5.0, edge_fraction=0.0, bottom_ratio=2.0)
    assert not measures_row(Box(500, 500, 250, 205), SIZE, rough)
    assert measures_row(Box(500, 500, 250, 195), SIZE, rough)
    assert not measures_width(Box(8, 300, 100, 80), SIZE, rough)
    assert measures_width(Box(11, 300, 100, 80), SIZE, rough)


@pytest.mark.parametrize(
    ("free", "top", "measures"), [(True, 100, True), (True, 0, False), (False, 100, False)]
)
def test_a_height_is_measured_where_boxes_have_one_of_their_own(free, top, measures):
    noise = BoxNoise(edge_floor_px=0.5, edge_fraction=0.0, free_height=free)
    assert measures_height(Box(500, top, 100, 80), SIZE, noise) == measures


def test_the_sigma_of_a_width_is_that_of_two_independent_edges():
    noise = BoxNoise(edge_floor_px=3.0, edge_fraction=0.04)
    # Edges of a box 100 px high: hypot(3, 4) = 5 px.
    assert noise.log_width_sigma(Box(0, 0, 50, 100)) == pytest.approx(math.sqrt(2) * 5 / 50)


@pytest.mark.parametrize(("dt_s", "factor"), [(1 / 30, 6.0), (0.1, 2.0), (1.0, 1.0), (math.inf, 1.0)])
def test_noise_that_lasts_is_counted_as_more_noise_the_shorter_the_step(dt_s, factor):
    assert BoxNoise(correlation_s=0.1).white(dt_s) == pytest.approx(factor)
