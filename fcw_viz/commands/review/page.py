"""`fcw review` without --rerun: the page in the browser."""

import getpass
from pathlib import Path

from fcw.batch.tables import unfinished_drives
from fcw.errors import UserError
from fcw.logs.export.clip import find_drives
from fcw.logs.names import MCAP_NAME
from fcw_viz.commands.review.options import ReviewCommand
from fcw_viz.console import RESULTS
from fcw_viz.page.server import DEFAULT_PORT
from fcw_viz.review_app.server import ReviewPage


def review_in_page(command: ReviewCommand) -> int:
    """Serve the page until Ctrl-C, which is how it ends.

    Raises:
        UserError: there is no drive, it cannot be read, or the port or the name is none.
        KeyboardInterrupt: the end.
    """
    path: Path = command.path
    try:
        drives = find_drives([path])
    except UserError:
        if not unfinished_drives(path):
            raise
        drives = {}  # a batch of which no drive is done yet: the list names each with its reason
    port = DEFAULT_PORT if command.port is None else command.port
    title = next(iter(drives)) if len(drives) == 1 else path.resolve().name
    # A folder of drives, not that of one drive.
    root = path if path.is_dir() and not (path / MCAP_NAME).is_file() else None
    page = ReviewPage(drives, title, command.reviewer or login_name(), port, command.dark, root)
    try:
        page.announce(RESULTS, "review", "Ctrl-C ends; every word is kept", not command.no_open)
        page.wait()
    finally:
        page.stop()
    return 0


def login_name() -> str:
    """Who is logged in; a container may not know, nor a service on Windows, where there is no `pwd`."""
    try:
        return getpass.getuser()
    except (ImportError, KeyError, OSError):
        return "reviewer"
