"""What threads draw on a page while its loop sends: neither is disturbed by the other."""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import msgspec.msgpack
import pytest
import viser
from strangers.bare_client import CAMERA, PATIENCE_S, open_socket, unpacked

from fcw.frame import ImageSize
from fcw_viz.page.server import PageServer
from fcw_viz.page.tab import PageTab

FIRST_PORT = 18960
LONG_DRAWING_S = 1.0
"""Longer than a page takes to end."""


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


def test_the_page_ends_once_a_tab_that_has_gone_has_drawn_what_it_was_drawing(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
):
    page = DrawnPage()
    is_drawing, loop_has_ended, is_drawn = threading.Event(), threading.Event(), threading.Event()
    with open_socket(page.url) as socket:
        socket.send(msgspec.msgpack.encode(CAMERA))
        assert page.has_come.wait(PATIENCE_S)
        (tab,) = page.tabs
        words = tab.client.gui.add_text("words", "before")

        @words.on_update
        async def _(_: object) -> None: ...

        def draw() -> None:
            is_drawing.set()
            loop_has_ended.wait(LONG_DRAWING_S)
            words.value = "after"
            is_drawn.set()

        tab.run(draw)
        assert is_drawing.wait(PATIENCE_S)
    ends_s = time.monotonic() + PATIENCE_S
    while page.tabs:
        assert time.monotonic() < ends_s
        time.sleep(0.01)
    end = page._server.stop
    monkeypatch.setattr(page._server, "stop", lambda: (end(), loop_has_ended.set()))
    page.stop()
    assert is_drawn.is_set()
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]
