"""The page's server: one session for all tabs."""

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
    """A running page.

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
            drives: the logs by their names, at least one.
            title: of all of them.
            reviewer: in whose name verdicts are kept.
            port: wished for; the next free one where it is taken.
            dark: colours at the beginning.
            root: the folder that they were found in: drives that come there later are served, too.

        Raises:
            UserError: the one drive cannot be read, the reviewer's name is none for a file, or the port none.
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
        """A tab on the session."""
        return Tab(client, self.session, self._title, self._dark)

    def stop(self) -> None:
        """End it; all that was said is kept already."""
        super().stop()
        self.session.close()
