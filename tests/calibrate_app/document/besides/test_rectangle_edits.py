"""A rectangle on the page: clicked in any order, sized, undone, saved, and judged."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.besides.joint_fit import sides_are_exchanged
from fcw_viz.calibrate_app.document.besides.rectangles import (
    AddCorner,
    MoveCorner,
    RectangleEdit,
    RemoveRectangle,
    SetAlong,
    SetSides,
)
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.edits import ChooseWay, Edit
from fcw_viz.calibrate_app.document.resume import document_of
from fcw_viz.calibrate_app.document.solution import calibration_of, solve
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.ways import RECTANGLE, clicks_corners
from fcw_viz.calibrate_app.panels.road.rectangle import found_words

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
SIDES = (Gaussian(2.5, 0.02), Gaussian(5.0, 0.02))


def clicks() -> list[AddCorner]:
    """The corners of a bay of 2.5 x 5 m, turned by 25 degrees, its short side first."""
    turn, found = np.exp(1j * math.radians(25)), []
    for along, across in ((-1.25, -2.5), (1.25, -2.5), (1.25, 2.5), (-1.25, 2.5)):
        ground = 9.0 + turn * complex(along, across)
        found.append(AddCorner(CAMERA.column_at(ground.imag, ground.real), CAMERA.row_at(ground.real)))
    return found


def said(*edits: Edit, way: str = RECTANGLE) -> Document:
    document = ChooseWay(way).apply(Document(SIZE))
    for edit in edits:
        document = edit_from_json(edit_to_json(edit)).apply(document)
    return document


WHOLE = (*clicks(), SetSides(0, *SIDES))


def test_the_page_asks_for_what_comes_next_until_the_camera_is_there():
    hints = [solve(said(*WHOLE[:count])).hint for count in range(6)]
    assert "Click a corner of a rectangle" in hints[0]
    assert [hint[-8:] for hint in hints[1:4]] == ["3 to go.", "2 to go.", "1 to go."]
    assert "type one of its sides" in hints[4]
    solution = solve(said(*WHOLE))
    assert solution.status is Status.GOOD
    assert solution.can_save
    assert solution.result is not None
    camera = solution.result.calibration.camera
    assert camera.height_m == pytest.approx(1.3, rel=0.02)
    assert camera.pitch_rad == pytest.approx(0.05, abs=0.005)
    words = found_words(solution.result.calibration, said(*WHOLE).rectangles[0], imperial=False)
    assert words == "Result: 2.50 by 5.00 m, camera height 1.30 m."


def test_only_in_its_way_and_until_it_is_whole_a_click_is_a_corner():
    assert clicks_corners(said())
    assert clicks_corners(said(*WHOLE[:3]))
    assert not clicks_corners(said(*WHOLE[:4]))
    assert not clicks_corners(said(way="tape"))
    assert not clicks_corners(Document(SIZE))


def test_corners_clicked_crosswise_are_put_in_turn_and_each_can_be_moved():
    a, b, c, d = clicks()
    document = said(a, b, d, c)
    places = [(corner.column_px, corner.row_px) for corner in (a, b, c, d)]
    assert document.rectangles[0].corners_px == pytest.approx(np.array(places))
    moved = MoveCorner(0, 2, 700.0, 500.0).apply(document).rectangles[0].corners_px
    assert moved[2] == (700.0, 500.0)
    assert moved[:2] == document.rectangles[0].corners_px[:2]
    outside = MoveCorner(0, 2, 9999.0, 500.0).apply(document).rectangles[0].corners_px
    assert outside[2] == (1279.5, 500.0)


def test_a_rule_s_sides_are_given_the_way_round_that_fits():
    assert not sides_are_exchanged(said(*WHOLE), 0)
    assert sides_are_exchanged(said(*clicks(), SetSides(0, *reversed(SIDES))), 0)


def test_exchanged_sides_are_said_and_mended_by_a_button():
    solution = solve(said(*clicks(), SetSides(0, *reversed(SIDES))))
    assert solution.status is Status.IMPLAUSIBLE
    trouble = solution.troubles[0]  # before what comes of it
    assert "exchanged" in trouble.text
    assert trouble.mend is not None
    assert trouble.mend.edits == (SetSides(0, *SIDES),)


def test_corners_that_cross_each_other_are_said_and_nothing_is_saved():
    places = WHOLE[2]
    assert isinstance(places, AddCorner)
    crossed = MoveCorner(0, 0, places.column_px + 30, places.row_px - 5)
    solution = solve(said(*WHOLE, crossed))
    assert solution.status is Status.DEGENERATE
    assert "go round it" in solution.troubles[0].text
    assert not solution.can_save


def test_its_file_brings_the_corners_and_sides_back_and_gives_the_same_camera():
    document = said(*WHOLE, SetAlong(0, True))
    calibration = calibration_of(document)
    assert calibration is not None
    again = document_of(parse_calibration(calibration_text(calibration), "x"))
    assert again.rectangles == document.rectangles
    assert again.way == RECTANGLE
    assert again.height_m is None
    assert calibration_of(again) == calibration
    assert document_of(replace(calibration, rectangles=())).rectangles == ()


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (SetSides(1, None, None), "that rectangle is gone"),
        (SetSides(0, Gaussian(0.0, 0.1), None), "side 0 ± 0.1 m: expected 0.3 to 100 m"),
        (SetSides(0, Gaussian(2.5, 0.0), None), "an error above 0"),
        (MoveCorner(0, 4, 1.0, 1.0), "that corner is gone"),
        (MoveCorner(0, 0, math.nan, 1.0), "expected finite numbers"),
        (RemoveRectangle(-1), "that rectangle is gone"),
        (SetAlong(3, True), "that rectangle is gone"),
    ],
)
def test_what_is_no_rectangle_is_refused(edit: RectangleEdit, message):
    with pytest.raises(UserError, match=message):
        edit.apply(said(*WHOLE))


def test_it_can_be_removed_and_the_next_one_clicked():
    document = RemoveRectangle(0).apply(said(*WHOLE, *clicks()))
    assert len(document.rectangles) == 1
    assert document.rectangles[0].sides_m == (None, None)
    with pytest.raises(UserError, match="clicked already"):
        said(clicks()[0], clicks()[0])
