"""viser's server behind the guard.

viser serves its page and its web socket from one `websockets` server, and has no hook for either: what it
starts that server with is wrapped while it starts.
"""

import asyncio
import contextlib
import http
import io
import logging
import sys
import threading
import traceback
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import rich
import viser
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import WebSocketException
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from fcw_viz.console_text import printable
from fcw_viz.page.first import with_first
from fcw_viz.page.guard.guard import (
    HOST,
    LARGEST_MESSAGE_BYTES,
    MOST_CLIENTS,
    SAFE_HEADERS,
    Guard,
    Redirected,
    Refused,
)
from fcw_viz.page.guard.loops_event import wake_in_loop
from fcw_viz.page.guard.messages import ForeignMessageError, passes

Handler = Callable[[ServerConnection], Awaitable[None]]
Answer = Callable[[ServerConnection, Request], Response | None]

_starting = threading.Lock()
_FOREIGN = CloseCode.POLICY_VIOLATION, "not a message of this page"
_NOT_OURS = ("opening handshake failed", "connection rejected", "unexpected internal error", "socket.send() ")
"""What `websockets` and asyncio log, with tracebacks, of connections that are none of a page's."""
_OUR_PROTOCOL = f"viser-v{viser.__version__}"


def guarded_viser_server(
    port: int, guard: Guard, first: Callable[[str], str] = lambda query: ""
) -> viser.ViserServer:
    """A server on this machine's loopback that answers whom the guard admits.

    Args:
        port: the next free one where it is taken.
        guard: who that is.
        first: what the page shows before viser's script has started, by the query of its address; empty for
            nothing.
    """
    door = _Door(guard, first)
    with _starting, _wrapped(door) as wrapped, quiet():
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    door.server = server
    if not wrapped.is_set():  # another viser, that starts its server in another way
        server.stop()
        raise RuntimeError(f"viser {viser.__version__} cannot be guarded")
    server.on_client_connect(wake_in_loop)
    return server


def close_client(client: viser.ClientHandle, why: str) -> None:
    """Speak no longer with a tab that sent what its page does not, and say so in one line."""
    server = client._viser_server._websock_server
    connection, loop = server._live_connections.get(client.client_id), server._background_event_loop
    if connection is not None and loop is not None:
        _say(why)
        asyncio.run_coroutine_threadsafe(connection.close(*_FOREIGN), loop)


def where(error: Exception) -> str:
    """What an error says, and where it was raised: all of a traceback that fits in a line."""
    ours = [frame for frame in traceback.extract_tb(error.__traceback__) if "fcw_viz" in frame.filename]
    place = f" in {ours[-1].name}, {Path(ours[-1].filename).name}:{ours[-1].lineno}" if ours else ""
    return f"{type(error).__name__} {error!s:.60}{place}"


def _say(why: str) -> None:
    sys.stderr.write(f"fcw: closed a connection that sent what no page does ({printable(why)})\n")


def quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """viser greets on standard output in its own words; the command has its own."""
    return contextlib.redirect_stdout(io.StringIO())


@contextmanager
def quiet_end() -> Iterator[None]:
    """viser says goodbye on rich's own console: when its server has ended, or when the program exits.

    Where a second Ctrl-C interrupts the first end, the second one comes, and is quiet too.
    """
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    yield
    console.quiet = before


@contextmanager
def _wrapped(door: "_Door") -> Iterator[threading.Event]:
    """viser's call of `serve` gets the door; the event tells that it was called."""
    serve, wrapped = websockets.asyncio.server.serve, threading.Event()

    def guarded_serve(
        handler: Handler, host: str, port: int, *, process_request: Answer, **options: object
    ) -> websockets.asyncio.server.serve:
        wrapped.set()
        door.open(handler, process_request)
        options["max_size"] = LARGEST_MESSAGE_BYTES
        options["create_connection"] = door.connection
        options["logger"] = _logger()
        return serve(door.handle, host, port, process_request=door.answer, **options)  # pyright: ignore

    websockets.asyncio.server.serve = guarded_serve  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield wrapped
    finally:
        websockets.asyncio.server.serve = serve


class _Door:
    """Lets in whom the guard admits; in the server's event loop alone."""

    def __init__(self, guard: Guard, first: Callable[[str], str]) -> None:
        self.server: viser.ViserServer | None = None
        self._guard, self._first = guard, first
        self._clients = 0

    def open(self, handler: Handler, answer: Answer) -> None:
        """From now on viser's own functions speak with those who are let in."""
        self._handler, self._answer = handler, answer

    def connection(self, *arguments: Any, **options: Any) -> ServerConnection:  # noqa: ANN401 - as `websockets` calls it
        """A connection that gives viser nothing but a page's messages."""
        return _Connection(self, *arguments, **options)

    def client_of(self, connection: ServerConnection) -> viser.ClientHandle | None:
        """The tab at the other end; None before it has shown its camera."""
        if self.server is None:
            return None
        for client_id, live in self.server._websock_server._live_connections.items():
            if live is connection:
                return self.server.get_clients().get(client_id)
        return None

    async def handle(self, connection: ServerConnection) -> None:
        if connection.subprotocol != _OUR_PROTOCOL:  # viser would print what the client says of itself
            await connection.close(CloseCode.PROTOCOL_ERROR, "another version of the page; reload it")
            return
        self._clients += 1
        try:
            await self._handler(connection)
        finally:
            self._clients -= 1

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        web_socket = "upgrade" in request.headers
        verdict = self._guard.judge(request.path, _one(request.headers), web_socket)
        if isinstance(verdict, Refused):
            return connection.respond(verdict.status, f"fcw: {verdict.words}\n")
        if isinstance(verdict, Redirected):
            response = connection.respond(http.HTTPStatus.SEE_OTHER, "")
            response.headers["Location"] = verdict.location
        elif web_socket and self._clients >= MOST_CLIENTS:
            words = f"fcw: {MOST_CLIENTS} tabs are open already; close one\n"
            return connection.respond(http.HTTPStatus.SERVICE_UNAVAILABLE, words)
        else:
            try:
                response = self._answer(connection, replace(request, path=verdict.path))
            except OSError:  # a name that no file can have
                response = connection.respond(http.HTTPStatus.NOT_FOUND, "fcw: there is no such page\n")
            place, _, query = verdict.path.partition("?")
            if response is not None and place == "/" and (html := self._first(query)):
                with_first(response, html)
        if response is not None:
            response.headers.update(SAFE_HEADERS)
            response.headers["Cache-Control"] = "no-store"
        return response


class _Connection(ServerConnection):
    """Closes itself to who sends what no page of ours does."""

    def __init__(self, door: _Door, *arguments: Any, **options: Any) -> None:  # noqa: ANN401 - see `_Door.connection`
        super().__init__(*arguments, **options)
        self._door = door

    async def recv(self, decode: bool | None = None) -> Any:  # noqa: ANN401 - text or bytes, as it came
        while True:
            raw = await super().recv(decode)
            try:
                if passes(raw, lambda: self._door.client_of(self)):
                    return raw
            except ForeignMessageError as error:
                _say(str(error))
                await self.close(*_FOREIGN)


def _logger() -> logging.Logger:
    """`websockets`' own, without what others than pages get wrong."""
    for name in ("asyncio", "fcw.page"):
        logging.getLogger(name).addFilter(_is_ours)  # the same one is not added twice
    return logging.getLogger("fcw.page")


def _is_ours(record: logging.LogRecord) -> bool:
    error = record.exc_info[1] if record.exc_info else None
    return not (record.getMessage().startswith(_NOT_OURS) or isinstance(error, WebSocketException))


def _one(headers: Headers) -> Callable[[str], str | None]:
    """A header by its name; one that was sent twice is none of ours."""

    def header(name: str) -> str | None:
        values = headers.get_all(name)
        return None if not values else ", ".join(values)

    return header
