"""The page's server: one session for all tabs, on this machine only."""

import contextlib
import io
import threading
import warnings
from pathlib import Path

import viser

from fcw.errors import UserError
from fcw.sources import open_source
from fcw_viz.calibrate_app.page_panel import set_colours
from fcw_viz.calibrate_app.pictures import Pictures
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.calibrate_app.tab import Tab

HOST = "127.0.0.1"
DEFAULT_PORT = 8080
LAST_PORT = 65535


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
        if not 1 <= port <= LAST_PORT:
            raise UserError(f"--port {port}: expected a number from 1 to {LAST_PORT}")
        self._source = source
        self.pictures = Pictures(open_source(source, topic=topic))
        self.session = CalibrationSession.open(source, self.pictures.image_size, save_path)
        self._tabs: dict[int, Tab] = {}
        # A tab that is closed while it plays or draws is nothing to tell anybody.
        warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
        with _viser_quiet():
            self._server = viser.ViserServer(host=HOST, port=port, verbose=False)
        self.port = self._server.get_port()
        self.url = f"http://{HOST}:{self.port}"
        self.session.announce(self.url)
        self._server.gui.set_panel_label(f"fcw calibrate · {self.pictures.name}")
        self._dark = dark
        set_colours(self._server.gui, dark)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)

    def stop(self) -> None:
        """End it; what is being typed in a tab is kept."""
        for client_id in list(self._tabs):
            self._tabs.pop(client_id).close()
        with _viser_quiet():
            self._server.stop()
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


def _viser_quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """viser greets and says goodbye on standard output in its own words; the command has its own."""
    return contextlib.redirect_stdout(io.StringIO())
