"""The server of the review page, with one session for all tabs."""

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import parse_qs

import viser

from fcw.annotation.store import review_path
from fcw_viz.page.first import first_html
from fcw_viz.page.server import DEFAULT_PORT, PageServer, check_port
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.panels.layout import first_list
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.tab import Tab
from fcw_viz.review_app.triage.drive_filter import parse_filter


class ReviewPage(PageServer):
    """The review page while it is served.

    Attributes:
        session: what its tabs share.
    """

    def __init__(
        self,
        drives: Mapping[str, Path],
        title: str,
        reviewer: str,
        port: int = DEFAULT_PORT,
        dark: bool = False,
        root: Path | None = None,
    ) -> None:
        """Serve drives.

        Args:
            drives: the logs by name, at least one.
            title: title of the page.
            reviewer: name under which verdicts are stored.
            port: preferred port; the next free one is used if it is taken.
            dark: whether the page starts in dark colours.
            root: the folder in which they were found; drives that appear there later are served too.

        Raises:
            UserError: the only drive cannot be read, or the reviewer's name or the port is not valid.
        """
        check_port(port)
        for path in list(drives.values())[:1]:
            review_path(path, reviewer)
        if len(drives) == 1:
            Drive.open(*next(iter(drives.items())))
        self.session = ReviewSession(drives, reviewer, root)
        self._title, self._dark = title, dark
        super().__init__(port, f"fcw review · {title}", dark)
        self.session.start()

    def first_html(self, query: str) -> str:
        """The list of the drives, unless the address leads to one of them."""
        said = parse_qs(query)
        if not self.session.folder.several or any(said.get("at", ())):
            return ""
        asked = parse_filter(said.get("asked", [""])[-1])
        return first_html(first_list(self.session, self._title, asked), ".fcw-folder", self._dark)

    def open_tab(self, client: viser.ClientHandle) -> Tab:
        """Open a tab on the session."""
        return Tab(client, self.session, self._title, self._dark)

    def stop(self) -> None:
        """End the page; everything that was said is already stored."""
        super().stop()
        self.session.close()
