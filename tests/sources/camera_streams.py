"""Cameras on the network, as far as tests can have them: HTTP on this machine."""

import threading
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

WAIT_S = 120.0
AHEAD = 3
"""Pictures on their way at most; FFmpeg wants to see as many before it gives the first."""


def as_jpeg(image: NDArray[np.uint8]) -> bytes:
    """As a camera sends it."""
    return cv2.imencode(".jpg", image)[1].tobytes()


class StreamServer:
    """Serves `/camera.mjpg` as cameras do, JPEG after JPEG; and `/file`, a recording.

    Attributes:
        taken: to be released for each picture taken; the stream goes on then.
    """

    def __init__(self, images: Sequence[NDArray[np.uint8] | bytes], file: Path | None = None) -> None:
        self.taken = threading.Semaphore()
        server = self
        jpegs = [image if isinstance(image, bytes) else as_jpeg(image) for image in images]

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                if self.path == "/file":
                    assert file is not None
                    data = file.read_bytes()
                    self.send_header("Content-Type", "video/mp4")
                    self.send_header("Content-Length", str(len(data)))
                    self.end_headers()
                    self._send(data)
                    return
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
                self.end_headers()
                taken = server.taken = threading.Semaphore(AHEAD)  # of this connection alone
                for jpeg in jpegs:
                    if not taken.acquire(timeout=WAIT_S):
                        return
                    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                    if not self._send(head.encode() + jpeg + b"\r\n"):
                        return

            def _send(self, data: bytes) -> bool:
                try:
                    self.wfile.write(data)
                except OSError:  # who listened is gone
                    return False
                return True

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}"

    def close(self) -> None:
        """End it."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
