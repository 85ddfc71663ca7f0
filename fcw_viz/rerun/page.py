"""The page of rerun's web viewer behind the guard: the viewer's files, and one recording, for one person.

rerun's own server would give the recording to everybody on this machine. Here it serves the viewer's files
alone, which are no secret; the recording comes from this server, where the viewer in the browser reads it.
"""

import os
import shutil
import threading
import urllib.error
import urllib.request
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socket import socket
from urllib.parse import quote

from fcw_viz.page.guard.guard import HOST, SAFE_HEADERS, Guard, Redirected, Refused

RECORDING_PATH = "/drive.rrd"
MOST_REQUESTS = 64
"""At once; the viewer has a handful of files."""
SILENCE_S = 60.0
"""A client that says or takes nothing for so long is left."""
_PASSED_ON = ("Content-Type", "Content-Length", "Content-Encoding", "rerun-final-length")
"""Headers of the viewer's files."""
_STAYS_HERE = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": f"{SAFE_HEADERS['Content-Security-Policy']}; connect-src 'self'",
}
"""rerun's viewer tells its makers what it is used for; from this page it cannot."""
_WITHOUT_PROXY = urllib.request.build_opener(urllib.request.ProxyHandler({}))


class RerunPage(ThreadingHTTPServer):
    """A running page."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, port: int, recording: Path, viewer_port: int) -> None:
        """Serve from now on.

        Args:
            port: of the page.
            recording: the `.rrd` file.
            viewer_port: where rerun serves its viewer's files.

        Raises:
            OSError: the port is taken.
        """
        super().__init__((HOST, port), _Handler)
        self.guard = Guard()
        self.recording, self.viewer = recording, f"http://{HOST}:{viewer_port}"
        self._free = threading.BoundedSemaphore(MOST_REQUESTS)
        threading.Thread(target=self.serve_forever, name="rerun page", daemon=True).start()

    @property
    def url(self) -> str:
        """Where a browser finds it."""
        recording = quote(self.guard.url(self.server_port) + RECORDING_PATH, safe="")
        return f"{self.guard.url(self.server_port)}/?url={recording}"

    @property
    def ticket_url(self) -> str:
        """An address that leads there once, within a minute: other users see a browser's command line."""
        return self.guard.ticket_url(self.server_port)

    def close(self) -> None:
        """End it."""
        self.shutdown()
        self.server_close()

    def verify_request(self, request: object, client_address: object) -> bool:
        """Whether there is room for one more."""
        return self._free.acquire(blocking=False)

    def process_request_thread(self, request: socket | tuple[bytes, socket], client_address: object) -> None:
        """One less, once it is answered."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: object, client_address: object) -> None:
        """Nothing: the browser has left."""


class _Handler(BaseHTTPRequestHandler):
    timeout = SILENCE_S

    @property
    def _page(self) -> RerunPage:
        assert isinstance(self.server, RerunPage)
        return self.server

    def do_GET(self) -> None:
        verdict = self._page.guard.judge(self.path, self._header, web_socket=False)
        if isinstance(verdict, Refused):
            self._say(verdict.status, f"fcw: {verdict.words}\n".encode())
        elif isinstance(verdict, Redirected):
            self._say(HTTPStatus.SEE_OTHER, b"", {"Location": self._page.url})
        elif verdict.path == RECORDING_PATH:
            self._send_recording()
        else:
            self._send_of_viewer(verdict.path.partition("?")[0])

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the base class's name
        """Nothing: the terminal is the person's."""

    def _send_recording(self) -> None:
        with self._page.recording.open("rb") as recording:
            size = os.fstat(recording.fileno()).st_size
            kind = {"Content-Type": "application/octet-stream", "Content-Length": str(size)}
            self._begin(HTTPStatus.OK, kind)
            shutil.copyfileobj(recording, self.wfile)

    def _send_of_viewer(self, path: str) -> None:
        try:
            with _WITHOUT_PROXY.open(self._page.viewer + path, timeout=SILENCE_S) as file:
                passed_on = {name: file.headers[name] for name in _PASSED_ON if name in file.headers}
                self._begin(HTTPStatus.OK, passed_on)
                shutil.copyfileobj(file, self.wfile)
        except urllib.error.HTTPError as error:
            self._say(HTTPStatus(error.code), b"")

    def _say(self, status: HTTPStatus, words: bytes, headers: Mapping[str, str] | None = None) -> None:
        plain = {"Content-Type": "text/plain", "Content-Length": str(len(words))}
        self._begin(status, {**plain, **(headers or {})})
        self.wfile.write(words)

    def _begin(self, status: HTTPStatus, headers: Mapping[str, str]) -> None:
        self.send_response(status)
        for name, value in {**headers, **SAFE_HEADERS, **_STAYS_HERE}.items():
            self.send_header(name, value)
        self.end_headers()

    def _header(self, name: str) -> str | None:
        values = self.headers.get_all(name)
        return None if not values else ", ".join(values)
