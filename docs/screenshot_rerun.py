"""Take a picture of a rerun recording as the web viewer shows it, at a time of the drive.

    python docs/screenshot_rerun.py drive.rrd 12.5 drive.png

Needs a Chromium and `pip install playwright`, which the project itself does not use. Everything stays on
this machine: the viewer is served locally, the browser reaches nothing else, rerun's usage data are off.
"""

import argparse
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote

from playwright.sync_api import Page, sync_playwright

BROWSER_ARGUMENTS = (
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)
SERVER_TIMEOUT_S = 30.0
DRAWN_TIMEOUT_S = 90.0
STEADY_S = 4.0
"""The picture counts as drawn once it has stayed the same this long: software rendering is slow."""
TIME_FIELD_FROM_CORNER_PX = (90, 14)
"""Where the time panel has its field for the time, left of and above the window's lower right corner."""


def main() -> None:
    """Read the command line and take the picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("recording", type=Path, help="an .rrd file of `fcw run`")
    parser.add_argument("time_s", type=float, help="seconds on the drive's clock")
    parser.add_argument("picture", type=Path, help="the .png to write")
    parser.add_argument("--size", default="1600x1000", help="of the window, WIDTHxHEIGHT")
    parser.add_argument("--theme", choices=("dark", "light"), default="dark")
    found = shutil.which("chromium") or shutil.which("chromium-headless-shell")
    parser.add_argument("--browser", default=found, help="the Chromium to use")
    options = parser.parse_args()
    width, height = (int(length) for length in options.size.split("x"))

    with viewer(options.recording) as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.browser, args=list(BROWSER_ARGUMENTS))
        page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=options.theme)
        page.goto(url)
        wait_until_drawn(page)
        right_px, up_px = TIME_FIELD_FROM_CORNER_PX
        page.mouse.click(width - right_px, height - up_px)
        page.keyboard.press("Control+A")
        page.keyboard.type(f"{options.time_s:+.3f}s")
        page.keyboard.press("Enter")
        wait_until_drawn(page)
        page.screenshot(path=options.picture)
        browser.close()


@contextmanager
def viewer(recording: Path) -> Iterator[str]:
    """Serve the web viewer on a recording and give its address; ended afterwards with all it started."""
    port, web_port = free_port(), free_port()
    server = subprocess.Popen(
        [
            *(sys.executable, "-m", "rerun_cli", str(recording), "--web-viewer", "--bind", "127.0.0.1"),
            *("--port", str(port), "--web-viewer-port", str(web_port)),
        ],
        start_new_session=True,  # it starts the viewer as a process of its own: both end with their group
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"CI": "1"},  # where rerun sends no usage data, and opens no browser
    )
    try:
        wait_for_port(web_port)
        wait_for_port(port)
        proxy = quote(f"rerun+http://127.0.0.1:{port}/proxy", safe="")
        yield f"http://127.0.0.1:{web_port}/?url={proxy}&renderer=webgl"
    finally:
        os.killpg(server.pid, signal.SIGTERM)
        server.wait()


def wait_until_drawn(page: Page) -> None:
    """Wait until the viewer shows something and its picture no longer changes."""
    end_s = time.monotonic() + DRAWN_TIMEOUT_S
    page.wait_for_selector("canvas", timeout=DRAWN_TIMEOUT_S * 1000)
    last, since_s = b"", time.monotonic()
    while time.monotonic() < end_s:
        time.sleep(0.5)
        now = page.screenshot()
        if now != last:
            last, since_s = now, time.monotonic()
        elif time.monotonic() - since_s > STEADY_S:
            return
    raise SystemExit(f"the viewer's picture did not come to rest within {DRAWN_TIMEOUT_S:g} s")


def free_port() -> int:
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for_port(port: int) -> None:
    """Wait until somebody listens."""
    end_s = time.monotonic() + SERVER_TIMEOUT_S
    while time.monotonic() < end_s:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise SystemExit(f"rerun's viewer did not start within {SERVER_TIMEOUT_S:g} s")


if __name__ == "__main__":
    main()
