"""A rectangle on the road, by its four corners: exact cameras come back, and intervals hold the truth."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration, Gaussian, GroundRectangle
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.odd_rectangle import odd_rectangle
from fcw.camera.joint.rectangle import check_rectangle, going_round
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
REAL = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
LEVEL, TURNED = Orientation(), Orientation(math.radians(3), math.radians(2))
WIDE = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.0, 0.0), SIZE)
ANY_HEIGHT, MEASURED = Gaussian(1.5, 0.5), Gaussian(1.3, 0.013)
BAY_M = (2.5, 5.0)


def picture(orientation: Orientation = LEVEL, lens: Lens | None = None, camera=REAL) -> Straightening:
    column_px = straight_column(camera, orientation)
    return Straightening(replace(camera, principal_column_px=column_px), orientation, lens, SIZE)


def corners(
    there: Straightening,
    middle_m: tuple[float, float],
    heading_deg: float,
    sides_m=BAY_M,
    off_m: complex | np.ndarray = 0.0,
) -> np.ndarray:
    """(4, 2) columns and rows of a rectangle; written out anew, with complex numbers for the ground."""
    turn = np.exp(1j * math.radians(heading_deg))
    along, across = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    ground = complex(*middle_m) + turn * (along * sides_m[0] + 1j * across * sides_m[1]) / 2 + off_m
    camera = there.camera
    straight = [(camera.column_at(g.imag, g.real), camera.row_at(g.real)) for g in ground]
    return there.to_picture(np.array(straight))


def rectangle(places: np.ndarray, first=None, second=None, along=False) -> GroundRectangle:
    return GroundRectangle(tuple((float(u), float(v)) for u, v in places), first, second, along)


def exactly(value_m: float) -> Gaussian:
    return Gaussian(value_m, 1e-4 * value_m)


def exact(evidence: Evidence, height_m: Gaussian, lens: Lens | None = None) -> Calibration:
    return calibrate_jointly(Known(evidence, SIZE, height_m, click_sigma_px=1e-3, lens=lens, tape_error=0.0))


@pytest.mark.parametrize("lens", [None, WIDE])
@pytest.mark.parametrize("orientation", [LEVEL, TURNED])
@pytest.mark.parametrize(("middle_m", "heading_deg"), [((8, -1), 20.0), ((9, 3), -60.0), ((12, -4), 170.0)])
def test_an_exact_rectangle_gives_the_camera_that_took_it(middle_m, heading_deg, orientation, lens):
    there = picture(orientation, lens)
    bay = rectangle(corners(there, middle_m, heading_deg), exactly(2.5), exactly(5.0))
    camera = exact(Evidence(rectangles=(bay,)), ANY_HEIGHT, lens)
    assert camera.camera.pitch_rad == pytest.approx(REAL.pitch_rad, abs=1e-4)
    assert camera.camera.focal_y_px == pytest.approx(REAL.focal_y_px, rel=1e-4)
    assert camera.camera.principal_row_px == pytest.approx(REAL.principal_row_px, abs=0.1)
    assert camera.camera.height_m == pytest.approx(REAL.height_m, rel=1e-3)
    assert camera.orientation.roll_rad == pytest.approx(orientation.roll_rad, abs=1e-4)


def test_one_known_side_tells_the_height_and_none_leaves_it():
    there = picture(TURNED)
    places = corners(there, (9, 2), 30.0)
    for first, second in ((2.5, None), (None, 5.0)):
        bay = rectangle(places, first and exactly(first), second and exactly(second))
        assert exact(Evidence(rectangles=(bay,)), ANY_HEIGHT).camera.height_m == pytest.approx(1.3, rel=1e-3)
    shape = exact(Evidence(rectangles=(rectangle(places),)), MEASURED)
    assert shape.camera.focal_y_px == pytest.approx(1000, rel=1e-3)
    assert shape.camera.pitch_rad == pytest.approx(0.05, abs=1e-4)
    assert shape.orientation.roll_rad == pytest.approx(TURNED.roll_rad, abs=1e-4)


def test_sides_along_the_road_tell_the_yaw():
    there = picture(TURNED)
    bay = rectangle(corners(there, (9, 2), 90.0), exactly(2.5), exactly(5.0), along=True)
    orientation = exact(Evidence(rectangles=(bay,)), ANY_HEIGHT).orientation
    # A degree between paint and car, against five of a camera that somebody put up.
    assert orientation.yaw_rad == pytest.approx(TURNED.yaw_rad * 25 / 26, abs=1e-4)
    assert orientation.yaw_sigma_rad == pytest.approx(math.radians(math.sqrt(25 / 26)), rel=1e-3)


@settings(max_examples=6, deadline=None)
@given(
    middle_m=st.tuples(st.floats(7, 14), st.floats(-3, 3)),
    heading_deg=st.floats(-180, 180),
    start=st.integers(0, 3),
    backward=st.booleans(),
    seed=st.integers(0, 99),
)
def test_it_does_not_matter_which_corner_is_clicked_first_nor_which_way_round(
    middle_m, heading_deg, start, backward, seed
):
    places = corners(picture(TURNED), middle_m, heading_deg)
    places = places + np.random.default_rng(seed).normal(0, 1, places.shape)
    order = np.roll(np.arange(4), -start)
    order = np.array([order[0], *order[:0:-1]]) if backward else order
    sides = [Gaussian(2.5, 0.05), Gaussian(5.0, 0.1)]
    turned = sides[::-1] if (start + backward) % 2 else sides
    seen = []
    for there, lengths in ((places, sides), (places[order], turned)):
        known = Known(Evidence(rectangles=(rectangle(there, lengths[0], lengths[1]),)), SIZE, ANY_HEIGHT)
        seen.append(calibrate_jointly(known))
    rows_px = [camera.row_at(np.array([6.0, 15.0, 40.0])) for camera in seen]
    assert rows_px[0] == pytest.approx(rows_px[1], abs=0.02)
    assert np.array(seen[0].covariance) == pytest.approx(np.array(seen[1].covariance), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("way", ["bay", "sides unknown"])
def test_intervals_hold_the_truth_as_often_as_they_say(way):
    """100 cameras drawn from what is believed; three binomial sigmas of 68 % are 14 %."""
    rng, inside, count = np.random.default_rng(11), 0, 100
    for _ in range(count):
        camera, known = sampled(rng, way)
        calibration = calibrate_jointly(known)
        straight = calibration.straightening
        place = camera.to_picture(
            np.array([[camera.camera.column_at(0.0, 20.0), camera.camera.row_at(20.0)]])
        )
        row_px = place[0, 1] if straight is None else straight.to_straight(place)[0, 1]
        low_m, high_m = calibration.distance_interval(float(row_px))
        inside += low_m <= 20.0 <= high_m
    assert inside / count == pytest.approx(0.68, abs=0.14)


def sampled(rng: np.random.Generator, way: str) -> tuple[Straightening, Known]:
    """A camera and a bay before it, clicked to a pixel, with paint and tape that err as is believed."""
    while True:
        view_rad = math.radians(np.clip(rng.normal(75, 20), 40, 120))
        camera = GroundPlaneCamera(
            math.atan(rng.normal(0.05, 0.08)),
            640 / math.tan(view_rad / 2),
            359.5 + 21.6 * rng.standard_normal(),
            1.3 * math.exp(0.15 * rng.standard_normal()),
            639.5,
        )
        there = picture(Orientation(0.0, math.radians(1.5) * rng.standard_normal()), camera=camera)
        tape = math.exp(0.01 * rng.standard_normal())
        sides_m = (
            tape * 2.5 * (1 + 0.02 * rng.standard_normal()),
            tape * 5 * (1 + 0.02 * rng.standard_normal()),
        )
        off_m = 0.0025 * math.sqrt(2.5 * 5) * rng.standard_normal((4, 2)) @ (1, 1j)
        middle_m = (rng.uniform(7, 11), rng.uniform(-2, 2))
        places = corners(there, middle_m, rng.uniform(-180, 180), sides_m, off_m)
        inside = np.isfinite(places).all() and (places > 0).all() and (places < (1280, 720)).all()
        if inside and camera.horizon_row_px > 0:
            break
    places = places + rng.normal(0, 1, places.shape)
    sides = (None, None) if way == "sides unknown" else (Gaussian(2.5, 0.05), Gaussian(5.0, 0.1))
    height_m = Gaussian(1.3, 0.2)
    if way != "bay":
        height_m = Gaussian(camera.height_m * (1 + 0.02 * rng.standard_normal()), 0.02 * camera.height_m)
    return there, Known(Evidence(rectangles=(rectangle(places, *sides),)), SIZE, height_m)


def test_it_weighs_in_with_everything_else():
    """With lane lines the far distances of a bay alone become sharper."""
    there = picture()
    bay = rectangle(corners(there, (8, 0), 10.0), Gaussian(2.5, 0.05), Gaussian(5.0, 0.1))

    def line(lateral_m: float):
        near, far = ((there.camera.column_at(lateral_m, d), there.camera.row_at(d)) for d in (7.0, 40.0))
        return near, far

    alone = calibrate_jointly(Known(Evidence(rectangles=(bay,)), SIZE, ANY_HEIGHT))
    lines = Evidence(rectangles=(bay,), lines=(line(1.8), line(-1.8)))
    both = calibrate_jointly(Known(lines, SIZE, ANY_HEIGHT))
    widths_m = [np.ptp(camera.distance_interval(camera.row_at(40.0))) for camera in (alone, both)]
    assert widths_m[1] < 0.8 * widths_m[0]


def test_exchanged_sides_and_corners_elsewhere_are_told():
    there, rng = picture(), np.random.default_rng(2)
    places = corners(there, (9, 1), 25.0) + rng.normal(0, 1, (4, 2))
    sides = (Gaussian(2.5, 0.03), Gaussian(5.0, 0.05))

    def told(places: np.ndarray, first: Gaussian, second: Gaussian):
        return odd_rectangle(Known(Evidence(rectangles=(rectangle(places, first, second),)), SIZE, MEASURED))

    assert told(places, *sides) is None
    exchanged = told(places, *reversed(sides))
    assert exchanged is not None
    assert exchanged.swapped
    assert "2.5 m" in exchanged.text
    elsewhere = places.copy()
    elsewhere[2] += (60, 25)
    wrong = told(elsewhere, *sides)
    assert wrong is not None
    assert not wrong.swapped
    assert "no rectangle of 2.5 by 5 m" in wrong.text


def test_it_survives_the_file_and_another_size_of_the_pictures():
    there = picture(TURNED)
    bay = rectangle(corners(there, (9, 1), 25.0), Gaussian(2.5, 0.05), None, along=True)
    calibration = calibrate_jointly(Known(Evidence(rectangles=(bay,)), SIZE, ANY_HEIGHT))
    back = parse_calibration(calibration_text(calibration), "x")
    assert back == calibration
    assert back.rectangles == (bay,)
    half = calibration.for_image_size(ImageSize(640, 360)).rectangles[0]
    assert half.corners_px[0] == pytest.approx((np.array(bay.corners_px[0]) + 0.5) / 2 - 0.5)
    assert half.first_side_m == bay.first_side_m


SQUARE = ((100.0, 600.0), (300.0, 600.0), (280.0, 500.0), (120.0, 500.0))


@pytest.mark.parametrize(
    ("corners_px", "side_m", "message"),
    [
        (SQUARE[:3], 2.5, "3 corners, expected 4"),
        ((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]), 2.5, "do not go round it"),
        ((*SQUARE[:3], (290.0, 550.0)), 2.5, "do not go round it, or three of them lie on one line"),
        ((*SQUARE[:3], (9999.0, 500.0)), 2.5, "column 9999, row 500 is far outside the picture of 1280x720"),
        ((*SQUARE[:3], (281.0, 500.0)), 2.5, "a side is 1.0 px long"),
        ((*SQUARE[:3], (math.nan, 500.0)), 2.5, "expected 4, column and row"),
        (SQUARE, 0.0, r"side 0 ± 0.05 m: expected 0.3 to 100 m"),
    ],
)
def test_corners_and_sides_that_are_none_are_refused(corners_px, side_m, message):
    with pytest.raises(UserError, match=message):
        check_rectangle(GroundRectangle(corners_px, Gaussian(side_m, 0.05)), SIZE)


def test_corners_clicked_crosswise_are_put_in_turn():
    crossed = (SQUARE[0], SQUARE[1], SQUARE[3], SQUARE[2])
    assert going_round(crossed) == SQUARE
    assert going_round(SQUARE) == SQUARE
    assert going_round((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]))[0] == SQUARE[0]
    check_rectangle(GroundRectangle(going_round((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]))), SIZE)
