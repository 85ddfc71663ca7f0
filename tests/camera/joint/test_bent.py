"""A lens that bends the picture is noticed by marks beside each other and by straight edges; straight ones
are not accused."""

import math

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.bent import WIDE_BEND, bent_picture
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
HEIGHT = Gaussian(1.3, 0.03)
BENT = (-0.25, 0.06, 0.0, 0.0)
MARKS_M = (6.0, 15.0, 30.0)
LANE_LINES = (((290.0, 684.0), (630.0, 449.0)), ((908.0, 566.0), (729.0, 454.0)))


def picture_of(view_deg: float, coefficients: tuple[float, ...] | None, yaw_deg=1.0, roll_deg=-1.0):
    focal_px = SIZE.width / 2 / math.tan(math.radians(view_deg) / 2)
    real = GroundPlaneCamera(0.03, focal_px, 365.0, HEIGHT.value, 639.5)
    turned = Orientation(math.radians(yaw_deg), math.radians(roll_deg))
    straight = GroundPlaneCamera(0.03, focal_px, 365.0, HEIGHT.value, straight_column(real, turned))
    lens = None
    if coefficients is not None:
        lens = Lens("radtan", focal_px, focal_px, 639.5, 365.0, coefficients, SIZE)
    return Straightening(straight, turned, lens, SIZE)


def marks(there: Straightening, rng: np.random.Generator, laterals_m=(-3.0, 0.0, 3.0)) -> Evidence:
    points = []
    for distance_m in MARKS_M:
        for lateral_m in laterals_m:
            place = [[there.camera.column_at(lateral_m, distance_m), there.camera.row_at(distance_m)]]
            column_px, row_px = there.to_picture(np.array(place))[0] + rng.normal(0, 1, 2)
            if 0 <= column_px < SIZE.width and 0 <= row_px < SIZE.height:
                points.append(GroundPoint(distance_m, float(row_px), float(column_px)))
    return Evidence(tuple(points))


def poles(there: Straightening, rng: np.random.Generator) -> Evidence:
    """Two lamp posts, one at each side, clicked at nine places from top to bottom."""
    edges = []
    for column_px in (-20.0, 1300.0):
        straight = np.column_stack((np.full(9, column_px), np.linspace(-40, 700, 9)))
        places = there.to_picture(straight) + rng.normal(0, 1, (9, 2))
        inside = (places > 0).all(axis=1) & (places < (SIZE.width, SIZE.height)).all(axis=1)
        edges.append(tuple((float(u), float(v)) for u, v in places[inside]))
    return Evidence(edges=tuple(edge for edge in edges if len(edge) >= 5))


@pytest.mark.parametrize("clicked", [marks, poles])
def test_a_wide_lens_is_noticed_and_fitted(clicked):
    there, rng = picture_of(85.0, BENT), np.random.default_rng(1)
    evidence = clicked(there, rng)
    found = bent_picture(Known(evidence, SIZE, HEIGHT))
    assert found is not None
    assert found.lens.coefficients[0] == pytest.approx(BENT[0], abs=0.1)
    assert "the lens bends this picture" in found.text


def test_a_lens_that_is_fitted_with_the_rest_puts_what_lies_aside_where_it_is():
    there, rng = picture_of(85.0, BENT), np.random.default_rng(1)
    evidence = marks(there, rng)
    place = there.to_picture(np.array([[there.camera.column_at(9.0, 12.0), there.camera.row_at(12.0)]]))
    seen_m = []
    for bend in (WIDE_BEND, None):
        calibration = calibrate_jointly(Known(evidence, SIZE, HEIGHT, bend=bend))
        way = calibration.straightening
        seen_m.append(
            calibration.distance_at(float((place if way is None else way.to_straight(place))[0, 1]))
        )
    fitted_m, plain_m = seen_m
    assert fitted_m == pytest.approx(12, rel=0.03)
    assert plain_m > 1.05 * 12


def test_what_cannot_tell_of_a_lens_is_not_asked():
    there, rng = picture_of(85.0, BENT), np.random.default_rng(1)
    assert bent_picture(Known(marks(there, rng, (0.0,)), SIZE, HEIGHT)) is None
    assert bent_picture(Known(Evidence(lines=LANE_LINES), SIZE, HEIGHT)) is None


@pytest.mark.slow
def test_straight_pictures_are_not_accused():
    """`benchmarks/calibration/bent.py` has 500 of each."""
    rng, accused = np.random.default_rng(2), 0
    for number in range(60):
        there = picture_of(rng.uniform(50, 110), None, rng.normal(0, 2), rng.normal(0, 1))
        evidence = (marks if number % 2 else poles)(there, rng)
        accused += bent_picture(Known(evidence, SIZE, HEIGHT)) is not None
    assert accused <= 2
