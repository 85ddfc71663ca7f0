"""Two runs of a drive beside each other on the page."""

import shutil
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from review_drives import CAUTION_S, FRAMES, NEAR_MISS_S, QUIET_S, RATE_HZ, header, result

from fcw.errors import UserError
from fcw.logs.comparison import DifferenceKind
from fcw.logs.mcap.writer import McapSink
from fcw.warning.types import WarningLevel, WarningState
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.plots.plot import make_plots
from fcw_viz.review_app.plots.signals import DEFAULT
from fcw_viz.review_app.plots.values import Run
from fcw_viz.review_app.runs.comparing import Comparing
from fcw_viz.review_app.runs.panel import difference_words, runs_html
from fcw_viz.review_app.session import ReviewSession


def other_log(path: Path, first: int = 0, last: int = FRAMES) -> Path:
    """The made drive as another run of it: without warnings, and with another vehicle as the near one."""
    path.parent.mkdir(parents=True)
    sink = McapSink(path)
    sink.open(header())
    for index in range(first, last):
        one = result(index)
        if one.lead_id == 9:
            far = replace(one.tracks[1], distance_m=33.0, distance_low_m=30.0, distance_high_m=36.0)
            moved = replace(far, box=replace(far.box, x=far.box.x + 300.0))
            one = replace(one, tracks=(one.tracks[0], moved))
        sink.write(replace(one, warning=WarningState(WarningLevel.NONE)), ())
    sink.close()
    return path


class Person:
    """Somebody who compares; the tab's thread is whichever calls."""

    def __init__(self, session: ReviewSession) -> None:
        self.place = Place(session)
        self.place.enter(session.open(self.place, "made"), 0, None)
        self.found = threading.Event()
        self.runs = Comparing(self.place, self.run, self.go_to_time, self.drawn)

    def run(self, work: Callable[[], object]) -> None:
        work()

    def go_to_time(self, time_s: float) -> None:
        self.place.row = self.place.opened.row_at(time_s)

    def drawn(self) -> None:
        if self.runs.differences is not None:
            self.found.set()

    def compare(self, name: str) -> None:
        self.found.clear()
        self.runs.choose(name)
        assert self.found.wait(60)


@pytest.fixture(scope="module")
def other_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    other_log(folder / "again" / "drive.mcap")
    other_log(folder / "part" / "drive.mcap", 100, 400)
    other_log(folder / "beginning" / "drive.mcap", 0, round(QUIET_S * RATE_HZ))
    return folder


@pytest.fixture
def person(drive_log: Path, other_runs: Path, tmp_path: Path) -> Iterator[Person]:
    shutil.copytree(other_runs, tmp_path, dirs_exist_ok=True)
    drives = {name: tmp_path / name / "drive.mcap" for name in ("again", "part", "beginning")}
    session = ReviewSession({"made": Path(shutil.copy(drive_log, tmp_path)), **drives}, "anna")
    yield Person(session)
    session.close()


def test_the_differences_are_gone_through_one_after_the_other(person: Person):
    person.compare("again")
    differences = person.runs.differences
    assert differences is not None
    kinds = [(one.kind, one.start_s) for one in differences]
    assert kinds == [
        (DifferenceKind.WARNING, pytest.approx(CAUTION_S)),
        (DifferenceKind.LEAD, pytest.approx(NEAR_MISS_S)),
        (DifferenceKind.WARNING, pytest.approx(19.0)),
    ]
    person.place.row = 0
    seen = []
    for forward in (True, True, True, True, False, False, False):
        person.runs.step(forward)
        seen.append(person.runs.at)
    assert seen == [0, 1, 2, 2, 1, 0, 0]
    assert person.place.time_s == pytest.approx(differences[0].peak_s)
    words = [difference_words(one, ("made", "again"), False) for one in differences]
    assert words[0] == "warning only in made; nothing in again"
    assert words[1] == "different leads: 11.0 m in made, 33 m in again"
    html = runs_html(person.runs, "made", ["again"], False)
    assert html.count("data-fcw-seen") == 1
    assert "2 in the warning, 1 in the lead" in html


def test_a_run_that_begins_later_stands_at_its_own_time(person: Person):
    person.compare("part")
    assert person.runs.later_s == pytest.approx(100 / RATE_HZ)
    assert person.runs.row_at(99) is None
    assert person.runs.row_at(150) == 50
    drive, other = person.place.opened, person.runs.other
    assert other is not None
    runs = [
        replace(Run.of(drive, 0.0, 24.0), name="made"),
        Run.of(other, 0.0, 24.0, name="part", first_ns=drive.first_ns),
    ]
    (distance, *_) = make_plots(runs, DEFAULT, False)
    assert [curve.name for curve in distance.curves] == ["made", "part"]
    assert distance.curves[1].run.times_s[[0, -1]] == pytest.approx([100 / RATE_HZ, 399 / RATE_HZ])


def test_another_run_or_none_takes_its_place(person: Person):
    person.compare("again")
    person.compare("beginning")
    assert person.runs.differences == ()
    person.compare("")
    assert person.runs.other is None
    with pytest.raises(UserError, match="choose a run to compare with"):
        person.runs.step(True)


def test_runs_that_share_no_moment_are_refused(person: Person, tmp_path: Path):
    person.place.leave()
    session = person.place.session
    person.place.enter(session.open(person.place, "beginning"), None, 0.0)
    told = r"does not overlap this drive in time: choose another run of made\.mp4"
    with pytest.raises(UserError, match=told):
        person.runs.choose("part")
    assert person.runs.other is None


def test_runs_of_the_same_source_are_offered(person: Person):
    person.place.session.start()
    while person.place.session.unread:
        person.found.wait(0.05)
    assert person.runs.candidates(person.place.session.cards) == ["again", "beginning", "part"]


def test_who_has_one_run_is_told_how_to_make_another_that_leaves_it_as_it_is(person: Person):
    html = runs_html(person.runs, "made", [], False)
    assert "into a folder of its own" in html
    assert "the same folder" not in html
