"""Cameras on the network, as far as tests can have them: HTTP on this machine."""

import threading
import time
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

PERIOD_S = 0.04


class StreamServer:
    """Serves `/camera.mjpg` as cameras do, JPEG after JPEG as they are taken; and `/file`, a recording.

    Attributes:
        sent_s: when each picture was sent, on the monotonic clock.
    """

    def __init__(self, images: Sequence[NDArray[np.uint8]], file: Path | None = None) -> None:
        self.sent_s: list[float] = []
        server = self
        jpegs = [cv2.imencode(".jpg", image)[1].tobytes() for image in images]

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
                server.sent_s = []
                for jpeg in jpegs:
                    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                    server.sent_s.append(time.monotonic())
                    if not self._send(head.encode() + jpeg + b"\r\n"):
                        return
                    time.sleep(PERIOD_S)

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
