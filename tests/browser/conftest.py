"""Pages in a real Chromium, with a fresh profile for each test."""

import logging
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Protocol

import pytest
from browser_page import PATIENCE_S, BrowserPage
from calibrate_helpers import FIRST_PORT
from playwright.sync_api import Browser, Error, ViewportSize

from fcw.camera.file import default_path
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.review_app.server import ReviewPage

WINDOW_PX = (1400, 900)
LONGEST_PAUSE_S = 0.2
"""Between two looks whether what a test waits for has come."""
# Smooth edges are a third of what a picture costs in software.
_NO_SMOOTH_EDGES = """
  const open = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, wishes) {
    return open.call(this, kind, kind.startsWith("webgl") ? { ...wishes, antialias: false } : wishes);
  };
"""
# three.js knows where everything is, and which picture is shown, also where nothing is drawn. To draw it in
# software is a fifth of what these tests take, and few of them look at it.
_NOTHING_DRAWN = """
  for (const name of ["clear", "drawArrays", "drawArraysInstanced", "drawElements", "drawElementsInstanced",
                      "generateMipmap", "texImage2D", "texStorage2D", "texSubImage2D"])
    WebGL2RenderingContext.prototype[name] = () => {};
"""
# What is only looked at now and then is drawn only then: at full resolution a frame takes a tenth of a
# second.
_DRAWN_WHEN_SEEN = """
  for (const name of ["clear", "drawArrays", "drawArraysInstanced", "drawElements",
                      "drawElementsInstanced"]) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...what) {
      if (window.isSeen) draw.apply(this, what);
    };
  }
"""
# viser draws frame after frame for a quarter of a second whenever something may have changed. A screen that
# shows ten a second ends at the same picture, for a third of the work.
_FEW_FRAMES = """
  const next = window.requestAnimationFrame.bind(window);
  let waiting = new Map(), last = 0, shownAt = -Infinity, isAsked = false;
  const show = (now) => {
    const mine = waiting;
    [waiting, shownAt, isAsked] = [new Map(), performance.now(), false];
    for (const callback of mine.values())
      try { callback(now); } catch (error) { reportError(error); }
  };
  window.requestAnimationFrame = (callback) => {
    waiting.set(++last, callback);
    if (!isAsked) setTimeout(() => next(show), Math.max(0, shownAt + 100 - performance.now()));
    isAsked = true;
    return last;
  };
  window.cancelAnimationFrame = (handle) => waiting.delete(handle);
"""


class OpenPage(Protocol):
    """What the fixture `open_page` is."""

    def __call__(
        self,
        url: str,
        window_px: tuple[int, int] = WINDOW_PX,
        picture: bool = True,
        drawn_at: float = 0.0,
        always_drawn: bool = True,
        phone: bool = False,
        few_frames: bool = True,
    ) -> BrowserPage: ...


@pytest.fixture
def open_page(chromium: Browser, request: pytest.FixtureRequest, tmp_path: Path) -> Generator[OpenPage]:
    """Opens a URL of the program and waits for its picture, if it begins with one; several calls are several
    people. The scene is drawn, with rough edges, at the part of the screen's resolution in which a test looks
    at it, or not at all: software draws it. Where it is not always drawn, it is for `BrowserPage.seen` alone.
    Unless a test is about the frames themselves, they are few. A phone is touched, and lays pages out so.

    At the end a page's exception fails the test, and what a failed test saw is saved as a picture.
    """
    pages: list[BrowserPage] = []

    def open_one(
        url: str,
        window_px: tuple[int, int] = WINDOW_PX,
        picture: bool = True,
        drawn_at: float = 0.0,
        always_drawn: bool = True,
        phone: bool = False,
        few_frames: bool = True,
    ) -> BrowserPage:
        width, height = window_px
        context = chromium.new_context(
            viewport=ViewportSize(width=width, height=height), has_touch=phone, is_mobile=phone
        )
        context.set_default_timeout(PATIENCE_S * 1000)
        context.add_init_script(_NO_SMOOTH_EDGES if drawn_at else _NOTHING_DRAWN)
        if not always_drawn:
            context.add_init_script(_DRAWN_WHEN_SEEN)
        if few_frames:
            context.add_init_script(_FEW_FRAMES)
        opened = BrowserPage(context.new_page())
        pages.append(opened)
        opened.listen()
        address, _, query = url.partition("?")
        # As it is printed, without a slash at its end: that is how people open it.
        opened.page.goto(f"{address}?fixedDpr={drawn_at or 0.25}&{query}")
        if picture:
            opened.wait_until_ready()
        return opened

    yield open_one
    report = request.node.stash.get(_CALL, None)
    for index, opened in enumerate(pages):
        if report is None or report.failed:
            _save_screenshot(opened, tmp_path / f"failed-{index}.png")
        opened.page.context.close()
    exceptions = [error for opened in pages for error in opened.exceptions]
    assert not exceptions, f"the page raised: {exceptions}"


_CALL = pytest.StashKey[pytest.TestReport]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.when == "call":
        item.stash[_CALL] = report
    return report


def _save_screenshot(opened: BrowserPage, path: Path) -> None:
    try:
        opened.page.screenshot(path=path)
    except Error as error:  # a page that crashed must not hide why the test failed
        sys.stderr.write(f"no screenshot: {error}\n")
    else:
        sys.stderr.write(f"what the page looked like: {path}\n")


@pytest.fixture
def wait_for() -> Callable[[Callable[[], bool]], None]:
    """Waits until a condition holds in the test's own process, while the browser goes on."""

    def wait(condition: Callable[[], bool]) -> None:
        # To ask the page takes a hundredth of a second of processors: what takes longer is asked less often.
        start_s = time.monotonic()
        while not condition():
            waited_s = time.monotonic() - start_s
            assert waited_s < PATIENCE_S, f"waited {PATIENCE_S} s in vain"
            time.sleep(min(0.02 + 0.1 * waited_s, LONGEST_PAUSE_S))

    return wait


@pytest.fixture
def serve(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> Generator[Callable[[Path], CalibrationPage]]:
    """Serves the calibration page of a source; at the end the server's log must hold no exception."""
    pages: list[CalibrationPage] = []

    def start(source: Path) -> CalibrationPage:
        pages.append(CalibrationPage(source, default_path(source), FIRST_PORT))
        return pages[-1]

    yield start
    for page in pages:
        page.stop()
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []
    assert "Traceback" not in capfd.readouterr().err


@pytest.fixture
def review(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> Generator[Callable[[dict[str, Path]], ReviewPage]]:
    """Serves the review page of drives; at the end the server's log must hold no exception."""
    pages: list[ReviewPage] = []

    def start(drives: dict[str, Path]) -> ReviewPage:
        pages.append(ReviewPage(drives, "drives", "anna", FIRST_PORT))
        return pages[-1]

    yield start
    for page in pages:
        page.stop()
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []
    assert "Traceback" not in capfd.readouterr().err
