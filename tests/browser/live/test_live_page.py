"""A drive that runs, in a real Chromium: seen, heard, and reviewed when it has ended."""

import math
import re
import threading
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import pytest
from calibrate_helpers import DEMO_DRIVE, FIRST_PORT
from review_helpers import OpenPage, Reviewer, WaitFor

from fcw.frame import Frame
from fcw.job import DriveJob
from fcw.sources.live import LiveSource
from fcw.sources.video import VideoSource
from fcw.warning.types import WarningLevel
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console
from fcw_viz.live_app import tab
from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.server import LivePage
from fcw_viz.live_app.tab import LiveTab

START_S, END_S = 26.0, 31.5
"""Of the shipped drive, whose lead brakes so that a warning is due at 29.8 s."""
WARNED_S = 28.0, 31.5
PERIOD_S, CRAWL_S = 1 / 30, 0.8
"""From picture to picture; while it warns they come seldom, for a busy browser shows late what passes by."""
BEHIND_S = 0.2
"""The camera waits for results that are farther behind: of a busy machine's the warning might be skipped."""
# Sounds as the page asks the browser for them: frequencies of the tones, in order.
LISTEN = """() => {
  window.tones = [];
  window.AudioContext = class {
    state = "suspended"; currentTime = 0; destination = {};
    resume() { this.state = "running"; }
    createOscillator() {
      const tone = { frequency: { value: 0 }, connect: (next) => next, stop() {},
                     start() { window.tones.push(tone.frequency.value); } };
      return tone;
    }
    createGain() {
      return { gain: { setValueAtTime() {}, linearRampToValueAtTime() {} }, connect: (next) => next };
    }
  };
}"""
WARNING_HZ = 1400
LOST_HZ = {310, 620}
GREY = "rgb(134, 142, 150)"
# As on a machine that is too busy to draw.
NO_WORD_OF_DRAWN_PICTURES = """() => {
  const tell = window.fcwChannel.tell;
  window.fcwChannel.tell = (words) => words.startsWith("drawn:") || tell(words);
}"""
PRESENT = ".fcw-level", ".fcw-why", ".fcw-sound", ".fcw-age"
"""What the panel says of the present moment."""


class Part(VideoSource):
    """The part of the shipped drive around the braking."""

    wait: Callable[[float], object]
    """Called before each picture, with its time in seconds."""
    recorded = True
    trouble = ""
    """As a camera's, which gives nothing meanwhile."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.over = threading.Event()

    @property
    def relays_video(self) -> bool:
        return False

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for frame in super().frames(round(START_S * 1e9)):
            if frame.time_ns > END_S * 1e9:
                return
            self.wait(frame.time_ns / 1e9)
            while self.trouble and not self.over.wait(PERIOD_S):
                pass
            if self.over.is_set():
                return
            yield frame


class Drive:
    """The drive under way and its page; it crawls while it warns, until it is told to go on."""

    def __init__(self, out: Path) -> None:
        self.stop = threading.Event()
        self.out = out
        self.go_on = False
        self.camera = part = Part(DEMO_DRIVE)
        part.wait = self._wait
        source = LiveSource(part, self.stop, paced=False)
        self.feed = LiveFeed(source)
        self.page = LivePage(self.feed, "drive", FIRST_PORT)
        job = DriveJob(DEMO_DRIVE, out, ego_speed=str(DEMO_DRIVE.with_name("drive.speed.csv")))
        self.pipeline = threading.Thread(
            target=run_on_console, args=(job, SILENT, source, (self.feed,), self.stop)
        )

    def _wait(self, time_s: float) -> None:
        self.stop.wait(CRAWL_S if self._warns() and not self.go_on else PERIOD_S)
        while time_s - max(self.time_s, START_S) > BEHIND_S and not self.stop.wait(PERIOD_S):
            pass

    def _warns(self) -> bool:
        moment = self.feed.newer_than(-1, 0)
        return moment is not None and moment.result.warning.level is WarningLevel.WARNING

    @property
    def time_s(self) -> float:
        """Of the latest result."""
        moment = self.feed.newer_than(-1, 0)
        return 0.0 if moment is None else moment.result.time_ns / 1e9


@pytest.fixture
def drive(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> Generator[Drive]:
    made = Drive(tmp_path / "out")
    yield made
    made.stop.set()
    made.camera.over.set()
    if made.pipeline.ident is not None:
        made.pipeline.join()
    made.page.stop()
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == []


def drawn(person: Reviewer) -> Callable[[], str]:
    """Which picture is on the screen."""
    return lambda: person.browser.page.evaluate("window.__viserMutable?.lastDrawn?.uuid ?? ''")


def test_a_live_drive_is_seen_and_heard_and_then_reviewed(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(drive.page.url, picture=False, drawn_at=0.25))
    page = person.browser.page
    page.wait_for_function("document.documentElement.dataset.fcwSound === 'waits'")
    assert "silent until you click" in person.words(".fcw-sound .waits")
    assert "waiting for the first picture" in person.words(".fcw-drive + p")
    assert not person.at(".fcw-age").is_visible()  # there is no picture that could be old
    drive.page.say_waiting("getting ready")
    wait_for(lambda: "getting ready" in person.words(".fcw-drive + p"))
    page.evaluate(LISTEN)
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    page.keyboard.press("o")  # the first gesture
    page.wait_for_function("document.documentElement.dataset.fcwSound === 'on'")
    before = picture()
    wait_for(lambda: picture() != before)
    wait_for(
        lambda: (
            re.search(r"result \d+ ms .*on the screen \d+ ms", person.words("[data-name=latency]"))
            is not None
        )
    )

    page.wait_for_selector(".fcw-alarm.warning")
    assert WARNED_S[0] < drive.time_s < WARNED_S[1]
    wait_for(lambda: "Brake!" in person.words(".fcw-alarm"))
    wait_for(lambda: WARNING_HZ in page.evaluate("tones"))
    page.keyboard.press("m")
    page.wait_for_function("document.documentElement.dataset.fcwSound === 'muted'")
    drive.go_on = True
    heard = len(page.evaluate("tones"))
    assert 'data-name="curve"' in page.locator(".fcw-area").first.inner_html()

    drive.pipeline.join()
    assert len(page.evaluate("tones")) == heard
    with page.expect_navigation():
        drive.page.review(drive.out / "drive.mcap", "anna")
    wait_for(lambda: person.row >= 0)
    person.browser.wait_until_ready()
    wait_for(lambda: person.browser.page.locator(".fcw-event").count() >= 1)
    wait_for(lambda: person.browser.page.locator(".fcw-alarm").count() == 0)


def is_said_old(person: Reviewer) -> bool:
    """Whether the page says that its picture is old."""
    opacity = "Number(getComputedStyle(document.querySelector('.fcw-late') ?? document.head).opacity)"
    there = person.browser.page.locator(".fcw-late").count() > 0
    return there and person.browser.page.evaluate(opacity) == 1


def test_a_page_that_hears_nothing_any_more_says_so(drive: Drive, open_page: OpenPage, wait_for: WaitFor):
    person = Reviewer(open_page(drive.page.url, picture=False))
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    wait_for(lambda: not is_said_old(person))
    page = person.browser.page
    wait_for(lambda: all(page.locator(selector).first.is_visible() for selector in PRESENT))
    drive.stop.set()  # as when the camera hangs: the page is told of no end
    wait_for(lambda: is_said_old(person))
    drive.page.say_ended("ended by hand")
    wait_for(lambda: not is_said_old(person))
    wait_for(lambda: person.words(".fcw-drive span") == "ended")
    wait_for(lambda: "ended by hand" in person.words(".fcw-drive + p"))
    drive.pipeline.join()
    before = picture()
    person.press("o")  # its last picture is drawn once more, and the drive is over all the same
    wait_for(lambda: picture() != before)
    wait_for(lambda: person.words(".fcw-drive span") == "ended")
    assert not is_said_old(person)
    assert not any(page.locator(selector).first.is_visible() for selector in PRESENT)


def test_a_page_whose_camera_is_gone_says_so_and_then_for_good(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(drive.page.url, picture=False))
    page = person.browser.page
    page.evaluate(LISTEN)
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    page.keyboard.press("o")
    page.wait_for_function("document.documentElement.dataset.fcwSound === 'on'")
    drive.camera.trouble = "the camera is gone; connecting again"
    wait_for(lambda: person.words(".fcw-late") == "The camera is gone; connecting again")
    wait_for(lambda: is_said_old(person))
    said = [page.locator(selector).first for selector in (".fcw-live", ".fcw-level")]
    assert not any(one.is_visible() for one in said)  # whether there is no danger nobody knows
    drive.camera.trouble = ""  # it is there again
    wait_for(lambda: "This picture is old" in person.words(".fcw-late"))
    wait_for(lambda: not is_said_old(person))
    wait_for(lambda: all(one.is_visible() for one in said))

    drive.camera.trouble = "the camera is gone (broken)"
    drive.camera.over.set()
    drive.pipeline.join()
    wait_for(lambda: person.words(".fcw-drive span") == "ended")
    drive.page.review(drive.out / "drive.mcap", "anna")
    assert is_said_old(person)
    assert person.words(".fcw-late") == "No more warnings: the camera is gone (broken)"
    assert not any(page.locator(selector).first.is_visible() for selector in PRESENT)
    assert set(page.evaluate("tones")) == LOST_HZ
    assert len(page.evaluate("tones")) == 6  # heard once
    with page.expect_navigation():
        person.at("[data-fcw='review:']").click()
    wait_for(lambda: person.row >= 0)


def level_color(person: Reviewer) -> str:
    """Of the bar beside the level's words."""
    return person.at(".fcw-level").evaluate("(shown) => getComputedStyle(shown).borderLeftColor")


def test_panel_and_warning_say_the_same_while_no_picture_can_be_drawn(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(tab, "LOST_S", math.inf)
    person = Reviewer(open_page(drive.page.url, picture=False))
    page = person.browser.page
    drive.pipeline.start()
    wait_for(lambda: person.words(".fcw-level") == "no warning")
    page.evaluate(NO_WORD_OF_DRAWN_PICTURES)
    wait_for(lambda: level_color(person) == GREY)  # that there is nothing to warn of is as old as the picture
    page.wait_for_selector(".fcw-alarm.warning")
    wait_for(lambda: person.words(".fcw-level") == "warning: act now")
    (distance,) = re.findall(r"^[\d.]+ m", person.words(".fcw-alarm span"))
    assert distance in person.words(".fcw-why")
    assert level_color(person) != GREY


HEIGHT_PX = 844
LATE_MS = 3000
HELD_UP_MS = LATE_MS + 1000
"""The picture that is drawn late may set out only after the page is held up."""
HOLD_UP = f"() => {{ const start = performance.now(); while (performance.now() - start < {HELD_UP_MS}); }}"


def test_a_picture_drawn_late_is_counted_as_old_as_it_is(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(drive.page.url, picture=False))
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    shown = drive.page.tabs[0]
    assert isinstance(shown, LiveTab)
    page = person.browser.page
    page.wait_for_function("document.querySelector('[data-fcw-age]').textContent.endsWith('s')")
    page.evaluate(HOLD_UP)
    wait_for(lambda: shown.latency.figures.drawn_worst_s >= LATE_MS / 1000)


def test_from_above_a_narrow_window_shows_level_and_age_all_the_same(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(drive.page.url, window_px=(390, HEIGHT_PX), picture=False))
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    person.press("b")
    wait_for(lambda: person.browser.page.locator(".mantine-Paper-root img:visible").count() == 1)
    # While it warns the reason is longest.
    wait_for(lambda: person.words(".fcw-level") == "warning: act now" and "Rule" in person.words(".fcw-why"))
    wait_for(lambda: all(is_in_sight(person, selector) for selector in (".fcw-level", ".fcw-age")))


def test_in_a_narrow_window_the_notice_of_an_old_picture_is_one_line_at_its_edge(
    drive: Drive, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(drive.page.url, window_px=(390, HEIGHT_PX), picture=False))
    drive.pipeline.start()
    picture = drawn(person)
    wait_for(lambda: picture() != "")
    drive.stop.set()
    wait_for(lambda: is_said_old(person))
    notice = person.at(".fcw-late")
    box = notice.bounding_box()
    assert box is not None
    assert (box["x"], box["y"], box["width"]) == (0, 0, 390)
    assert box["height"] < 30
    assert notice.evaluate("(shown) => shown.scrollWidth <= shown.clientWidth")  # all of it


def is_in_sight(person: Reviewer, selector: str) -> bool:
    """Whether all of an element is seen without scrolling."""
    box = person.at(selector).bounding_box()
    return box is not None and box["y"] + box["height"] <= HEIGHT_PX
