"""What somebody does at a desk of the calibration page, without the browser."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from session_helpers import PAPER_POINTS, tell

from fcw.errors import UserError
from fcw_viz.calibrate_app.desk import Desk
from fcw_viz.calibrate_app.document.edits import DeleteMark, MoveMark
from fcw_viz.calibrate_app.handles import PictureHandles
from fcw_viz.calibrate_app.session import CalibrationSession, Person

PICTURES = 5


@pytest.fixture
def desk(session: CalibrationSession, tmp_path: Path) -> Iterator[Desk]:
    """A desk on three points, all of them clicked in the first picture."""
    tell(session, Person("somebody"), PAPER_POINTS)
    tab, pictures = MagicMock(), MagicMock(count=PICTURES)
    tab.run = lambda work: work()
    pictures.read = lambda index: SimpleNamespace(image=np.full((2, 2, 3), index, np.uint8))
    one = Desk(tab, session, pictures, tmp_path / "drive", MagicMock(), ())  # pyright: ignore[reportArgumentType]
    one.channel = MagicMock()
    one.sit_down()
    yield one
    one.leave()


def test_a_click_on_a_point_asks_for_no_number(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    told = MagicMock()
    monkeypatch.setattr("fcw_viz.calibrate_app.desk.expect_no_typing", told)
    PictureHandles(desk).show(desk.state)
    *_, click = desk.view.add_handle.call_args.args  # pyright: ignore[reportAttributeAccessIssue]
    click()
    assert desk.selected == len(PAPER_POINTS)
    told.assert_called_once_with(desk.client)


def test_a_drag_ends_where_its_point_is_deleted_by_another(desk: Desk):
    """Else the point would lie where it was dragged to, and could not be moved, once undo brings it back."""
    handles = PictureHandles(desk)
    handles.show(desk.state)
    *_, drag, _ = desk.view.add_handle.call_args.args  # pyright: ignore[reportAttributeAccessIssue]
    last = desk.state.document.marks[-1]
    for phase in ("start", "update"):
        drag(phase, last.column_px, last.row_px + 30)
    bert = desk.session.join(lambda _: None)
    desk.session.apply(bert, DeleteMark(last.id))
    handles.show(desk.session.state)
    desk.session.undo(bert)
    assert desk.session.state.document.mark(last.id) == last
    handles.show(desk.session.state)
    moved = MoveMark(last.id, last.column_px, last.row_px - 5)
    desk.session.apply(bert, moved)
    handles.show(desk.session.state)
    handle = desk.view.add_handle.return_value  # pyright: ignore[reportAttributeAccessIssue]
    handle.move.assert_called_with(moved.column_px, moved.row_px)


def test_a_picture_that_cannot_be_read_is_not_the_one_that_is_clicked_in(desk: Desk):
    desk.go_to(2)
    assert desk.frame_index == 2

    def gone(index: int) -> None:
        raise UserError("no picture of it can be read any more")

    desk.pictures.read = gone  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(UserError, match="no picture"):
        desk.go_to(4)
    assert desk.frame_index == 2  # as is seen
