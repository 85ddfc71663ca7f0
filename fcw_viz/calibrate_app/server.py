"""The page's server: one session for all tabs."""

import threading
from functools import partial
from pathlib import Path

import viser

from fcw.errors import UserError
from fcw.sources import open_source
from fcw.sources.bars import for_pictures, without_bars
from fcw_viz.calibrate_app.proposals.drive_look import DriveLooks
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.calibrate_app.tab import Tab
from fcw_viz.page.guard.guard import bare_address
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.server import DEFAULT_PORT, PageServer, check_port

SMALLEST_PX = 64
"""Of a picture in which anybody can see a road."""
LOOK_S = 1.0
"""How often it is checked whether the saved file is still what was saved."""


class CalibrationPage(PageServer):
    """A running page.

    Attributes:
        session: what its tabs share.
        pictures: of the source.
        looks: at the drive.
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
            UserError: the source cannot be read or has tiny pictures, the work is open in another page, or
                the port is none.
        """
        check_port(port)
        self._source, self._dark = source, dark
        shown, cut = without_bars(open_source(source, topic=topic))
        self.pictures = Pictures(shown)
        size = self.pictures.image_size
        if min(size.width, size.height) < SMALLEST_PX:
            raise UserError(
                f"{source}: its pictures are {size} pixels, too small to click points in; expected at least "
                f"{SMALLEST_PX} both ways"
            )
        self.looks = DriveLooks.at(self.pictures)
        fitted = partial(for_pictures, source=shown)
        notice = "" if cut is None else f"{shown.notes[-1]}."
        self.session = CalibrationSession.open(source, size, save_path, notice, fitted)
        super().__init__(port, f"fcw calibrate · {self.pictures.name}", dark)
        self.session.announce(bare_address(self.port))
        self._stopped = threading.Event()
        self._watch = threading.Thread(target=self._watch_file, name="saved file", daemon=True)
        self._watch.start()

    def open_tab(self, client: viser.ClientHandle) -> Tab:
        """A tab on the session."""
        return Tab(client, self.session, self.pictures, self._source, self._dark, self.looks)

    def stop(self) -> None:
        """End it; what is being typed in a tab is kept."""
        for look in self.looks:
            look.close()
        super().stop()
        self._stopped.set()
        self._watch.join()
        self.session.close()

    def _watch_file(self) -> None:
        while not self._stopped.wait(LOOK_S):
            self.session.look_at_file()
