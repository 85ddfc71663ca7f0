"""Which Chromium the tests of the pages drive."""

import os
import shutil
from pathlib import Path

import pytest

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser")
"""Best first: the shell draws no window of its own, and takes two thirds of the time to load a page."""
MISSING = "needs Chromium: install chromium-headless-shell (Debian), or name one in FCW_CHROMIUM"


def chromium_path() -> str:
    """That of FCW_CHROMIUM, else the first on the path; without one the test is skipped, in CI it fails."""
    path = os.environ.get("FCW_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if path is not None and Path(path).is_file():
        return path
    if os.environ.get("CI"):
        pytest.fail(MISSING)
    pytest.skip(MISSING)
