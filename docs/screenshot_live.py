"""Take the pictures of a live drive, and of the road from above, that stand in the documentation.

    python docs/screenshot_live.py [--out docs/images] [--detector acf]

Needs a Chromium and playwright from the `dev` group. The shipped drive runs live, in real time. One picture
is taken while it warns, the other one from its review afterwards. A busy computer may need the quicker
detector.
"""

import tempfile
import threading
from pathlib import Path

from page_pictures import READY_MS, STEADY_MS, chromium, option_parser, steady_screenshot, window
from playwright.sync_api import Page

from fcw.job import DriveJob
from fcw.logs.names import MCAP_NAME
from fcw.sources import open_source
from fcw.sources.live import LiveSource
from fcw_viz.console import SILENT
from fcw_viz.jobs.drive import run_on_console
from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.server import LivePage

ROOT = Path(__file__).parents[1]
DRIVE = ROOT / "recordings" / "demo" / "drive.mp4"
INTO_WARNING_MS = 1_400
"""From the beginning of the warning to its picture."""
FROM_ABOVE_S = 31.0
"""Of the drive, while it warns."""
WARNED_MS = 180_000
"""The program starts, and then the drive takes half a minute to its warning."""


def main() -> None:
    """Read the command line and take the pictures."""
    parser = option_parser(__doc__)
    parser.add_argument("--detector", default="net", help="of the run")
    options = parser.parse_args()

    with chromium(options) as browser, tempfile.TemporaryDirectory() as folder:
        take(window(browser, options).new_page(), Path(folder), options.out, options.detector)


def take(page: Page, logs: Path, out: Path, detector: str) -> None:
    """Run the drive and take both pictures."""
    source = LiveSource(open_source(DRIVE), threading.Event())
    feed = LiveFeed(source)
    served = LivePage(feed, "drive")
    job = DriveJob(DRIVE, logs, detector=detector, ego_speed=str(DRIVE.with_name("drive.speed.csv")))
    arguments = (job, SILENT, source, (feed,))
    pipeline = threading.Thread(target=run_on_console, args=arguments)
    try:
        page.goto(f"{served.url}/?fixedDpr=1")
        page.wait_for_selector(".fcw-live", timeout=READY_MS)
        page.mouse.click(300, 300)  # without a gesture there is no sound
        pipeline.start()
        page.wait_for_selector(".fcw-alarm.warning", timeout=WARNED_MS)
        page.wait_for_timeout(INTO_WARNING_MS)
        (out / "review-live.png").write_bytes(page.screenshot())
        pipeline.join()
        served.review(logs / MCAP_NAME, "anna")
        page.goto(f"{served.url}/?fixedDpr=1&at=drive@{FROM_ABOVE_S}")
        page.wait_for_selector(".fcw-clock", timeout=READY_MS)
        steady_screenshot(page)
        page.keyboard.press("b")
        page.wait_for_timeout(STEADY_MS)
        (out / "review-birds-eye.png").write_bytes(steady_screenshot(page))
    finally:
        served.stop()


if __name__ == "__main__":
    main()
