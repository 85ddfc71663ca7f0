"""A client of a page that is no browser: the requests and web sockets that anybody's program can send."""

import asyncio
import contextlib
import http.client
import re
import socket
import threading
from collections.abc import Coroutine
from typing import TypeVar
from urllib.parse import urlsplit

import msgspec.msgpack
import viser
import zstandard
from websockets.asyncio.client import ClientConnection as AsyncioConnection
from websockets.asyncio.client import connect as asyncio_connect
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

T = TypeVar("T")

PATIENCE_S = 60
PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 1.0),
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a browser says first; viser then counts it as a client."""


def get(url: str, path: str | None = None, **headers: str) -> tuple[int, http.client.HTTPMessage, bytes]:
    """Status, headers and body of the answer to a GET; `path` in the place of the URL's."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.netloc, timeout=PATIENCE_S)
    try:
        default = f"{parts.path}?{parts.query}" if parts.query else parts.path
        connection.request("GET", default if path is None else path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()
    finally:
        connection.close()


def open_socket(url: str, origin: str | None = None, host: str | None = None) -> ClientConnection:
    """The page's web socket, as the page opens it unless another origin or host is said ("" for none)."""
    parts = urlsplit(url)
    own = f"http://{parts.netloc}" if origin is None else origin
    return connect(
        f"ws://{host or parts.netloc}{parts.path}",
        sock=socket.create_connection((parts.hostname or "", parts.port or 0), PATIENCE_S),
        origin=Origin(own) if own else None,
        subprotocols=[PROTOCOL],
        open_timeout=PATIENCE_S,
        ping_interval=None,
        max_size=None,
        proxy=None,
    )


def ready(field: str) -> bytes:
    """What the page's channel says first, through its hidden field (see `fcw_viz.page.channel`)."""
    update = {"type": "GuiUpdateMessage", "uuid": field, "updates": {"value": "1 ready:"}}
    return msgspec.msgpack.encode(update)


def unpacked(data: str | bytes) -> bytes:
    """What the server sends, unpacked: a header of two sizes, and zstd."""
    assert isinstance(data, bytes)
    size, compressed = (int.from_bytes(data[at : at + 8], "little") for at in (0, 8))
    return zstandard.decompress(data[16 : 16 + compressed], max_output_size=size)


def _fields(data: str | bytes) -> list[str]:
    """Hidden fields of channels in what the server sends."""
    return [found.decode() for found in re.findall(rb'const uuid = "([^"]+)"', unpacked(data))]


class Tabs:
    """Tabs without browsers: web sockets that say that they are there, and read all that they are sent."""

    def __init__(self, url: str, count: int) -> None:
        """Open so many at once."""
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self._readers = self._await(self._open(url, count))

    def close(self) -> None:
        """Close all of them at once."""
        self._await(self._close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _await(self, work: Coroutine[None, None, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE_S)

    async def _open(self, url: str, count: int) -> list[asyncio.Task[None]]:
        camera = msgspec.msgpack.encode(CAMERA)
        parts = urlsplit(url)
        readers: list[asyncio.Task[None]] = []
        for _ in range(count):
            tab = await asyncio_connect(
                f"ws://{parts.netloc}{parts.path}",
                origin=Origin(f"http://{parts.netloc}"),
                subprotocols=[PROTOCOL],
                open_timeout=PATIENCE_S,
                max_size=None,
                proxy=None,
            )
            await tab.send(camera)
            readers.append(asyncio.create_task(self._read(tab)))
        return readers

    async def _read(self, tab: AsyncioConnection) -> None:
        with contextlib.suppress(ConnectionClosed, asyncio.CancelledError):
            while True:
                for field in _fields(await tab.recv()):
                    await tab.send(ready(field))
        tab.transport.abort()

    async def _close(self) -> None:
        for reader in self._readers:
            reader.cancel()
        await asyncio.gather(*self._readers)
