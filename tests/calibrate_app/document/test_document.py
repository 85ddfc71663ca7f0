"""What edits make of a document, and which of them it refuses."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from session_helpers import SIZE, edits, said

from fcw.camera.calibration import Gaussian
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief, Document, Line, Mark
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    DeleteMark,
    EnableMark,
    Load,
    MoveMark,
    PlanDistances,
    SetDistance,
    SetFieldOfView,
    SetHeight,
    SetHorizon,
    SetLaneLine,
    SetReference,
    SetRowSigma,
)


def test_marks_are_named_like_spreadsheet_columns():
    assert [Mark(number, 0, 0).name for number in (1, 2, 26, 27, 52, 53, 703)] == [
        *("A", "B", "Z", "AA", "AZ", "BA", "AAA")
    ]


def test_a_deleted_mark_gives_its_number_to_no_other():
    document = said((5, 600), (10, 500))
    document = AddMark(1, 2).apply(DeleteMark(2).apply(document))
    assert [mark.id for mark in document.marks] == [1, 3]


def test_planned_distances_go_to_the_marks_in_the_order_of_clicking():
    document = PlanDistances((4, 5, 7)).apply(Document(SIZE))
    for row_px in (461, 428, 383, 350):
        document = AddMark(600, row_px).apply(document)
    assert [mark.distance_m for mark in document.marks] == [4, 5, 7, None]


def test_a_plan_for_marks_already_clicked_starts_with_the_nearest():
    document = Document(SIZE)
    for row_px in (383, 461, 428):
        document = AddMark(600, row_px).apply(document)
    document = PlanDistances((4, 5, 7)).apply(document)
    assert {mark.row_px: mark.distance_m for mark in document.marks} == {461: 4, 428: 5, 383: 7}


def test_a_deleted_mark_gives_its_planned_distance_back():
    document = PlanDistances((4, 5, 7)).apply(Document(SIZE))
    for row_px in (461, 428):
        document = AddMark(600, row_px).apply(document)
    document = AddMark(600, 460).apply(DeleteMark(1).apply(document))
    assert document.marks[-1].distance_m == 4


def test_a_mark_dragged_out_of_the_picture_stays_at_its_edge():
    document = MoveMark(1, 5000, -40).apply(said((5, 600)))
    assert (document.marks[0].column_px, document.marks[0].row_px) == (1279.5, -0.5)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (AddMark(-1, 300), "a click at column -1, row 300 is outside the picture of 1280x720"),
        (AddMark(600, 719.6), "outside the picture"),
        (AddMark(600, math.nan), "place of the click 600, nan: expected finite numbers"),
        (AddMark(600, 300, 0, -4), "distance -4: expected a number above 0"),
        (MoveMark(1, math.nan, 3), "place of the point nan, 3: expected finite numbers"),
        (MoveMark(7, 1, 1), "that point is gone"),
        (SetDistance(1, 0), "distance 0: expected a number above 0"),
        (SetDistance(1, math.inf), "distance inf: expected a number above 0"),
        (EnableMark(7, True), "that point is gone"),
        (DeleteMark(7), "that point is gone"),
        (PlanDistances((4, -5)), "distance -5"),
        (SetHeight(0), "camera height 0: expected a number above 0"),
        (SetReference(True, -1), "offset -1 m: expected 0 or more"),
        (SetRowSigma(0), "click error 0: expected a number above 0"),
        (SetFieldOfView(Belief(Gaussian(math.pi, 0.1))), "field of view 180 degrees: expected more than 0"),
        (SetHorizon(Belief(Gaussian(300, 0))), "uncertainty of the horizon 0: expected a number above 0"),
        (SetHorizon(Belief(Gaussian(math.nan, 1))), "horizon nan: expected finite numbers"),
        (SetLaneLine(2, None), "lane line 2: expected 0 or 1"),
        (SetLaneLine(0, Line((1, 2), (1, 2))), "both ends of the lane line are at the same place"),
        (Load(Document(ImageSize(640, 360))), "these points were clicked in pictures of 640x360"),
    ],
)
def test_impossible_edits_are_refused_with_the_mend(edit, message):
    with pytest.raises(UserError, match=re.escape(message)):
        edit.apply(said((5, 600)))


@given(edits | st.builds(Load, st.just(said((5, 600), (9, 500), height_m=1.2))))
def test_an_edit_survives_its_form_on_the_disk(edit):
    assert edit_from_json(edit_to_json(edit)) == edit


@pytest.mark.parametrize(
    "value",
    [
        {"edit": "SetSail", "wind": 3},
        {"edit": "SetHeight", "height_m": "tall"},
        {"edit": "SetHeight", "height_m": True},
        {"edit": "SetHeight", "height_m": 1.2, "width_m": 3},
        {"edit": "DeleteMark", "id": 1.5},
        {"edit": "SetLaneLine", "index": 0, "line": {"start_px": [1], "end_px": [2, 3]}},
        {"height_m": 1.2},
    ],
)
def test_what_is_no_edit_is_not_read_as_one(value):
    with pytest.raises(ValueError, match=r".+"):
        edit_from_json(value)


def test_the_letter_of_a_deleted_point_is_used_again_but_not_its_id():
    document = Document(SIZE)
    for row_px in (500.0, 450.0, 420.0):
        document = AddMark(600.0, row_px).apply(document)
    document = AddMark(600.0, 400.0).apply(DeleteMark(2).apply(document))
    assert [(mark.id, mark.name) for mark in document.marks] == [(1, "A"), (3, "C"), (4, "B")]
