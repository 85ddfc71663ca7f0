"""Shared by all tests: where the real drives are, and how hypothesis searches."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# No deadline: a noisy machine would make tests timed. Repeatable in CI, searching anew everywhere else.
settings.register_profile("fcw", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("fcw")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real drives that FCW_DATA names; in CI it must be there."""
    value = os.environ.get("FCW_DATA")
    if value and (Path(value) / "README.md").is_file():
        return Path(value)
    reason = "needs the real drives: set FCW_DATA to their folder"
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)
