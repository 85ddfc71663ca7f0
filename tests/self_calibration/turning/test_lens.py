"""The lens of two unknowns."""

import numpy as np
from helpers.searching import examples
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.lens.model import Lens
from fcw.frame import ImageSize
from fcw.self_calibration.turning.lens import PlainLens

AXIS_PX = (319.5, 179.5)
PLACES_PX = np.array([(10.0, 20.0), (600.0, 340.0), (320.0, 180.0), (100.0, 300.0)])
lenses = st.builds(PlainLens, st.floats(600, 1200), st.floats(-0.25, 0.2), st.just(AXIS_PX))


@given(lenses)
@examples(40)
def test_rays_bent_again_lead_to_their_places(lens):
    rays = lens.rays(PLACES_PX)
    np.testing.assert_allclose(
        np.array(AXIS_PX) + lens.focal_px * lens.bent(rays.places), PLACES_PX, atol=0.05
    )


@given(lenses)
@examples(40)
def test_it_bends_as_opencv_does(lens):
    known = Lens(
        "radtan", lens.focal_px, lens.focal_px, *AXIS_PX, (lens.bend, 0.0, 0.0, 0.0), ImageSize(640, 360)
    )
    rays = known.undistorted(PLACES_PX)
    np.testing.assert_allclose(np.array(AXIS_PX) + lens.focal_px * lens.bent(rays), PLACES_PX, atol=1e-6)


@given(lenses)
@examples(40)
def test_slopes_are_those_of_finite_differences(lens):
    rays = lens.rays(PLACES_PX)
    for k in range(2):
        step = np.eye(2)[k] * 0.5
        slopes = lens.rays(PLACES_PX + step).places - lens.rays(PLACES_PX - step).places
        np.testing.assert_allclose(rays.slopes[:, :, k], slopes, rtol=5e-3, atol=2e-6)
