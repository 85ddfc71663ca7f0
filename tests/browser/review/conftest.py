"""The drive that the tests of the review page look at."""

import shutil
from pathlib import Path

import pytest
from review_drives import whole_drive


@pytest.fixture(scope="session")
def made_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return whole_drive(tmp_path_factory)


@pytest.fixture
def drive_log(made_log: Path, tmp_path: Path) -> Path:
    """A copy of the made drive, to write beside."""
    return Path(shutil.copy(made_log, tmp_path))
