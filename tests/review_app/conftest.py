"""The drive that all tests of the page look at."""

from pathlib import Path

import pytest
from review_drives import write_drive

from fcw_viz.review_app.drive import Drive


@pytest.fixture(scope="session")
def drive_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of the made drive; not to be written beside."""
    return write_drive(tmp_path_factory.mktemp("made") / "drive.mcap")


@pytest.fixture(scope="session")
def drive(drive_log: Path) -> Drive:
    """The same, open."""
    return Drive.open("made", drive_log)
