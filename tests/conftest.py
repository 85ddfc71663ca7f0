"""Shared by all tests: which of them are slow, where the real drives are, and how hypothesis searches."""

import atexit
import gc
import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# What the program keeps for its user goes away with the tests, also what the programs they start keep.
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp()
atexit.register(shutil.rmtree, os.environ["XDG_STATE_HOME"], ignore_errors=True)

# As the command line does, before NumPy is loaded: beside other workers the threads of OpenBLAS wait for each
# other, and what solves many small systems takes up to five times the processor time. OpenCV's wait, too.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")

# While tests are collected, all stays: to look for garbage in it takes a tenth of that time.
gc.disable()

# No test is timed: the machine may be busy. Repeatable in CI, searching anew everywhere else.
settings.register_profile(
    "fcw",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=bool(os.environ.get("CI")),
)
# `make check` searches less; `make test` passes the same tests with all their examples.
settings.register_profile("quick", settings.get_profile("fcw"), max_examples=20)
settings.load_profile("fcw")


def pytest_collection_finish() -> None:
    """What was imported stays to the end: looking for garbage in it took a second in forty."""
    gc.collect()
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests on real drives are slow, those that drive Chromium the browser's; others say it themselves."""
    for item in items:
        fixtures = getattr(item, "fixturenames", ())
        if "data_dir" in fixtures:
            item.add_marker("slow")
        if "chromium" in fixtures:
            item.add_marker("browser")


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
