"""A server of one picture and nothing else, which writes down what the surface reports."""

import contextlib
import io
import threading
from dataclasses import dataclass, field

import numpy as np
import viser
from numpy.typing import NDArray

from fcw.frame import ImageSize
from fcw_viz.page.picture.handle import Handle, Phase
from fcw_viz.page.picture.view import PictureView

SIZE = ImageSize(1280, 720)


@dataclass
class PictureServer:
    """The last tab's surface and what happened on it."""

    picture: NDArray[np.uint8]
    handle_at_px: tuple[float, float] | None = None
    clicks: list[tuple[float, float]] = field(default_factory=list)
    drags: list[tuple[Phase, float, float]] = field(default_factory=list)
    handle_clicks: list[str] = field(default_factory=list)
    view_changes: list[float] = field(default_factory=list)
    callback_threads: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            self.server = viser.ViserServer(host="127.0.0.1", verbose=False)
        self.server.gui.configure_theme(show_logo=False)
        self.url = f"http://127.0.0.1:{self.server.get_port()}"
        self.handle: Handle | None = None
        self._view: PictureView | None = None
        self.server.on_client_connect(self._connected)

    @property
    def view(self) -> PictureView:
        assert self._view is not None
        return self._view

    def stop(self) -> None:
        if self._view is not None:
            self._view.close()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    async def _connected(self, client: viser.ClientHandle) -> None:
        view = self._view = PictureView(client, SIZE)
        view.show(self.picture)
        view.on_click(self._clicked)
        view.on_view_change(lambda: self.view_changes.append(view.pixels_per_screen_pixel))
        if self.handle_at_px is not None:
            self.handle = view.add_handle(
                "mark",
                *self.handle_at_px,
                (255, 180, 0),
                lambda phase, column_px, row_px: self.drags.append((phase, column_px, row_px)),
                lambda: self.handle_clicks.append("mark"),
            )

    def _clicked(self, column_px: float, row_px: float) -> None:
        self.callback_threads.add(threading.current_thread().name)
        self.clicks.append((column_px, row_px))
