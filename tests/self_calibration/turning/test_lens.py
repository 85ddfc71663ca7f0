"""The lens of two unknowns."""

import math

import numpy as np
import pytest
from helpers.searching import examples
from hypothesis import given
from hypothesis import strategies as st

from fcw.frame import ImageSize
from fcw.self_calibration.turning.lens import PlainLens

AXIS_PX = (319.5, 179.5)
PLACES_PX = np.array([(10.0, 20.0), (600.0, 340.0), (320.0, 180.0), (100.0, 300.0)])
bends = st.floats(-0.4, 0.2)
lenses = st.builds(PlainLens, st.floats(500, 1200), bends, st.just(AXIS_PX))


@given(lenses)
@examples(40)
def test_rays_bent_again_lead_to_their_places(lens):
    rays = lens.rays(PLACES_PX)
    np.testing.assert_allclose(
        np.array(AXIS_PX) + lens.focal_px * lens.bent(rays.places), PLACES_PX, atol=1e-6
    )


@given(lenses)
@examples(40)
def test_it_bends_as_the_fisheye_that_is_written_of_it(lens):
    written = lens.fisheye(ImageSize(640, 360))
    np.testing.assert_allclose(written.undistorted(PLACES_PX), lens.rays(PLACES_PX).places, atol=2e-4)


@pytest.mark.parametrize(
    ("bend", "radius"),
    [
        (0.0, math.tan),  # rectilinear
        (-1 / 4, lambda angle: 2 * math.tan(angle / 2)),  # stereographic
        (-1 / 3, lambda angle: angle),  # equidistant
    ],
)
def test_it_holds_the_projections_of_the_textbooks(bend, radius):
    rays = np.array([(math.tan(angle), 0.0) for angle in (0.1, 0.5, 1.0)])
    expected = [radius(angle) for angle in (0.1, 0.5, 1.0)]
    np.testing.assert_allclose(PlainLens(1.0, bend, AXIS_PX).bent(rays)[:, 0], expected, rtol=1e-9)


@given(st.floats(-0.3, 0.2))
@examples(40)
def test_near_the_axis_it_bends_as_brown_does(bend):
    ray = np.array([(0.06, 0.08)])
    np.testing.assert_allclose(PlainLens(1.0, bend, AXIS_PX).bent(ray), ray * (1 + bend * 0.01), atol=5e-6)


@given(lenses)
@examples(40)
def test_slopes_are_those_of_finite_differences(lens):
    rays = lens.rays(PLACES_PX)
    for k in range(2):
        step = np.eye(2)[k] * 0.5
        slopes = lens.rays(PLACES_PX + step).places - lens.rays(PLACES_PX - step).places
        np.testing.assert_allclose(rays.slopes[:, :, k], slopes, rtol=5e-3, atol=2e-6)


@given(bends)
@examples(40)
def test_slopes_by_the_bend_are_those_of_finite_differences(bend):
    rays = np.array([(0.0, 0.0), (0.3, -0.2), (1.2, 0.9)])
    more, less = (PlainLens(1.0, bend + step, AXIS_PX).bent(rays) for step in (1e-5, -1e-5))
    slopes = PlainLens(1.0, bend, AXIS_PX).by_bend(rays)
    np.testing.assert_allclose(slopes, (more - less) / 2e-5, rtol=2e-3, atol=1e-6)
