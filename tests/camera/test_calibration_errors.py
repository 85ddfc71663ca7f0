"""Every mistake of a person gets a message that names the points and the mend."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
GOOD = ((4, 461), (5, 428), (7, 383))


def points(*pairs) -> list[GroundPoint]:
    return [GroundPoint(*pair) for pair in pairs]


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        (
            ((4, 461), (5, 428)),
            "2 points given (4:461, 5:428), expected at least 3 at different distances; add 1 more",
        ),
        ((), "0 points given (none), expected at least 3"),
        (((4, 461), (4, 428), (7, 383)), "points 4:461 and 4:428 have the same distance, 4 m"),
        (((7, 383), (4, 461), (4, 461)), "points 4:461 and 4:461 have the same distance, 4 m"),
        (
            ((4, 461), (5, 461), (7, 383)),
            "points 4:461 and 5:461 have the same row, 461, at different distances",
        ),
        (((4, 461), (5, 428), (7, 440)), "point 7:440 is farther than 5:428 but lower in the picture"),
        (((4, 383), (5, 428), (7, 461)), "point 5:428 is farther than 4:383 but lower in the picture"),
        (
            ((4, 461), (5, 440), (7, 383)),
            "points 4:461, 5:440, 7:383: the horizon would come out below the road",
        ),
        (((4, 461), (5, 435), (7, 383)), "the row at 5 m must be less than 435 for the other two"),
        (((4, 461), (5, 445), (6, 420), (7, 362)), "the horizon would come out below the road"),
        (
            ((4, 461), (5, 428), (7, 383), (20, 440)),
            "point 20:440 is farther than 7:383 but lower in the picture",
        ),
        (((4, 461), (5, 428), (7, 383), (7, 300)), "points 7:383 and 7:300 have the same distance"),
        (
            ((4, 300), (5, 350), (7, 400), (9, 450)),
            "point 5:350 is farther than 4:300 but lower in the picture",
        ),
        (((4, math.nan), (5, 428), (7, 383)), "point 4:nan: expected finite numbers"),
        (((4, 461), (5, 428), (math.inf, 383)), "point inf:383: expected finite numbers"),
        (((4, 461, math.nan), (5, 428), (7, 383)), "point 4:461:nan: expected finite numbers"),
        (((0, 461), (5, 428), (7, 383)), "point 0:461: distance 0 m, expected more than 0"),
        (((-4, 461), (5, 428), (7, 383)), "point -4:461: distance -4 m, expected more than 0"),
        (((4, 4610), (5, 428), (7, 383)), "point 4:4610: row 4610 lies far outside the picture of 1280x720"),
        (
            ((4, 461, -9000), (5, 428), (7, 383)),
            "point 4:461:-9000: column -9000 lies far outside the picture",
        ),
    ],
)
def test_degenerate_points_are_named(pairs, message):
    with pytest.raises(UserError, match=re.escape(message)):
        calibrate(points(*pairs), SIZE, 1.225)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"height_m": 0}, "camera height 0 m: expected a height above 0"),
        ({"height_m": -1.2}, "camera height -1.2 m: expected a height above 0"),
        ({"height_m": math.nan}, "camera height nan m: expected a height above 0"),
        ({"height_m": math.inf}, "camera height inf m: expected a height above 0"),
        ({"reference_offset_m": -1}, "reference offset -1 m: expected 0 or more"),
        ({"reference_offset_m": math.nan}, "reference offset nan m: expected 0 or more"),
        ({"row_sigma_px": 0}, "row sigma 0 px: expected a number above 0"),
        ({"image_size": ImageSize(0, 720)}, "image size 0x720: expected a width and height"),
        (
            {"field_of_view": Gaussian(math.pi, 0.1)},
            "field of view 180 degrees: expected more than 0 and less than 180",
        ),
        ({"field_of_view": Gaussian(1, 0)}, "field of view: sigma 0 degrees, expected a number above 0"),
        ({"principal_row": Gaussian(360, -2)}, "principal row: sigma -2, expected a number above 0"),
        ({"horizon_row": Gaussian(math.nan, 2)}, "horizon row nan: expected a finite number"),
    ],
)
def test_impossible_setups_are_named(arguments, message):
    with pytest.raises(UserError, match=re.escape(message)):
        calibrate(points(*GOOD), **{"image_size": SIZE, "height_m": 1.225, **arguments})


def test_too_few_points_beside_a_prior_say_how_many_are_missing():
    with pytest.raises(UserError, match=r"1 point given \(4:461\).*add 1 more"):
        calibrate(points((4, 461)), SIZE, 1.225, principal_row=Gaussian(360, 20))


def test_rows_that_differ_by_less_than_a_click_are_refused_together():
    nearly_equal = points((5, 400.3), (10, 400.2), (20, 400.1), (40, 400.0))
    with pytest.raises(UserError, match=r"rows of all points .*5:400\.3.* within 0\.3 px"):
        calibrate(nearly_equal, SIZE, 1.225)


GAUSSIANS = st.one_of(st.none(), st.builds(Gaussian, st.floats(0.1, 700), st.floats(0.01, 50)))


@given(
    st.lists(st.tuples(st.floats(0.1, 200), st.floats(-700, 1400)), max_size=6),
    st.booleans(),
    st.floats(0.1, 5),
    st.floats(0, 4),
    st.one_of(st.none(), st.builds(Gaussian, st.floats(0.1, 3), st.floats(0.01, 1))),
    GAUSSIANS,
    GAUSSIANS,
)
def test_any_points_give_a_finite_camera_or_a_message(
    pairs, in_order, height_m, offset_m, field_of_view, principal, horizon
):
    if in_order:
        pairs = zip(
            sorted(pair[0] for pair in pairs), sorted((pair[1] for pair in pairs), reverse=True), strict=True
        )
    try:
        calibration = calibrate(
            points(*pairs), SIZE, height_m, offset_m, 1.0, field_of_view, principal, horizon
        )
    except UserError:
        return
    camera = calibration.camera
    assert abs(camera.pitch_rad) < math.pi / 2
    assert 0 < camera.focal_y_px < math.inf
    assert math.isfinite(camera.principal_row_px)
    assert all(math.isfinite(residual) for residual in calibration.residuals_px)
    low_m, high_m = calibration.distance_interval(calibration.horizon_row_px + 20)
    distance_m = calibration.distance_at(calibration.horizon_row_px + 20)
    assert low_m <= distance_m + 1e-6 * abs(distance_m) + 1e-6
    assert not math.isnan(high_m)
