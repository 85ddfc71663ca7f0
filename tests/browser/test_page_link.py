"""A page whose program is away or has ended says so, and comes back with it: the same for every page."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from browser_page import PATIENCE_S
from calibrate_helpers import DEMO_DRIVE, FIRST_PORT
from review_drives import QUIET_S, write_drive
from review_helpers import OpenPage, Reviewer, WaitFor
from running.programs import serve_page

PORTS = {"review": FIRST_PORT + 90, "calibrate": FIRST_PORT + 91}
"""Nobody else's, for a page must come back where it was."""
ENDED = {
    "review": (signal.SIGINT, "The program has ended"),
    "calibrate": (signal.SIGKILL, "The program is not responding"),
}
"""How, and what its page says then."""
TRIES = 12
"""So many seconds, each a try of viser's own, are more than Chromium answers at once."""

# viser's, while it tries to connect: to draw them in software takes a fifth of a processor for each page.
NO_DANCING_DOTS = "* { animation: none !important; }"


@pytest.mark.slow
def test_pages_whose_program_is_gone_say_so_and_return_with_it(
    tmp_path: Path, open_page: OpenPage, wait_for: WaitFor
):
    # Both at once: most of this is waiting.
    sources = {
        "review": write_drive(tmp_path / "drive.mcap", QUIET_S),
        "calibrate": Path(shutil.copy(DEMO_DRIVE, tmp_path)),
    }
    started = {command: serve(command, source) for command, source in sources.items()}
    people = {command: Reviewer(open_page(url)) for command, (_, url) in started.items()}
    for command, (process, _) in started.items():
        people[command].browser.page.evaluate("window.isOld = true")
        people[command].browser.page.add_style_tag(content=NO_DANCING_DOTS)
        os.kill(process.pid, ENDED[command][0])
        process.communicate(timeout=PATIENCE_S)
    for command, person in people.items():
        wait_for(lambda person=person, says=ENDED[command][1]: says in person.words(".fcw-gone"))
    people["review"].browser.page.wait_for_timeout(TRIES * 1000)
    for command, person in people.items():
        assert ENDED[command][1] in person.words(".fcw-gone")

    again = {command: serve(command, source) for command, source in sources.items()}
    try:
        for command, person in people.items():
            assert again[command][1] == started[command][1]
            person.browser.page.wait_for_function("!window.isOld")
            person.browser.wait_until_ready()
            assert person.browser.page.locator(".fcw-gone").count() == 0
    finally:
        for process, _ in again.values():
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=PATIENCE_S)


def serve(command: str, source: Path) -> tuple["subprocess.Popen[str]", str]:
    """Where it was before, for pages to find it."""
    return serve_page(command, source, "--no-open", "--port", PORTS[command])
