"""One browser tab of a page: its picture, and the thread in which everything happens, in order."""

import threading
from collections.abc import Callable

import viser

from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.page.link import watch_link
from fcw_viz.page.picture.view import PictureView
from fcw_viz.page.script import install

NOTIFICATION_S = 6.0


class PageTab:
    """The base of all tabs.

    Attributes:
        client: the side of the browser.
        view: the picture of this tab.
    """

    def __init__(self, client: viser.ClientHandle, title: str, image_size: ImageSize) -> None:
        """Make a tab with this title and an empty picture."""
        self.client = client
        self._closed = threading.Event()
        install(client, title)
        watch_link(client)
        self.view = PictureView(client, image_size)

    def close(self) -> None:
        """End the thread of the tab after its browser has left."""
        self._closed.set()
        self.view.close()

    def wait_closed(self) -> None:
        """Wait until a closed tab has finished what it was doing."""
        self.view.wait_closed()

    def run(self, work: Callable[[], object]) -> None:
        """Run something in the thread of this tab, after everything that came before."""
        self.view.run_in_order(self._run, work)

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        """Show a message to the user of this tab."""
        self.client.add_notification(
            title, text, auto_close_seconds=NOTIFICATION_S, color="orange" if trouble else "green"
        )

    def refuse(self, error: UserError) -> None:
        """Show the user of this tab why something was not done."""
        self.notify(str(error), trouble=True)

    def _run(self, work: Callable[[], object]) -> None:
        if self._closed.is_set():
            return
        try:
            work()
        except UserError as error:
            self.refuse(error)
        except Exception:
            self.notify("This failed because of a fault in the program; see its terminal", trouble=True)
            raise
