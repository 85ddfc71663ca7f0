"""The drive that all tests of the page look at."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from review_drives import whole_drive

from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.session import ReviewSession


@pytest.fixture(scope="session")
def drive_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of the made drive; not to be written beside."""
    return whole_drive(tmp_path_factory)


@pytest.fixture(scope="session")
def drive(drive_log: Path) -> Drive:
    """The same, open."""
    return Drive.open("made", drive_log)


@pytest.fixture
def place(drive_log: Path, tmp_path: Path) -> Iterator[Place]:
    """Somebody at the first event of a copy."""
    session = ReviewSession({"made": Path(shutil.copy(drive_log, tmp_path))}, "anna")
    place = Place(session)
    place.enter(session.open(place, "made"), 0, None)
    yield place
    session.close()
