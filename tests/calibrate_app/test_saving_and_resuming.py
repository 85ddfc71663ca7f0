"""A session's file and journal: what is saved, and how a calibration is gone on with."""

from dataclasses import replace

import pytest
from session_helpers import PAPER_POINTS, SIZE, calibrated, nobody, open_session, said, save_path, seen, tell

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.file import read_calibration, write_calibration
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    EnableMark,
    MoveMark,
    SetDistance,
    SetHeight,
    SetHorizon,
    SetReference,
)
from fcw_viz.calibrate_app.document.journal import journal_path
from fcw_viz.calibrate_app.document.state import Status

# Saving


@pytest.mark.parametrize(
    ("points", "priors"),
    [
        (PAPER_POINTS, {}),
        (tuple(seen(6, 9, 15, 30, 45)), {}),
        (tuple(seen(6, 30)), {"horizon_row": Gaussian(309.0, 2.0)}),
    ],
)
def test_the_file_is_what_the_headless_calibration_of_the_same_pixels_gives(session, points, priors):
    anna = session.join(nobody)
    tell(session, anna, points, height_m=1.225)
    session.apply(anna, SetReference(True, 2.29))
    if priors:
        session.apply(anna, SetHorizon(Belief(priors["horizon_row"])))
    saved = read_calibration(session.save())
    headless = calibrate(
        [GroundPoint(d, row, 600.0) for d, row in points], SIZE, 1.225, reference_offset_m=2.29, **priors
    )
    assert saved.points == headless.points
    assert saved.priors == headless.priors
    for field in ("pitch_rad", "focal_y_px", "principal_row_px", "principal_column_px", "height_m"):
        assert getattr(saved.camera, field) == pytest.approx(getattr(headless.camera, field), rel=1e-9)
    assert saved.residuals_px == pytest.approx(headless.residuals_px, abs=1e-9)
    for ours, theirs in zip(saved.covariance, headless.covariance, strict=True):
        assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-12)


def test_saved_tells_whether_the_file_is_this_document(session):
    anna = calibrated(session)
    assert not session.state.saved
    session.save()
    assert session.state.saved
    session.apply(anna, MoveMark(3, 600, 345))
    assert not session.state.saved
    session.undo(anna)
    assert session.state.saved
    session.apply(anna, AddMark(100, 100))
    assert session.state.saved, "a mark without a distance changes no calibration"


@pytest.mark.parametrize("act", ["delete", "change"])
def test_a_saved_file_that_another_hand_changes_is_not_called_saved(session, tmp_path, act):
    calibrated(session)
    session.save()
    session.look_at_file()
    assert session.state.saved
    told = []
    session.join(told.append)
    if act == "delete":
        save_path(tmp_path).unlink()
    else:
        with save_path(tmp_path).open("a") as file:
            file.write("# of another hand\n")
    session.look_at_file()
    assert not told[-1].saved
    assert "drive.calibration.yaml was changed or deleted elsewhere" in told[-1].notice
    session.save()
    session.look_at_file()
    assert session.state.saved
    assert "another hand" not in save_path(tmp_path).read_text()


@pytest.mark.parametrize(
    ("points", "status"),
    [
        (PAPER_POINTS, Status.DOUBTFUL),
        (tuple((d / 0.3048, row) for d, row in seen(6, 9, 16)), Status.IMPLAUSIBLE),
    ],
)
def test_a_doubtful_and_an_implausible_calibration_can_be_saved(session, points, status):
    anna = session.join(nobody)
    tell(session, anna, points, height_m=1.225)
    assert session.state.solution.status is status
    assert session.save().exists()


@pytest.mark.parametrize(
    ("points", "height_m", "message"),
    [
        ((), 1.2, "not saved: something is still missing. Choose what you have"),
        (PAPER_POINTS, None, "not saved: something is still missing. Type the camera's height"),
        (((4, 461), (5, 440), (7, 383)), 1.2, "not saved: With distance, the rows of A, B and C"),
    ],
)
def test_nothing_is_saved_from_an_unfinished_or_degenerate_state(
    session, tmp_path, points, height_m, message
):
    anna = session.join(nobody)
    tell(session, anna, points, height_m)
    with pytest.raises(UserError, match=message):
        session.save()
    assert not save_path(tmp_path).exists()


def test_a_degenerate_state_leaves_the_old_file_as_it_was(session, tmp_path):
    anna = calibrated(session)
    text = session.save().read_text()
    session.apply(anna, SetDistance(2, 40.0))
    with pytest.raises(UserError, match="not saved"):
        session.save()
    assert save_path(tmp_path).read_text() == text


# Resuming and loading


def test_a_resumed_session_goes_on_where_it_was(session, tmp_path):
    anna = calibrated(session)
    session.save()
    session.apply(anna, EnableMark(2, False))
    session.undo(anna)
    before = session.state
    session.close()
    resumed = open_session(tmp_path)
    after = resumed.state
    assert (after.document, after.can_undo, after.can_redo) == (before.document, True, True)
    assert after.saved
    assert "6 steps from drive.calibration.work.jsonl" in after.notice
    bert = resumed.join(nobody)
    resumed.redo(bert)
    assert not resumed.state.document.mark(2).enabled
    assert resumed.state.notice == "", "the notice has been read by then"
    resumed.close()


def test_a_torn_journal_is_told(session, tmp_path):
    anna = session.join(nobody)
    tell(session, anna, PAPER_POINTS)
    session.close()
    path = journal_path(save_path(tmp_path))
    path.write_bytes(path.read_bytes()[:-5])
    resumed = open_session(tmp_path)
    assert resumed.state.document == said(*PAPER_POINTS[:2])
    assert "The last step was cut off" in resumed.state.notice
    resumed.close()


def test_an_old_calibration_shows_its_points_again(tmp_path):
    old = calibrate(
        [GroundPoint(d, row, 500.0) for d, row in seen(6, 9, 15, 30, 45)],
        SIZE,
        1.3,
        reference_offset_m=0.5,
        row_sigma_px=0.7,
        field_of_view=Gaussian(1.2, 0.05),
        principal_row=Gaussian(359.5, 20.0),
        horizon_row=Gaussian(310.0, 2.0),
    )
    write_calibration(old, save_path(tmp_path))
    session = open_session(tmp_path)
    state = session.state
    assert state.saved
    assert state.current
    assert "loaded" in state.notice
    assert not state.can_undo
    document = state.document
    assert [(m.distance_m, m.row_px, m.column_px) for m in document.marks] == [
        (point.distance_m, point.row_px, point.column_px) for point in old.points
    ]
    assert (document.height_m, document.from_bumper, document.bumper_offset_m) == (1.3, True, 0.5)
    assert document.field_of_view == Belief(Gaussian(1.2, 0.05))
    anna = session.join(nobody)
    session.apply(anna, SetHeight(1.4))
    session.close()
    resumed = open_session(tmp_path)
    assert resumed.state.document == replace(document, height_m=1.4)
    assert not resumed.state.saved
    resumed.close()


def test_a_calibration_of_the_same_camera_in_another_size_is_scaled(tmp_path):
    write_calibration(
        calibrate([GroundPoint(d, row) for d, row in seen(6, 15, 40)], SIZE, 1.3), save_path(tmp_path)
    )
    session = open_session(tmp_path, ImageSize(640, 360))
    assert [mark.row_px for mark in session.state.document.marks] == pytest.approx(
        [(row + 0.5) / 2 - 0.5 for _, row in seen(6, 15, 40)]
    )
    session.close()


@pytest.mark.parametrize("text", ["a: [", "fcw_calibration_version: 99\n"])
def test_a_calibration_that_cannot_be_read_is_told_and_not_in_the_way(tmp_path, text):
    save_path(tmp_path).write_text(text)
    session = open_session(tmp_path)
    assert session.state.document == said()
    assert "is not used" in session.state.notice
    assert "drive.calibration.yaml" in session.state.notice
    session.close()
    assert save_path(tmp_path).read_text() == text


def test_a_file_written_by_another_hand_becomes_a_step_that_can_be_undone(session, tmp_path):
    calibrated(session)
    session.save()
    own = session.state.document
    session.close()
    write_calibration(
        calibrate([GroundPoint(d, row) for d, row in seen(5, 10, 20)], SIZE, 1.3), save_path(tmp_path)
    )
    resumed = open_session(tmp_path)
    assert [mark.distance_m for mark in resumed.state.document.marks] == [5, 10, 20]
    assert "changed elsewhere" in resumed.state.notice
    assert resumed.state.saved
    bert = resumed.join(nobody)
    resumed.undo(bert)
    assert resumed.state.document == own
    resumed.close()
    again = open_session(tmp_path)
    assert again.state.document == own, "it is taken in once"
    again.close()


def test_the_own_file_of_a_changed_document_is_not_taken_for_another_hands(session, tmp_path):
    anna = calibrated(session)
    session.save()
    session.apply(anna, SetHeight(1.4))
    session.close()
    resumed = open_session(tmp_path)
    assert resumed.state.document.height_m == 1.4
    resumed.close()
