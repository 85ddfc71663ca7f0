"""viser's server behind the guard.

viser serves its page and its web socket from one `websockets` server, and has no hook for either: what it
starts that server with is wrapped while it starts.
"""

import contextlib
import http
import io
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import viser
import websockets.asyncio.server
from viser._messages import ShareUrlRequest
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

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

Handler = Callable[[ServerConnection], Awaitable[None]]
Answer = Callable[[ServerConnection, Request], Response | None]

_starting = threading.Lock()


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
    with _starting, _wrapped(guard, first) as wrapped, quiet():
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    if not wrapped.is_set():  # another viser, that starts its server in another way
        server.stop()
        raise RuntimeError(f"viser {viser.__version__} cannot be guarded")
    # Whoever asks for it would have viser open a tunnel, by which anybody on the internet could come.
    server._websock_server.unregister_handler(ShareUrlRequest)
    return server


def quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """viser greets and says goodbye on standard output in its own words; the command has its own."""
    return contextlib.redirect_stdout(io.StringIO())


@contextmanager
def _wrapped(guard: Guard, first: Callable[[str], str]) -> Iterator[threading.Event]:
    """viser's call of `serve` gets the guard; the event tells that it was called."""
    serve, wrapped = websockets.asyncio.server.serve, threading.Event()

    def guarded_serve(
        handler: Handler, host: str, port: int, *, process_request: Answer, **options: object
    ) -> websockets.asyncio.server.serve:
        wrapped.set()
        door = _Door(guard, handler, process_request, first)
        options["max_size"] = LARGEST_MESSAGE_BYTES
        return serve(door.handle, host, port, process_request=door.answer, **options)  # pyright: ignore

    websockets.asyncio.server.serve = guarded_serve  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield wrapped
    finally:
        websockets.asyncio.server.serve = serve


class _Door:
    """Lets in whom the guard admits; in the server's event loop alone."""

    def __init__(self, guard: Guard, handler: Handler, answer: Answer, first: Callable[[str], str]) -> None:
        self._guard, self._handler, self._answer, self._first = guard, handler, answer, first
        self._clients = 0

    async def handle(self, connection: ServerConnection) -> None:
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
            response = self._answer(connection, replace(request, path=verdict.path))
            place, _, query = verdict.path.partition("?")
            if response is not None and place == "/" and (html := self._first(query)):
                with_first(response, html)
        if response is not None:
            response.headers.update(SAFE_HEADERS)
            response.headers["Cache-Control"] = "no-store"
        return response


def _one(headers: Headers) -> Callable[[str], str | None]:
    """A header by its name; one that was sent twice is none of ours."""

    def header(name: str) -> str | None:
        values = headers.get_all(name)
        return None if not values else ", ".join(values)

    return header
