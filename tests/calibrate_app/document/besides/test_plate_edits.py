"""Number plates on the page: three clicks each, their width by the country, saved and brought back."""

import pytest

from fcw.camera.calibration import Gaussian
from fcw.camera.file import calibration_text, parse_calibration
from fcw.camera.prior_sigmas import CAR_CAMERA_HEIGHT_M
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.besides.plates import (
    AddPlatePlace,
    MovePlatePlace,
    RemovePlate,
    SetPlateWidth,
)
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.resume import document_of
from fcw_viz.calibrate_app.document.solution import calibration_of, solve
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.ways import PLATES, WAYS

SIZE = ImageSize(1280, 720)
WAY = next(way for way in WAYS if way.key == PLATES)


def begun(clicks: int) -> Document:
    """The way chosen, and so many clicks of its example done."""
    example, document = WAY.example(SIZE), Document(SIZE, field_of_view=WAY.example(SIZE).field_of_view)
    for edit in WAY.start(document):
        document = edit.apply(document)
    for place in [place for plate in example.plates for place in plate][:clicks]:
        document = edit_from_json(edit_to_json(AddPlatePlace(*place))).apply(document)
    return document


def test_three_clicks_are_a_plate_and_two_plates_a_camera():
    hints = [solve(begun(clicks)).hint for clicks in range(5)]
    assert "one end of a number plate" in hints[0]
    assert "the other end" in hints[1]
    assert "a rear tyre" in hints[2]
    assert "another vehicle, nearer or farther" in hints[3]
    assert "the other end" in hints[4]
    solution = solve(begun(9))
    assert solution.status is Status.GOOD
    assert solution.can_save
    assert solution.result is not None
    assert solution.result.calibration.camera.height_m == pytest.approx(CAR_CAMERA_HEIGHT_M, rel=0.1)


def test_the_file_brings_plates_and_their_width_back():
    document = SetPlateWidth(Gaussian(0.372, 0.004)).apply(begun(9))
    calibration = calibration_of(document)
    assert calibration is not None
    again = document_of(parse_calibration(calibration_text(calibration), "x"))
    assert (again.plates, again.plate_width_m, again.way) == (document.plates, document.plate_width_m, PLATES)
    assert calibration_of(again) == calibration


def test_plates_are_moved_removed_and_refused():
    document = begun(5)
    assert MovePlatePlace(1, 1, 700.0, 380.0).apply(document).plates[1][1] == (700.0, 380.0)
    assert RemovePlate().apply(document).plates == document.plates[:1]
    with pytest.raises(UserError, match="clicked already; click the other one"):
        AddPlatePlace(document.plates[1][0][0] + 1.0, document.plates[1][0][1]).apply(begun(4))
    with pytest.raises(UserError, match="that plate is gone"):
        MovePlatePlace(1, 2, 700.0, 380.0).apply(document)
    with pytest.raises(UserError, match=r"width of a number plate 5.2 ± 0.01 m: expected 0.1 to 1 m"):
        SetPlateWidth(Gaussian(5.2, 0.01)).apply(document)
    upside_down = MovePlatePlace(0, 2, 640.0, 10.0).apply(begun(9))
    solution = solve(upside_down)
    assert solution.status is Status.DEGENERATE
    assert "above the plate" in solution.troubles[0].text
