"""The page's server: one session for all tabs, on this machine only."""

import threading
from pathlib import Path

import viser

from fcw.sources import open_source
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.calibrate_app.tab import Tab
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.server import DEFAULT_PORT, check_port, server_url, start_server, stop_server


class CalibrationPage:
    """A running page.

    Attributes:
        session: what its tabs share.
        pictures: of the source.
        url: where it is.
        port: the one it got.
    """

    def __init__(
        self,
        source: Path,
        save_path: Path,
        port: int = DEFAULT_PORT,
        dark: bool = False,
        topic: str | None = None,
    ) -> None:
        """Open the source (of an MCAP file the topic's pictures) and the work so far, and serve them.

        Raises:
            UserError: the source cannot be read, the work is open in another page, or the port is none.
        """
        check_port(port)
        self._source = source
        self.pictures = Pictures(open_source(source, topic=topic))
        self.session = CalibrationSession.open(source, self.pictures.image_size, save_path)
        self._tabs: dict[int, Tab] = {}
        self._server = start_server(port, f"fcw calibrate · {self.pictures.name}", dark)
        self._dark = dark
        self.port = self._server.get_port()
        self.url = server_url(self._server)
        self.session.announce(self.url)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)

    def stop(self) -> None:
        """End it; what is being typed in a tab is kept."""
        for client_id in list(self._tabs):
            self._tabs.pop(client_id).close()
        stop_server(self._server)
        self.session.close()

    def wait(self) -> None:
        """Wait for ever; Ctrl-C raises KeyboardInterrupt."""
        threading.Event().wait()

    async def _connected(self, client: viser.ClientHandle) -> None:
        self._tabs[client.client_id] = Tab(client, self.session, self.pictures, self._source, self._dark)

    async def _disconnected(self, client: viser.ClientHandle) -> None:
        tab = self._tabs.pop(client.client_id, None)
        if tab is not None:
            tab.close()
