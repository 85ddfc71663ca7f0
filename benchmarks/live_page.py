"""How soon a live drive is shown, what a browser that watches costs it, and what the view from above costs.

    python benchmarks/live_page.py [--seconds 20]

Needs a Chromium and playwright, of the `dev` group. The shipped drive runs live twice, watched by nobody and
by a headless Chromium with software rendering; latencies count from a picture's coming to the program.
"""

import os
import tempfile
import threading
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from chromium import chromium, option_parser
from lines import say
from playwright.sync_api import Page

from fcw.frame import VideoPacket
from fcw.job import DriveJob
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw.logs.pictures import LogPictures
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources import open_source
from fcw.sources.live import LiveSource
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console
from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.server import LivePage
from fcw_viz.live_app.tab import LiveTab

DRIVE = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
WARM_UP_S = 4.0
"""The first pictures wait for compiled code."""
FROM_ABOVE_FRAMES = 300
READY_MS = 60_000


class Latencies:
    """A sink that notes how old each result is."""

    def __init__(self, source: LiveSource) -> None:
        self._source = source
        self.found_s: list[tuple[float, float]] = []

    def open(self, header: DriveHeader) -> None:
        """Nothing to do."""

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Note a result's age."""
        capture, now_s = self._source.capture(result.index), self._source.now_s()
        if capture is not None:
            self.found_s.append((now_s, now_s - capture.captured_s))

    def close(self) -> None:
        """Nothing to do."""


def main() -> None:
    """Read the command line and measure."""
    parser = option_parser(__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="of each run")
    options = parser.parse_args()
    say(f"{datetime.now(UTC):%Y-%m-%d}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with chromium(options) as browser:
        live(None, options.seconds)
        live(browser.new_page(), options.seconds)


def live(page: Page | None, seconds: float) -> None:
    """One run; with a page the view from above is measured after it."""
    stop = threading.Event()
    source = LiveSource(open_source(DRIVE), stop)
    feed, latencies = LiveFeed(source), Latencies(source)
    served = LivePage(feed, "drive")
    try:
        with tempfile.TemporaryDirectory() as out:
            if page is not None:
                page.goto(f"{served.url}/?fixedDpr=1")
                page.wait_for_selector(".fcw-live", timeout=READY_MS)
            job = DriveJob(DRIVE, Path(out))
            pipeline = threading.Thread(
                target=run_on_console, args=(job, SILENT, source, (feed, latencies), stop)
            )
            pipeline.start()
            if page is None:
                time.sleep(seconds)
            else:
                page.wait_for_timeout(seconds * 1000)
            stop.set()
            pipeline.join()
            start_s = latencies.found_s[0][0] + WARM_UP_S
            ages_ms = np.array([age_s for now_s, age_s in latencies.found_s if now_s > start_s]) * 1000
            who = "nobody" if page is None else "a browser"
            median_ms, p95_ms = np.quantile(ages_ms, (0.5, 0.95))
            say(
                f"{who} watches: result after {median_ms:.0f} ms, p95 {p95_ms:.0f} ms, "
                f"of {len(latencies.found_s)} pictures; {source.dropped} left out"
            )
            if page is not None:
                (tab,) = served.tabs
                assert isinstance(tab, LiveTab)
                say(f"of the last pictures: {tab.latency.figures.words()}")
                from_above(tab, Path(out) / MCAP_NAME)
    finally:
        served.stop()


def from_above(tab: LiveTab, path: Path) -> None:
    """The server's processor time of an update with its picture, in the tab's own thread as always."""
    log, taken_ms, done = DriveLog(path), [], threading.Event()
    pictures = LogPictures(log)

    def measure() -> None:
        tab.birds_eye.toggle()
        for number, result in enumerate(log.results()):
            if number == FROM_ABOVE_FRAMES:
                break
            image = pictures.at(result.index)
            start_s = time.thread_time()
            tab.view.show(image)
            tab.birds_eye.show(result)
            taken_ms.append((time.thread_time() - start_s) * 1000)
            time.sleep(0.02)  # the sender's turn, as between frames
        done.set()

    tab.run(measure)
    done.wait()
    pictures.close()
    say(
        f"from above: {np.median(taken_ms):.2f} ms an update, p95 {np.quantile(taken_ms, 0.95):.2f} ms, "
        f"over {len(taken_ms)} frames"
    )


if __name__ == "__main__":
    main()
