"""How soon the list of many drives is seen, filtered, and led from to the next unjudged event.

    PYTHONPATH=benchmarks python benchmarks/review/drive_list.py DRIVE.mcap ... [--drives 200]

The page serves a folder of so many drives, made by repeating those that are named, in a process of its own;
one of them has no event of level `caution`, for the filter to leave out.
Every clock starts with what a person does and stops with the first frame that shows what was asked for, in
Chromium. The load of the machine is told beside the figures: with other programs at work they are longer.
"""

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from chromium import READY, SEES_LIST, WINDOW, chromium, option_parser
from playwright.sync_api import Page
from review_page_latency import READY_MS, serving

from fcw.versions import machine

ROWS = "document.querySelectorAll('.fcw-row').length"
ALL_READ = "!/reading/.test(document.querySelector('.fcw-folder > p')?.innerText ?? 'reading')"
FILTERED = "[...document.querySelectorAll('.fcw-folder > p')].some((p) => /match the/.test(p.innerText))"
PICTURED = (
    "[...document.querySelectorAll('.fcw-row .fcw-thumb')].every((one) => one.style.backgroundImage !== '')"
)


def main() -> None:
    """Make the folder, and do what a person does."""
    parser = option_parser(__doc__)
    parser.add_argument("logs", type=Path, nargs="+", metavar="DRIVE.mcap")
    parser.add_argument("--drives", type=int, default=200)
    options = parser.parse_args()
    say(f"{machine()}; {datetime.now(UTC):%Y-%m-%d}; {options.drives} drives")
    with tempfile.TemporaryDirectory() as folder, chromium(options) as browser:
        for number in range(options.drives):
            log = options.logs[number % len(options.logs)]
            (Path(folder) / f"drive{number:04d}").mkdir()
            shutil.copy(log, Path(folder) / f"drive{number:04d}" / "drive.mcap")
        with serving(Path(folder)) as server:
            page = browser.new_context(viewport=WINDOW).new_page()
            page.set_default_timeout(READY_MS)
            start_s = time.perf_counter()
            page.add_init_script(SEES_LIST)
            page.goto(f"{server.url}/?fixedDpr=1", wait_until="commit")
            page.wait_for_function("window.listSeenAt")
            tell("the list is seen", page.evaluate("listSeenAt") / 1000)
            for words, condition in (
                ("what is asked for is answered", READY),
                ("every drive is read", ALL_READ),
                ("every drive that is seen has its picture", PICTURED),
            ):
                page.wait_for_function(condition, polling="raf")
                tell(words, time.perf_counter() - start_s)
            say(f"the server's processor time until then: {server.processor_s():.1f} s")
            page.wait_for_timeout(3000)
            kinds = page.locator("select[data-fcw-choice=filterkind]")
            asked(page, "filtered by kind", lambda: kinds.select_option("caution"), FILTERED)
            asked(page, "all again", lambda: kinds.select_option(""), f"!({FILTERED})")
            search = page.locator("#fcw-search")
            asked(page, "searched by name", lambda: search.fill("0003"), f"{ROWS} === 1")
            asked(page, "all again", lambda: search.fill(""), f"{ROWS} > 1")
            page.locator("h1").click()
            shown = "!!document.querySelector('.fcw-clock')"
            asked(page, "the next unjudged event, its drive opened", lambda: page.keyboard.press("u"), shown)


def asked(page: Page, words: str, act: Callable[[], object], condition: str) -> None:
    """Do something and tell how soon it is seen."""
    start_s = time.perf_counter()
    act()
    page.wait_for_function(condition, polling="raf")
    tell(words, time.perf_counter() - start_s)
    page.wait_for_timeout(1500)


def tell(words: str, seconds: float) -> None:
    """Print a figure with the load that it was measured under."""
    say(f"{words}: {seconds:.2f} s (load {os.getloadavg()[0]:.1f})")


def say(text: str) -> None:
    """Print a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
