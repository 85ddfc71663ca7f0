"""One browser tab of a page: its picture, and the thread in which all of it happens, in order."""

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
    """What every tab of every page is.

    Attributes:
        client: the browser's side.
        view: the picture of this tab.
    """

    def __init__(self, client: viser.ClientHandle, title: str, image_size: ImageSize) -> None:
        """A tab with that title, and nothing on its picture yet."""
        self.client = client
        self._closed = threading.Event()
        install(client, title)
        watch_link(client)
        self.view = PictureView(client, image_size)

    def close(self) -> None:
        """The tab is gone."""
        self._closed.set()
        self.view.close()

    def wait_closed(self) -> None:
        """Wait until what a closed tab was doing is done."""
        self.view.wait_closed()

    def run(self, work: Callable[[], object]) -> None:
        """Do something in this tab's thread, after everything that came before."""
        self.view.run_in_order(self._run, work)

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        """Tell the person of this tab something."""
        self.client.add_notification(
            title, text, auto_close_seconds=NOTIFICATION_S, color="orange" if trouble else "green"
        )

    def refuse(self, error: UserError) -> None:
        """Tell the person of this tab why something was not done."""
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
