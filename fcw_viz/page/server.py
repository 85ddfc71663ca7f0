"""The server of a page: for its own user only, quiet, and on the next free port."""

import socket
import threading
import time
import warnings
import weakref
import webbrowser
from abc import ABC, abstractmethod

import viser
from rich.console import Console

from fcw.errors import UserError
from fcw_viz.page.guard.guard import HOST, Guard
from fcw_viz.page.guard.viser_server import guarded_viser_server, quiet_end
from fcw_viz.page.link import say_goodbye
from fcw_viz.page.style import set_colours
from fcw_viz.page.tab import PageTab
from fcw_viz.page.tidying import Tidying

DEFAULT_PORT = 8080
LAST_PORT = 65535
GOODBYE = "The program has ended. Start it again, and this page reconnects."
GOODBYE_S = 1.0
"""At its end the program waits at most so long until every page has received the message."""


class PageServer(ABC):
    """A page while it is served; each connected browser has a tab.

    Attributes:
        url: its address, with the secret that admits a browser (see `fcw_viz.page.guard`).
        port: its port.
        goodbye: what every page shows after the end.
        runs_drive: whether a drive is run beside the page, whose pictures must come and go quickly.
    """

    goodbye = GOODBYE
    runs_drive = False

    def __init__(self, port: int, label: str, dark: bool) -> None:
        """Start serving; everything that `open_tab` needs must exist already.

        Args:
            port: preferred port; the next free one is used if it is taken.
            label: the label above the panels.
            dark: whether the page starts in dark colours.

        Raises:
            UserError: the port is not valid, or neither it nor a later one is free.
        """
        check_port(port)
        self._wished_port = port
        self._tabs: dict[int, PageTab] = {}
        self._ever_open: weakref.WeakSet[PageTab] = weakref.WeakSet()
        self._lock = threading.Lock()
        # A tab that is closed while it plays or draws need not be reported.
        warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
        self._tidying = Tidying()
        if not self.runs_drive:
            self._tidying.give_pictures_back()
        self._guard = Guard()
        self._server = guarded_viser_server(_free_port(port), self._guard, self.first_html)
        self._server.gui.set_panel_label(label)
        set_colours(self._server.gui, dark)
        self.port = self._server.get_port()
        self.url = self._guard.url(self.port)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)

    @abstractmethod
    def open_tab(self, client: viser.ClientHandle) -> PageTab:
        """Make the tab of a browser that has connected."""

    def first_html(self, query: str) -> str:
        """What a page shows before viser's script has started, see `fcw_viz.page.first`; may be empty.

        Args:
            query: query part of the page's address.
        """
        del query
        return ""

    @property
    def tabs(self) -> tuple[PageTab, ...]:
        """The open tabs."""
        with self._lock:
            return tuple(self._tabs.values())

    def announce(self, console: Console, title: str, words: str, browser: bool) -> None:
        """Print the address of the page, and open it.

        Args:
            console: where it is printed.
            title: what the page is for.
            words: what else the user should know.
            browser: whether to open a browser.
        """
        if self.port != self._wished_port:
            console.print(
                f"port {self._wished_port} is taken, this is the next free one: {self.port}", soft_wrap=True
            )
        console.print(f"{title} at {self.url} ({words})", soft_wrap=True)
        if browser:
            webbrowser.open(self._guard.ticket_url(self.port))

    def wait(self) -> None:
        """Wait for ever; Ctrl-C raises KeyboardInterrupt."""
        while True:
            time.sleep(3600)  # a second Ctrl-C in the locks of `threading` would end in their own error

    def stop(self) -> None:
        """Show the end on every page, close the tabs and end the server."""
        with quiet_end():
            for tab in self.tabs:
                say_goodbye(tab.client, self.goodbye)
            end_s = time.monotonic() + GOODBYE_S
            while self.tabs and time.monotonic() < end_s:
                time.sleep(0.01)
            with self._lock:
                tabs, self._tabs = self._tabs, {}
                ever_open = tuple(self._ever_open)
            for tab in tabs.values():
                tab.close()
            # What a tab is doing needs the server, even if its browser is already gone.
            for tab in ever_open:
                tab.wait_closed()
            self._server.stop()
            self._tidying.stop()

    async def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            tab = self._tabs[client.client_id] = self.open_tab(client)
            self._ever_open.add(tab)
        # A browser that left before its tab was made does not report it again.
        if client.client_id not in self._server._websock_server._live_connections:
            await self._disconnected(client)

    async def _disconnected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            tab = self._tabs.pop(client.client_id, None)
        if tab is not None:
            tab.close()
            self._tidying.tell()


def check_port(port: int) -> None:
    """Check the number of a port, before anything else is opened.

    Raises:
        UserError: it is not a port number.
    """
    if not 1 <= port <= LAST_PORT:
        raise UserError(f"--port {port}: expected a number from 1 to {LAST_PORT}")


def _free_port(wished: int) -> int:
    """The next free port; viser would wait for ever if there is none."""
    for port in range(wished, LAST_PORT + 1):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((HOST, port))
            except OSError:
                continue
            return port
    raise UserError(f"--port {wished}: neither this port nor one after it is free; name a lower one")
