"""Several people on one calibration: what each sees and what is kept."""

import logging
import tempfile
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples
from session_helpers import (
    CAMERA,
    PAPER_POINTS,
    calibrated,
    edits,
    kept,
    nobody,
    open_session,
    said,
    save_path,
    seen,
    tell,
)

from fcw.camera.file import read_calibration
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Ruler
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.besides.knowledge import SetVehicles
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import (
    AddMark,
    DeleteMark,
    MoveMark,
    SetHeight,
)
from fcw_viz.calibrate_app.document.journal import journal_path, read_journal
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import SessionState, Solution, Status

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
    with pytest.raises(UserError, match="that point is gone"):
        session.apply(anna, SetHeight(1.2), DeleteMark(2))
    assert session.state == before
    assert kept(tmp_path) == before.document


def test_a_step_that_the_program_cannot_solve_is_not_kept(tmp_path, monkeypatch):
    """Kept, it would fail each time that the work is opened again."""

    def faulty(document: Document, effects: bool = True) -> Solution:
        if len(document.marks) == 3:
            raise RuntimeError("a fault of ours")
        return solve(document, effects)

    monkeypatch.setattr("fcw_viz.calibrate_app.session.solve", faulty)
    session = open_session(tmp_path)
    anna = session.join(nobody)
    tell(session, anna, seen(6, 15))
    with pytest.raises(RuntimeError, match="a fault of ours"):
        tell(session, anna, seen(40))
    session.close()
    assert len(kept(tmp_path).marks) == 2
    assert len(open_session(tmp_path).state.document.marks) == 2


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


def test_a_saved_calibration_carries_what_vehicles_say_against_it(session, tmp_path):
    anna = calibrated(session)
    session.save()
    assert "Warning" not in save_path(tmp_path).read_text()
    # Five vehicles where 20 m are, which would be half as wide again as any.
    row_px = CAMERA.row_at(20.0)
    width_px = 1.5 * VEHICLE_WIDTH_M.value * CAMERA.focal_y_px / 20.0
    rulers = tuple(
        Ruler(c, row_px, width_px, VEHICLE_WIDTH_M, 1.0) for c in (500.0, 560.0, 640.0, 700.0, 760.0)
    )
    session.apply(anna, SetVehicles(rulers))
    solution = session.state.solution
    assert solution.status is Status.IMPLAUSIBLE
    assert "a calibration saved now includes it" in solution.hint
    session.save()
    lines = [line for line in save_path(tmp_path).read_text().splitlines() if line.startswith("# Warning: ")]
    assert lines == [f"# Warning: {trouble.text}" for trouble in solution.troubles]
    assert any("Half of the 5 vehicles taken as rulers would be" in line for line in lines)
    assert read_calibration(save_path(tmp_path)) == solution.result.calibration


def test_starting_anew_empties_everything_and_can_be_undone(session):
    anna = calibrated(session)
    before = session.state.document
    session.start_anew(anna)
    assert session.state.document == said()
    assert session.state.shown is None
    session.undo(anna)
    assert session.state.document == before


# State equals journal, whatever happens


ACTIONS = st.one_of(
    st.tuples(st.just("apply"), st.lists(edits, min_size=1, max_size=3)),
    st.tuples(st.just("preview"), edits),
    st.tuples(st.sampled_from(["undo", "redo"]), st.none()),
    st.tuples(st.sampled_from(["undo", "redo", "anew", "save", "reopen", "leave"]), st.none()),
)


@pytest.mark.slow
@examples(60)
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


@pytest.mark.slow
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


def test_whose_step_an_undo_took_back_is_told_to_everybody(session):
    anna, ben = session.join(nobody), session.join(nobody)
    session.apply(ben, AddMark(600, 461, 0, 4))
    session.undo(anna)
    assert session.state.notice == f"{anna.name} undid a step of {ben.name}; redo restores it."
    session.redo(anna)
    assert session.state.notice == ""
    session.apply(anna, AddMark(600, 400, 0, 9))
    session.undo(anna)
    assert session.state.notice == ""
