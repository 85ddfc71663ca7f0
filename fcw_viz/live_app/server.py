"""The live page's server: the running drive in every tab, and its review once it has ended."""

import threading
from pathlib import Path

import viser

from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.tab import LiveTab
from fcw_viz.page.script import run_script
from fcw_viz.page.server import DEFAULT_PORT, check_port, server_url, start_server, stop_server
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.tab import Tab


class LivePage:
    """A running page.

    Attributes:
        url: where it is.
        port: the one it got.
    """

    def __init__(self, feed: LiveFeed, title: str, port: int = DEFAULT_PORT, dark: bool = False) -> None:
        """Serve a drive that begins, or has begun.

        Args:
            feed: what the pipeline tells.
            title: of the drive.
            port: wished for; the next free one where it is taken.
            dark: colours at the beginning.

        Raises:
            UserError: the port is none.
        """
        check_port(port)
        self._feed, self._title, self._dark = feed, title, dark
        self._session: ReviewSession | None = None
        self._lock = threading.Lock()
        self._tabs: dict[int, LiveTab | Tab] = {}
        self._server = start_server(port, f"fcw · {title}", dark)
        self.port = self._server.get_port()
        self.url = server_url(self._server)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)

    def say_ended(self, words: str) -> None:
        """Tell every tab that the drive has ended, and what comes now."""
        for tab in self._live_tabs():
            tab.show_end(words)

    def review(self, log: Path, reviewer: str) -> None:
        """Become the page that reviews the drive's log, now that it is whole; every tab is loaded anew.

        Args:
            log: the drive.mcap.
            reviewer: in whose name verdicts are kept.
        """
        session = ReviewSession({self._title: log}, reviewer)
        session.start()
        tabs = self._live_tabs()
        with self._lock:
            self._session = session
        for tab in tabs:
            run_script(tab.client, "location.reload();")
            tab.client.flush()

    def wait(self) -> None:
        """Wait for ever; Ctrl-C raises KeyboardInterrupt."""
        threading.Event().wait()

    def stop(self) -> None:
        """End it."""
        with self._lock:
            tabs, self._tabs = list(self._tabs.values()), {}
        for tab in tabs:
            tab.close()
        stop_server(self._server)
        if self._session is not None:
            self._session.close()

    def _live_tabs(self) -> list[LiveTab]:
        with self._lock:
            return [tab for tab in self._tabs.values() if isinstance(tab, LiveTab)]

    async def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            if self._session is None:
                self._tabs[client.client_id] = LiveTab(client, self._feed, self._title)
            else:
                self._tabs[client.client_id] = Tab(client, self._session, self._title, self._dark)

    async def _disconnected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            tab = self._tabs.pop(client.client_id, None)
        if tab is not None:
            tab.close()
