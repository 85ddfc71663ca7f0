"""Several people on one calibration: what each sees, what is kept, what is saved."""

import logging
import tempfile
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from session_helpers import CAMERA, PAPER_POINTS, SIZE, edits, open_session, said, save_path, seen

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.file import read_calibration, write_calibration
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    DeleteMark,
    EnableMark,
    MoveMark,
    SetDistance,
    SetHeight,
    SetHorizon,
    SetReference,
)
from fcw_viz.calibrate_app.document.journal import journal_path, read_journal
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import SessionState, Status


@pytest.fixture
def session(tmp_path):
    session = open_session(tmp_path)
    yield session
    session.close()


def nobody(state: SessionState) -> None:
    """A listener that does nothing."""


def tell(session, person, points, height_m=None) -> None:
    for distance_m, row_px in points:
        session.apply(person, AddMark(600.0, row_px, 0, distance_m))
    if height_m is not None:
        session.apply(person, SetHeight(height_m))


def calibrated(session):
    """Somebody who has said all that a good calibration needs."""
    anna = session.join(nobody)
    tell(session, anna, seen(6, 15, 40), height_m=1.3)
    return anna


def kept(folder: Path):
    """The document that the journal says."""
    content = read_journal(journal_path(save_path(folder)))
    assert content is not None
    return content.history.document


# Who sees what


def test_who_comes_is_shown_the_present_and_all_see_who_is_there(session):
    first, second = [], []
    anna = session.join(first.append)
    session.apply(anna, AddMark(600, 461, 0, 4))
    bert = session.join(second.append)
    assert second[0].document == said((4, 461))
    assert first[-1].people == second[-1].people == ("tab 1", "tab 2")
    session.leave(bert)
    assert first[-1].people == ("tab 1",)
    session.apply(anna, SetHeight(1.2))
    assert second[-1].document.height_m is None, "who left hears no more"


def test_anybody_undoes_and_redoes_the_steps_of_everybody(session, tmp_path):
    anna, bert = session.join(nobody), session.join(nobody)
    session.apply(anna, AddMark(600, 461, 0, 4), SetHeight(1.2))
    session.undo(bert)
    assert session.state.document == said()
    assert session.state.can_redo
    assert not session.state.can_undo
    session.redo(anna)
    assert session.state.document == kept(tmp_path) == said((4, 461), height_m=1.2)
    with pytest.raises(UserError, match="nothing to redo"):
        session.redo(bert)


def test_a_step_of_which_one_edit_fails_changes_nothing(session, tmp_path):
    anna = session.join(nobody)
    session.apply(anna, AddMark(600, 461, 0, 4))
    before = session.state
    with pytest.raises(UserError, match="point B is gone"):
        session.apply(anna, SetHeight(1.2), DeleteMark(2))
    assert session.state == before
    assert kept(tmp_path) == before.document


def test_two_drags_at_once_are_both_shown_and_not_kept(session, tmp_path):
    anna, bert = session.join(nobody), session.join(nobody)
    tell(session, anna, PAPER_POINTS)
    session.preview(anna, MoveMark(1, 600, 500))
    session.preview(bert, MoveMark(2, 600, 440))
    rows = [mark.row_px for mark in session.state.document.marks]
    assert rows == [500, 440, 383]
    assert kept(tmp_path) == said(*PAPER_POINTS)


def test_a_step_of_one_leaves_the_drag_of_the_other(session):
    anna, bert = session.join(nobody), session.join(nobody)
    tell(session, anna, PAPER_POINTS)
    session.preview(anna, MoveMark(1, 600, 500))
    session.apply(bert, MoveMark(2, 600, 440))
    assert [mark.row_px for mark in session.state.document.marks] == [500, 440, 383]
    session.apply(anna, MoveMark(1, 600, 501))
    assert [mark.row_px for mark in session.state.document.marks] == [501, 440, 383]
    session.undo(bert)
    assert [mark.row_px for mark in session.state.document.marks] == [461, 440, 383]


@pytest.mark.parametrize("ending", ["leave", "none", "undo"])
def test_a_drag_that_comes_to_nothing_leaves_nothing(session, ending):
    anna, bert = session.join(nobody), session.join(nobody)
    tell(session, bert, PAPER_POINTS)
    session.apply(bert, SetHeight(1.2))
    session.preview(anna, MoveMark(1, 600, 500))
    if ending == "leave":
        session.leave(anna)
    elif ending == "none":
        session.preview(anna, None)
    else:
        session.undo(anna)
    assert session.state.document.marks == said(*PAPER_POINTS).marks


def test_a_refused_step_ends_the_drag_too(session):
    states = []
    anna = session.join(states.append)
    tell(session, anna, PAPER_POINTS)
    session.preview(anna, MoveMark(1, 600, 500))
    with pytest.raises(UserError):
        session.apply(anna, DeleteMark(9))
    assert states[-1].document == said(*PAPER_POINTS)


def test_dragging_what_another_deleted_shows_the_rest(session):
    anna, bert = session.join(nobody), session.join(nobody)
    tell(session, anna, PAPER_POINTS)
    session.preview(anna, MoveMark(2, 600, 500))
    session.apply(bert, DeleteMark(2))
    assert [mark.id for mark in session.state.document.marks] == [1, 3]


def test_a_drag_of_who_has_left_is_not_shown(session):
    anna, bert = session.join(nobody), session.join(nobody)
    tell(session, bert, PAPER_POINTS)
    session.leave(anna)
    session.preview(anna, MoveMark(1, 600, 500))
    assert session.state.document == said(*PAPER_POINTS)


def test_a_listener_that_fails_is_logged_and_hurts_nobody(session, caplog):
    def failing(state: SessionState) -> None:
        raise RuntimeError("the tab is gone")

    heard = []
    session.join(failing)
    anna = session.join(heard.append)
    with caplog.at_level(logging.ERROR):
        session.apply(anna, SetHeight(1.2))
    assert heard[-1].document.height_m == 1.2
    assert "the tab is gone" in caplog.text


def test_a_listener_may_make_a_step_itself_and_all_hear_both_in_order(session):
    heard = []

    def adds_height(state: SessionState) -> None:
        if state.document.marks and state.document.height_m is None:
            session.apply(anna, SetHeight(1.2))

    anna = session.join(adds_height)
    bert = session.join(heard.append)
    session.apply(bert, AddMark(600, 461, 0, 4))
    assert heard[-1].document == said((4, 461), height_m=1.2)
    assert [state.revision for state in heard] == sorted({state.revision for state in heard})


# The result that stays


def test_the_last_good_result_stays_and_is_not_current(session, tmp_path):
    anna = calibrated(session)
    good = session.state
    assert good.current
    assert good.shown is good.solution.result
    session.apply(anna, MoveMark(2, 600, 700))
    bad = session.state
    assert bad.solution.status is Status.DEGENERATE
    assert not bad.current
    assert bad.shown == good.shown
    session.close()
    resumed = open_session(tmp_path)
    assert resumed.state.shown == good.shown
    assert not resumed.state.current
    resumed.close()


def test_a_drag_into_nonsense_shows_what_was_kept_last(session):
    anna = calibrated(session)
    good = session.state.shown
    session.preview(anna, MoveMark(2, 600, 400))
    assert session.state.current
    session.preview(anna, MoveMark(2, 600, 700))
    assert not session.state.current
    assert session.state.shown == good
    session.apply(anna, MoveMark(2, 600, 700))
    assert session.state.shown == good


def test_starting_anew_empties_everything_and_can_be_undone(session):
    anna = calibrated(session)
    before = session.state.document
    session.start_anew(anna)
    assert session.state.document == said()
    assert session.state.shown is None
    session.undo(anna)
    assert session.state.document == before


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


def test_an_implausible_calibration_can_be_saved(session):
    anna = session.join(nobody)
    tell(session, anna, PAPER_POINTS, height_m=1.225)
    assert session.state.solution.status is Status.IMPLAUSIBLE
    assert session.save().exists()


@pytest.mark.parametrize(
    ("points", "height_m", "message"),
    [
        ((), 1.2, "not saved: something is still missing. Click a mark"),
        (PAPER_POINTS, None, "not saved: something is still missing. Type the camera's height"),
        (((4, 461), (5, 440), (7, 383)), 1.2, "not saved: Going away, the rows of A, B and C"),
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
    assert "torn" in resumed.state.notice
    resumed.close()


def test_an_old_calibration_shows_its_points_again(tmp_path):
    old = calibrate(
        [GroundPoint(d, row, 500.0 + d) for d, row in seen(6, 9, 15, 30, 45)],
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


# State equals journal, whatever happens


ACTIONS = st.one_of(
    st.tuples(st.just("apply"), st.lists(edits, min_size=1, max_size=3)),
    st.tuples(st.just("preview"), edits),
    st.tuples(st.sampled_from(["undo", "redo"]), st.none()),
    st.tuples(st.sampled_from(["undo", "redo", "anew", "save", "reopen", "leave"]), st.none()),
)


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 2), ACTIONS), max_size=30))
def test_the_state_is_a_replay_of_the_journal_read_back(happenings):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        session = open_session(folder)
        people = [session.join(nobody) for _ in range(3)]
        tell(session, people[0], seen(6, 15, 40), height_m=1.3)
        for who, (action, argument) in happenings:
            person = people[who]
            try:
                if action == "apply":
                    session.apply(person, *argument)
                elif action == "preview":
                    session.preview(person, argument)
                    continue
                elif action == "undo":
                    session.undo(person)
                elif action == "redo":
                    session.redo(person)
                elif action == "anew":
                    session.start_anew(person)
                elif action == "save":
                    session.save()
                elif action == "leave":
                    session.leave(person)
                    people[who] = session.join(nobody)
                else:
                    session.close()
                    session = open_session(folder)
                    people = [session.join(nobody) for _ in range(3)]
            except UserError:
                pass
        for person in people:
            session.preview(person, None)
        state = session.state
        content = read_journal(journal_path(save_path(folder)))
        session.close()
        assert content is not None
        assert state.document == content.history.document
        assert (state.can_undo, state.can_redo) == (content.history.can_undo, content.history.can_redo)
        assert state.solution == solve(state.document)


def test_threads_that_work_at_once_leave_state_and_journal_equal(session, tmp_path, caplog):
    heard: dict[str, list[SessionState]] = {"anna": [], "bert": [], "cora": []}
    people = {name: session.join(states.append) for name, states in heard.items()}
    faults: list[BaseException] = []
    start = threading.Barrier(len(people))

    def work(seed: int, person) -> None:
        start.wait()
        try:
            for turn in range(60):
                mark_id = 1 + (turn + seed) % 3
                row_px = CAMERA.row_at((6.0, 15.0, 40.0)[mark_id - 1]) + (turn % 7) - 3
                try:
                    session.preview(person, MoveMark(mark_id, 600, row_px))
                    if turn % 3 == seed:
                        session.apply(person, MoveMark(mark_id, 600, row_px))
                    elif turn % 5 == 0:
                        session.undo(person)
                    elif turn % 7 == 0:
                        session.redo(person)
                except UserError as error:
                    # Undone far enough, there is nothing to undo and no mark to move.
                    assert "nothing to" in str(error) or "is gone" in str(error)  # noqa: PT017
        except BaseException as fault:
            faults.append(fault)

    tell(session, people["anna"], seen(6, 15, 40), height_m=1.3)
    threads = [
        threading.Thread(target=work, args=(seed, person)) for seed, person in enumerate(people.values())
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not faults
    assert not caplog.records
    for person in people.values():
        session.preview(person, None)
    state = session.state
    assert state.document == kept(tmp_path)
    for states in heard.values():
        revisions = [heard_state.revision for heard_state in states]
        assert revisions == sorted(set(revisions)), "in order, none twice"
        assert states[-1] == state, "and everybody saw the end"


def test_what_a_listener_hears_while_it_joins_is_not_lost(session):
    anna = session.join(nobody)
    heard: list[SessionState] = []

    def slow(state: SessionState) -> None:
        heard.append(state)
        if len(heard) == 1:
            thread = threading.Thread(target=session.apply, args=(anna, SetHeight(1.2)))
            thread.start()
            thread.join()

    session.join(slow)
    assert [state.document.height_m for state in heard] == [None, 1.2]
