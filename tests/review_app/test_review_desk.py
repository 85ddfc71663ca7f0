"""What a desk shows when the logs before it are written anew, or damaged."""

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from unittest.mock import MagicMock

import pytest
from review_drives import CAUTION_S, RATE_HZ, SIZE, header, result

from fcw.errors import UserError
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import FrameResult
from fcw_viz.page.picture.plane import PicturePlane
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.desk import Desk
from fcw_viz.review_app.panels.event import EventPanel
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.plots import values
from fcw_viz.review_app.plots.signals import AHEAD, Chosen
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.tab import Tab

SCORE = Chosen("score", AHEAD)
FIRST = round((CAUTION_S - 0.4) * RATE_HZ)
FRAMES = 2 * RATE_HZ + 1


def as_it_is(one: FrameResult) -> FrameResult:
    return one


def scored(score: float) -> Callable[[FrameResult], FrameResult]:
    """Results of a detector that has that score for every vehicle."""
    return lambda one: replace(one, tracks=tuple(replace(track, score=score) for track in one.tracks))


def run_again(
    log: Path, change: Callable[[FrameResult], FrameResult] = as_it_is, frames: int = FRAMES
) -> None:
    """Write a log, without pictures, from its beginning."""
    log.unlink(missing_ok=True)
    log.parent.mkdir(parents=True, exist_ok=True)
    sink = McapSink(log)
    sink.open(header())
    for index in range(FIRST, FIRST + frames):
        sink.write(change(result(index)), ())
    sink.close()


def wait_until(condition: Callable[[], bool]) -> None:
    while not condition():
        time.sleep(0.005)


class Sitting:
    """Somebody at a desk on the run `made`, beside which there is `again`; in the test's own thread."""

    def __init__(self, folder: Path) -> None:
        self.logs = {name: folder / name / "drive.mcap" for name in ("made", "again")}
        for log in self.logs.values():
            run_again(log)
        self.session = ReviewSession(self.logs, "anna")
        self.tab = MagicMock()
        self.tab.run = lambda work: work()
        self.tab.view.away, self.tab.view.plane = False, PicturePlane(SIZE)
        self.tab.view.window_px = -0.5, -0.5, SIZE.width - 0.5, SIZE.height - 0.5
        self.tab.view.pixels_per_screen_pixel = 1.0
        self.tab.view.world = self.tab.view.plane.world
        self.desk = Desk(self.tab, self.session, lambda: None)
        self.desk.open_at("made@0")

    def run_again(self, name: str, **how: object) -> None:
        """Write a log anew, and hear of it."""
        run_again(self.logs[name], **how)  # pyright: ignore[reportArgumentType]
        self.session.open("another tab", name)
        self.desk.follow()

    def scores(self) -> set[float]:
        """Of the vehicle ahead, as the plots have them."""
        signals = self.desk.screen._signals
        assert signals is not None
        wait_until(lambda: not signals.reading)
        return set(signals.values(slice(0, 10), SCORE).value)


@pytest.fixture
def sitting(tmp_path: Path) -> Iterator[Sitting]:
    one = Sitting(tmp_path)
    yield one
    one.desk.screen.stop_reading()
    one.session.close()


def test_no_signal_of_the_run_before_is_plotted(sitting: Sitting, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(values, "BLOCK_ROWS", FRAMES // 2)  # only whole blocks were kept
    desk = sitting.desk
    desk.place.plots.take_all("score ahead")
    desk.screen.choose_plots()
    assert sitting.scores() == {9.0}
    sitting.run_again("made", change=scored(1.0))
    assert sitting.scores() == {1.0}


def test_why_a_warning_came_is_told_of_the_run_that_is_shown(sitting: Sitting):
    def slower(one: FrameResult) -> FrameResult:
        return replace(one, tracks=tuple(replace(track, closing_speed_mps=2.0) for track in one.tracks))

    place, parts = sitting.desk.place, MagicMock()
    place.selected = 0
    panel = EventPanel(parts, place, Annotating(place, MagicMock()))
    shown = [panel._event_html(place.opened)]
    sitting.run_again("made", change=slower)
    shown.append(panel._event_html(place.opened))
    assert ["54 km/h" in html for html in shown] == [True, False]
    assert ["7 km/h" in html for html in shown] == [False, True]


def test_a_run_beside_it_that_is_run_again_is_compared_anew(sitting: Sitting):
    runs = sitting.desk.runs
    runs.choose("again")
    wait_until(lambda: runs.differences is not None)
    assert runs.differences == ()
    sitting.run_again("again", change=lambda one: replace(one, tracks=(), lead_id=None))
    assert runs.other is sitting.session.current("again")
    wait_until(lambda: runs.differences is not None)
    assert runs.differences
    sitting.run_again("made", change=lambda one: replace(one, tracks=(), lead_id=None))
    wait_until(lambda: runs.differences is not None)
    assert runs.differences == ()
    # Who found them tells the page of it a moment later.
    wait_until(lambda: all(thread.name != "differences" for thread in threading.enumerate()))
    shown: list[object] = []
    sitting.desk.screen._show_panels = lambda: shown.append(runs.other)
    with pytest.raises(UserError, match="does not overlap this drive in time"):
        sitting.run_again("again", change=lambda one: replace(one, time_ns=one.time_ns + 10**12))
    assert shown == [None]  # the page does not go on with the run before


def test_a_marked_range_ends_with_a_drive_that_is_shorter_by_now(sitting: Sitting):
    desk = sitting.desk
    desk.mark_start(0.6)
    desk.mark_end(1.8)
    sitting.run_again("made", frames=RATE_HZ + 1)
    assert desk.place.marked == (0.6, 1.0)
    sitting.run_again("made", frames=RATE_HZ // 2)
    assert desk.place.marked is None


def test_a_drive_that_is_damaged_where_it_opens_is_not_left_half_open(
    sitting: Sitting, monkeypatch: pytest.MonkeyPatch
):
    def damaged(pictures: FramePictures, row: int) -> FrameResult:
        raise UserError("the log is damaged")

    monkeypatch.setattr(FramePictures, "result", damaged)
    shown: list[object] = []
    sitting.desk.screen._show_panels = lambda: shown.append(sitting.desk.place.drive)
    with pytest.raises(UserError, match="damaged"):
        sitting.desk.open_at("again#0")
    assert sitting.desk.place.drive is None
    assert shown[-1] is None  # the list is there again
    tab = object.__new__(Tab)
    tab._desk, tab._session, tab._panels = sitting.desk, sitting.session, MagicMock()
    tab.refuse = MagicMock()
    tab._arrive("again#0")
    assert "damaged" in str(tab.refuse.call_args)
