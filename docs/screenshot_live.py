"""Take the pictures of a live drive, and of the road from above, that stand in the documentation.

    python docs/screenshot_live.py [--out docs/images] [--rate 0.2] [--start 15]

Needs a Chromium and playwright from the `dev` group. The shipped drive runs as from a camera. One picture is
taken while it warns, the other one from its review afterwards. On a busy computer, play the drive at a lower
rate, so that enough pictures are processed.
"""

import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from page_pictures import READY_MS, STEADY_MS, chromium, option_parser, steady_screenshot, window
from playwright.sync_api import Page

from fcw.frame import Frame, Source
from fcw.job import DriveJob
from fcw.logs.names import MCAP_NAME
from fcw.sources import open_source
from fcw.sources.forwarding import ForwardingSource
from fcw.sources.live import LiveSource
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console
from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.server import LivePage

ROOT = Path(__file__).parents[1]
DRIVE = ROOT / "recordings" / "demo" / "drive.mp4"
INTO_WARNING_MS = 1_000
"""From the beginning of the warning to its picture, in the drive."""
FROM_ABOVE_S = 31.0
"""Of the drive, while it warns."""
FRESH = "() => parseFloat(document.querySelector('[data-fcw-age]').textContent) < 0.7"
"""The picture is new enough to be taken before the page says that it is old."""
WARNED_MS = 60_000
"""The program starts, and then the drive takes half a minute to its warning; divided by the rate."""


class PacedSource(ForwardingSource):
    """A source whose frames come at a rate, as a camera's do, from some time of the drive on."""

    def __init__(self, source: Source, rate: float, start_s: float) -> None:
        super().__init__(source)
        self._rate, self._start_s = rate, start_s

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Each frame when it is due."""
        first: tuple[int, float] | None = None
        for frame in self._source.frames(round(self._start_s * 1e9) if start_ns is None else start_ns):
            first = first or (frame.time_ns, time.monotonic())
            due_s = first[1] + (frame.time_ns - first[0]) / 1e9 / self._rate
            time.sleep(max(due_s - time.monotonic(), 0.0))
            yield frame


def main() -> None:
    """Read the command line and take the pictures."""
    parser = option_parser(__doc__)
    parser.add_argument("--rate", type=float, default=1.0, help="of the drive; 1 is real time")
    parser.add_argument("--start", type=float, default=0.0, help="seconds of the drive that are left out")
    options = parser.parse_args()

    with chromium(options) as browser, tempfile.TemporaryDirectory() as folder:
        take(window(browser, options).new_page(), Path(folder), options.out, options.rate, options.start)


def take(page: Page, logs: Path, out: Path, rate: float, start_s: float) -> None:
    """Run the drive and take both pictures."""
    stop = threading.Event()
    source = LiveSource(PacedSource(open_source(DRIVE), rate, start_s), stop, paced=False)
    feed = LiveFeed(source)
    served = LivePage(feed, "drive")
    job = DriveJob(DRIVE, logs, ego_speed=str(DRIVE.with_name("drive.speed.csv")))
    arguments = (job, SILENT, source, (feed,))
    pipeline = threading.Thread(target=run_on_console, args=arguments)
    try:
        page.goto(f"{served.url}/?fixedDpr=1")
        page.wait_for_selector(".fcw-live", timeout=READY_MS)
        page.mouse.click(300, 300)  # without a gesture there is no sound
        pipeline.start()
        page.wait_for_selector(".fcw-alarm.warning", timeout=WARNED_MS / rate)
        page.wait_for_timeout(INTO_WARNING_MS / rate)
        page.wait_for_function(FRESH, timeout=READY_MS)
        (out / "review-live.png").write_bytes(page.screenshot())
        pipeline.join()
        served.review(logs / MCAP_NAME, "anna")
        page.goto(f"{served.url}/?fixedDpr=1&at=drive@{FROM_ABOVE_S - start_s}")
        page.wait_for_selector(".fcw-clock", timeout=READY_MS)
        steady_screenshot(page)
        page.keyboard.press("b")
        page.wait_for_timeout(STEADY_MS)
        (out / "review-birds-eye.png").write_bytes(steady_screenshot(page))
    finally:
        stop.set()
        served.stop()


if __name__ == "__main__":
    main()
