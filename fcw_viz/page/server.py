"""viser's server with the program's manners: on this machine only, quiet, and at the next free port."""

import contextlib
import io
import warnings

import viser

from fcw.errors import UserError

HOST = "127.0.0.1"
DEFAULT_PORT = 8080
LAST_PORT = 65535


def start_server(port: int, label: str, dark: bool) -> viser.ViserServer:
    """A server at `port`, or at the next free one after it, which `get_port` tells.

    Args:
        port: wished for.
        label: over the panels.
        dark: colours at the beginning.

    Raises:
        UserError: the port is none.
    """
    check_port(port)
    # A tab that is closed while it plays or draws is nothing to tell anybody.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    with _viser_quiet():
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    server.gui.set_panel_label(label)
    set_colours(server.gui, dark)
    return server


def check_port(port: int) -> None:
    """Before anything else is opened.

    Raises:
        UserError: it is none.
    """
    if not 1 <= port <= LAST_PORT:
        raise UserError(f"--port {port}: expected a number from 1 to {LAST_PORT}")


def stop_server(server: viser.ViserServer) -> None:
    """End it."""
    with _viser_quiet():
        server.stop()


def server_url(server: viser.ViserServer) -> str:
    """Where it is."""
    return f"http://{HOST}:{server.get_port()}"


def set_colours(gui: viser.GuiApi, dark: bool) -> None:
    """Dark or light, and none of viser's own advertising."""
    gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=dark)


def _viser_quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """viser greets and says goodbye on standard output in its own words; the command has its own."""
    return contextlib.redirect_stdout(io.StringIO())
