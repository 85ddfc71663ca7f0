"""What threads draw on a page while its loop sends: neither is disturbed by the other."""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import msgspec.msgpack
import viser
from strangers.bare_client import CAMERA, PATIENCE_S, open_socket, unpacked

from fcw.frame import ImageSize
from fcw_viz.page.server import PageServer
from fcw_viz.page.tab import PageTab

FIRST_PORT = 18960


class LoopsWaiters(deque[Any]):
    """Those who wait for an event, as its loop may change them at any time: no other thread gets through."""

    def __iter__(self) -> Iterator[Any]:
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            raise RuntimeError("deque mutated during iteration") from None
        return super().__iter__()


class DrawnPage(PageServer):
    """A page on which the test's own thread draws."""

    def __init__(self) -> None:
        self.client: viser.ClientHandle | None = None
        self.has_come = threading.Event()
        super().__init__(FIRST_PORT, "drawn", dark=False)

    def open_tab(self, client: viser.ClientHandle) -> PageTab:
        tab = PageTab(client, "drawn", ImageSize(64, 48))
        self.client = client
        self.has_come.set()
        return tab


def test_a_thread_draws_while_the_loop_changes_who_waits_for_it():
    page = DrawnPage()
    try:
        with open_socket(page.url) as tab:
            tab.send(msgspec.msgpack.encode(CAMERA))
            assert page.has_come.wait(PATIENCE_S)
            assert page.client is not None
            event = page.client._websock_connection.get_message_buffer().message_event
            ends_s = time.monotonic() + PATIENCE_S
            while event.is_set() or not event._waiters:  # all that came before is sent
                assert time.monotonic() < ends_s
                time.sleep(0.01)
            event._waiters = LoopsWaiters(event._waiters)
            page.client.gui.add_markdown("drawn by a thread")
            while b"drawn by a thread" not in unpacked(tab.recv(PATIENCE_S)):
                pass
    finally:
        page.stop()
