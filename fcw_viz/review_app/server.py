"""The page's server: one session for all tabs, on this machine only."""

import threading
from collections.abc import Mapping
from pathlib import Path

import viser

from fcw.annotation.store import review_path
from fcw_viz.page.server import DEFAULT_PORT, check_port, server_url, start_server, stop_server
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.tab import Tab


class ReviewPage:
    """A running page.

    Attributes:
        session: what its tabs share.
        url: where it is.
        port: the one it got.
    """

    def __init__(
        self,
        drives: Mapping[str, Path],
        title: str,
        reviewer: str,
        port: int = DEFAULT_PORT,
        dark: bool = False,
    ) -> None:
        """Serve drives.

        Args:
            drives: the logs by their names, at least one.
            title: of all of them.
            reviewer: in whose name verdicts are kept.
            port: wished for; the next free one where it is taken.
            dark: colours at the beginning.

        Raises:
            UserError: the one drive cannot be read, the reviewer's name is none for a file, or the port none.
        """
        check_port(port)
        for path in list(drives.values())[:1]:
            review_path(path, reviewer)
        if len(drives) == 1:
            Drive.open(*next(iter(drives.items())))
        self.session = ReviewSession(drives, reviewer)
        self._title, self._dark = title, dark
        self._tabs: dict[int, Tab] = {}
        self._server = start_server(port, f"fcw review · {title}", dark)
        self.port = self._server.get_port()
        self.url = server_url(self._server)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)
        self.session.start()

    def stop(self) -> None:
        """End it; all that was said is kept already."""
        for client_id in list(self._tabs):
            self._tabs.pop(client_id).close()
        stop_server(self._server)
        self.session.close()

    def wait(self) -> None:
        """Wait for ever; Ctrl-C raises KeyboardInterrupt."""
        threading.Event().wait()

    async def _connected(self, client: viser.ClientHandle) -> None:
        self._tabs[client.client_id] = Tab(client, self.session, self._title, self._dark)

    async def _disconnected(self, client: viser.ClientHandle) -> None:
        tab = self._tabs.pop(client.client_id, None)
        if tab is not None:
            tab.close()
