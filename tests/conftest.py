"""Shared by all tests: which of them are slow, where the real drives are, and how hypothesis searches."""

import atexit
import gc
import os
import shutil
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings
from running.last_words import last_words, listen, told_before

if TYPE_CHECKING:
    from playwright.sync_api import Browser

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


@pytest.hookimpl(trylast=True)  # after pytest itself, which writes to a worker's standard error
def pytest_configure(config: pytest.Config) -> None:
    """A worker that crashes, or is ended because its test hangs, says where in the summary."""
    listen(getattr(config, "workerinput", {}).get("workerid"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    with told_before(float(item.config.getini("timeout"))):
        return (yield)


def pytest_terminal_summary(terminalreporter: "pytest.TerminalReporter") -> None:
    for worker, text in last_words().items():
        terminalreporter.section(f"the last words of {worker}")
        terminalreporter.write(text)


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


# WebGL without a graphics card, the same on every machine.
CHROMIUM_FLAGS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--no-sandbox",
)


@pytest.fixture(scope="session")
def chromium() -> Iterator["Browser"]:
    """The one browser of this process's tests: Playwright has an event loop of its own in the main thread."""
    # Workers that have no test of a page do without these.
    from browser_page import PATIENCE_S
    from playwright.sync_api import sync_playwright
    from running.chromium_path import chromium_path

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium_path(), args=CHROMIUM_FLAGS, timeout=PATIENCE_S * 1000
        )
        yield browser
        browser.close()
