"""A page whose program is away or has ended says so, and comes back with it: the same for every page."""

import os
import shutil
import signal
from pathlib import Path

import pytest
from browser_page import PATIENCE_S
from calibrate_helpers import DEMO_DRIVE, FIRST_PORT
from review_drives import QUIET_S, write_drive
from review_helpers import OpenPage, Reviewer, WaitFor
from running.programs import serve_page

PORTS = {"review": FIRST_PORT + 90, "calibrate": FIRST_PORT + 91}
"""Nobody else's, for a page must come back where it was."""
TRIES = 12
"""So many seconds, each a try of viser's own, are more than Chromium answers at once."""


@pytest.mark.slow
@pytest.mark.parametrize(("command", "end"), [("review", signal.SIGINT), ("calibrate", signal.SIGKILL)])
def test_a_page_whose_program_is_gone_says_so_and_returns_with_it(
    command: str, end: signal.Signals, tmp_path: Path, open_page: OpenPage, wait_for: WaitFor
):
    if command == "review":
        source = write_drive(tmp_path / "drive.mcap", QUIET_S)
    else:
        source = Path(shutil.copy(DEMO_DRIVE, tmp_path))
    process, url = serve_page(command, source, "--no-open", "--port", PORTS[command])
    person = Reviewer(open_page(url))
    person.browser.page.evaluate("window.isOld = true")
    os.kill(process.pid, end)
    process.communicate(timeout=PATIENCE_S)
    ended = "The program has ended" if end is signal.SIGINT else "The program does not answer"
    wait_for(lambda: ended in person.words(".fcw-gone"))
    person.browser.page.wait_for_timeout(TRIES * 1000)
    assert ended in person.words(".fcw-gone")

    process, again = serve_page(command, source, "--no-open", "--port", PORTS[command])
    try:
        assert again == url
        person.browser.page.wait_for_function("!window.isOld")
        person.browser.wait_until_ready()
        assert person.browser.page.locator(".fcw-gone").count() == 0
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE_S)
