"""What is said besides marks and rows takes part, is kept by the file, and is shown again."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Ruler
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.besides.knowledge import (
    SetEdges,
    SetLaneWidth,
    SetLens,
    SetPaced,
    SetRoll,
    SetSpeed,
    SetTapeError,
    SetVehicles,
    SetYaw,
)
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    Edit,
    SetFieldOfView,
    SetHeight,
    SetHorizon,
    SetPrincipalRow,
)
from fcw_viz.calibrate_app.document.resume import document_of
from fcw_viz.calibrate_app.document.solution import calibration_of, solve
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.ways import middle_row

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
LENS = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (-0.25, 0.06, 0.0, 0.0), SIZE)
TURNED = Orientation(math.radians(3), math.radians(2))
UNSURE_VIEW = Belief(Gaussian(math.radians(66), math.radians(16)))


def said(*edits: Edit) -> Document:
    document = Document(SIZE)
    for edit in edits:
        # As the journal keeps it.
        document = edit_from_json(edit_to_json(edit)).apply(document)
    return document


def seen(
    orientation: Orientation, lens: Lens | None, lateral_m: float, distance_m: float
) -> tuple[float, float]:
    straight = replace(CAMERA, principal_column_px=straight_column(CAMERA, orientation))
    place = np.array([[straight.column_at(lateral_m, distance_m), straight.row_at(distance_m)]])
    column_px, row_px = Straightening(straight, orientation, lens, SIZE).to_picture(place)[0]
    return float(column_px), float(row_px)


def test_a_turned_wide_camera_is_measured_saved_and_shown_again():
    marks = [
        AddMark(*seen(TURNED, LENS, lateral_m, distance_m), 0, distance_m)
        for distance_m, lateral_m in ((6.0, 1.0), (12.0, -1.0), (25.0, 1.0), (40.0, -1.0))
    ]
    turn = (
        SetYaw(Belief(Gaussian(TURNED.yaw_rad, 0.01))),
        SetRoll(Belief(Gaussian(TURNED.roll_rad, 0.01))),
    )
    document = said(*marks, SetHeight(1.3), SetLens(LENS), *turn, SetTapeError(0.02))
    solution = solve(document)
    assert solution.status is Status.GOOD
    assert solution.result is not None
    calibration = solution.result.calibration
    assert calibration.tape_error == 0.02
    column_px, row_px = calibration.straight_place(*seen(TURNED, LENS, 0.0, 30.0))
    assert calibration.distance_at(row_px) == pytest.approx(30, rel=0.01)
    assert calibration.lateral_at(column_px, row_px) == pytest.approx(0, abs=0.1)
    read = parse_calibration(calibration_text(calibration), "x")
    again = document_of(read)
    assert again.lens == LENS
    assert again.tape_error == 0.02
    assert again.yaw is not None
    assert again.roll is not None
    assert again.roll.prior.value == pytest.approx(TURNED.roll_rad, abs=0.005)
    kept = calibration_of(again)
    assert kept is not None
    assert kept.lens == LENS
    assert kept.distance_at(kept.straight_place(*seen(TURNED, LENS, 0.0, 30.0))[1]) == pytest.approx(
        30, rel=0.01
    )


def test_dashes_without_a_first_distance_are_asked_about_until_the_lens_is_known():
    dashes = [AddMark(639.5, CAMERA.row_at(9.0 + 12.0 * k), 0, 12.0 * (k + 1)) for k in range(4)]
    document = said(SetPaced(True), *dashes, SetHeight(1.3, 0.03))
    unsure = solve(document)
    assert unsure.status is Status.DOUBTFUL
    assert "12 m" in unsure.troubles[0].text
    assert "Save" not in unsure.hint
    plain = replace(LENS, coefficients=(0.0, 0.0, 0.0, 0.0))
    sure = solve(SetLens(plain).apply(document))
    assert sure.status is Status.GOOD
    assert sure.result is not None
    assert sure.result.calibration.distance_at(CAMERA.row_at(30.0)) == pytest.approx(30, rel=0.02)


def test_dashes_that_do_not_keep_their_period_are_asked_about_and_widen_the_interval():
    """A bridge's joint: the gap between the first and the second dash is 16 m, not 12 m."""
    straight = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
    marks = [
        AddMark(639.5, CAMERA.row_at(true_m), 0, 12.0 * k)
        for k, true_m in enumerate((8.0, 24.0, 36.0, 48.0), 1)
    ]
    solution = solve(said(SetHeight(1.3), SetPaced(True), *marks, SetLens(straight)))
    assert any("do not keep their period of 12 m" in trouble.text for trouble in solution.troubles)
    assert solution.status is not Status.GOOD
    assert solution.result is not None
    low_m, high_m = solution.result.calibration.distance_interval(CAMERA.row_at(40.0))
    assert low_m < 40.0 < high_m


def test_a_known_speed_stands_in_for_lens_and_height():
    """Both are believed 15 % wrong, and the product that the road's flow shows is right."""
    scale = CAMERA.focal_y_px * CAMERA.height_m / 25.0
    beliefs = (SetFieldOfView(UNSURE_VIEW), SetHorizon(Belief(Gaussian(CAMERA.horizon_row_px, 2.0))))
    rough = replace(said(SetHeight(1.5, 0.3), *beliefs), principal_row=middle_row(SIZE))
    at_speed = SetSpeed(Belief(Gaussian(25.0, 0.3)), scale).apply(rough)
    errors = []
    for document in (rough, at_speed):
        calibration = calibration_of(document)
        assert calibration is not None
        row_px = CAMERA.row_at(30.0)
        low_m, high_m = calibration.distance_interval(row_px)
        assert low_m < 30 < high_m
        errors.append(abs(calibration.distance_at(row_px) / 30 - 1))
    assert errors[1] < 0.03 < errors[0]


def test_lane_width_and_vehicles_take_part():
    lines = tuple(
        Line(seen(Orientation(), None, y, 7.0), seen(Orientation(), None, y, 40.0)) for y in (1.75, -1.75)
    )
    rulers = tuple(
        Ruler(639.5, CAMERA.row_at(d), 1000 * VEHICLE_WIDTH_M.value / d, VEHICLE_WIDTH_M, 1.0)
        for d in (10.0, 15.0, 20.0, 30.0, 45.0)
    )
    lens = replace(LENS, coefficients=(0.0, 0.0, 0.0, 0.0))
    start = replace(said(SetHeight(1.5, 0.3), SetLens(lens)), lane_lines=(lines[0], lines[1]))
    for edit in (SetLaneWidth(Belief(Gaussian(3.5, 0.05))), SetVehicles(rulers)):
        calibration = calibration_of(edit.apply(start))
        assert calibration is not None
        assert calibration.distance_at(CAMERA.row_at(30.0)) == pytest.approx(30, rel=0.06)


def test_what_makes_no_sense_is_refused_in_words():
    document = Document(SIZE)
    wrong: tuple[tuple[Edit, str], ...] = (
        (SetTapeError(0.7), "tape error"),
        (SetRoll(Belief(Gaussian(1.0, 0.1))), "roll 57.3 degrees"),
        (SetLaneWidth(Belief(Gaussian(-1.0, 0.1))), "lane width"),
        (SetSpeed(Belief(Gaussian(0.0, 0.1)), None), "speed"),
        (SetLens(replace(LENS, image_size=ImageSize(640, 480))), "another aspect ratio"),
    )
    for edit, words in wrong:
        with pytest.raises(UserError, match=words):
            edit.apply(document)


def test_a_picture_that_its_lens_bends_is_told_and_mended_by_fitting_the_lens():
    rng = np.random.default_rng(1)
    places = [(*seen(Orientation(), LENS, y, d), d) for d in (6.0, 15.0, 30.0) for y in (-4.0, 0.0, 4.0)]
    clicked = [(u + rng.normal(0, 0.5), v + rng.normal(0, 0.5), d) for u, v, d in places]
    marks = [AddMark(u, v, 0, d) for u, v, d in clicked if 0 <= u < SIZE.width]
    document = said(*marks, SetHeight(1.3))
    solution = solve(document)
    (trouble,) = [trouble for trouble in solution.troubles if "lens bends this picture" in trouble.text]
    assert "--chessboard" in trouble.text
    assert trouble.mend is not None
    for edit in trouble.mend.edits:
        document = edit_from_json(edit_to_json(edit)).apply(document)
    mended = solve(document)
    assert mended.status is Status.GOOD
    assert mended.result is not None
    lens = mended.result.calibration.lens
    assert lens is not None
    assert lens.coefficients[0] == pytest.approx(-0.25, abs=0.1)
    again = document_of(parse_calibration(calibration_text(mended.result.calibration), "x"))
    assert again.lens == lens


def test_places_along_a_straight_edge_show_a_lens_that_bends():
    rows_px = np.linspace(0, 719, 9)
    # A pole: it bows away from the picture's middle in the middle, as behind a wide lens.
    pole = tuple((60.0 + 25.0 * ((v - 359.5) / 359.5) ** 2, float(v)) for v in rows_px)
    known = (SetHeight(1.3), SetFieldOfView(UNSURE_VIEW), SetHorizon(Belief(Gaussian(310.0, 3.0))))
    middle = SetPrincipalRow(middle_row(SIZE))
    straight = tuple((60.0, float(v)) for v in rows_px)
    assert not solve(said(*known, middle, SetEdges((straight,)))).troubles
    (trouble,) = solve(said(*known, middle, SetEdges((pole,)))).troubles
    assert "The lens bends this picture" in trouble.text


def test_a_known_speed_stands_in_for_the_lens():
    horizon = SetHorizon(Belief(Gaussian(309.5, 3.0)))
    speed = SetSpeed(Belief(Gaussian(25.0, 0.3)), CAMERA.focal_y_px * CAMERA.height_m / 25.0)
    solution = solve(said(SetHeight(1.3, 0.03), SetPrincipalRow(middle_row(SIZE)), horizon, speed))
    assert solution.status is Status.GOOD
    assert solution.result is not None
    assert solution.result.calibration.camera.focal_y_px == pytest.approx(1000.0, rel=0.05)
