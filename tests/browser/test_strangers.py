"""Another web page in the same Chromium, and the page's own after a reload and a restart."""

import threading
from collections.abc import Callable, Generator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
import viser
from calibrate_helpers import OpenPage, copy_of_demo_drive
from playwright.sync_api import Browser

from fcw.camera.file import default_path
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.console import SILENT

TRY = """async ([url, version]) => {
  const told = {};
  try { told.page = (await fetch(url)).status; } catch { told.page = "refused"; }
  told.socket = await new Promise((resolve) => {
    const socket = new WebSocket(url.replace("http:", "ws:"), [version]);
    socket.onopen = () => resolve("open");
    socket.onerror = () => resolve("refused");
  });
  const frame = document.createElement("iframe");
  frame.src = url;
  document.body.append(frame);
  await new Promise((resolve) => (frame.onload = resolve));
  return told;
}"""
"""What a stranger's page can try, even one that has learnt the address."""


@pytest.fixture
def strangers_page() -> Generator[str]:
    """Another server on this machine, whose page has another origin."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><body>hello")

        def log_message(self, format: str, *args: object) -> None: ...  # noqa: A002

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


def test_a_strangers_page_reads_and_opens_nothing(
    chromium: Browser, strangers_page: str, serve: Callable[[Path], CalibrationPage], drive_copy: Path
):
    page = serve(drive_copy)
    tab = chromium.new_page()
    try:
        tab.goto(strangers_page)
        told = tab.evaluate(TRY, [page.url, f"viser-v{viser.__version__}"])
        assert told == {"page": "refused", "socket": "refused"}
        assert "Viser client" not in tab.frames[1].content()  # it may not be framed
    finally:
        tab.close()


def test_a_name_that_was_made_to_point_here_gets_nothing(
    chromium: Browser, serve: Callable[[Path], CalibrationPage], drive_copy: Path
):
    """DNS rebinding."""
    page = serve(drive_copy)
    tab = chromium.new_page()
    try:
        # Chromium takes every name below localhost for this machine, and sends it as the Host.
        answer = tab.goto(page.url.replace("127.0.0.1", "attacker.localhost"))
        assert answer is not None
        assert answer.status == 403
    finally:
        tab.close()


def test_the_own_page_goes_on_after_a_reload_and_a_restart(
    open_page: OpenPage, serve: Callable[[Path], CalibrationPage], drive_copy: Path
):
    page = serve(drive_copy)
    person = open_page(page.url)
    person.page.reload()
    person.wait_until_ready()
    page.stop()
    again = CalibrationPage(drive_copy, default_path(drive_copy), page.port)
    try:
        assert again.url == page.url
        person.page.reload()
        person.wait_until_ready()
    finally:
        again.stop()


def test_a_browser_that_is_started_shows_its_ticket_and_goes_on_to_the_page(
    chromium: Browser,
    serve: Callable[[Path], CalibrationPage],
    drive_copy: Path,
    monkeypatch: pytest.MonkeyPatch,
):
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    page = serve(drive_copy)
    page.announce(SILENT, "calibrate", "words", browser=True)
    tab = chromium.new_page()
    try:
        tab.goto(opened[0])
        assert tab.url.split("?")[0] == f"{page.url}/"  # viser adds where its socket is, sooner or later
    finally:
        tab.close()


@pytest.fixture
def drive_copy(tmp_path: Path) -> Path:
    return copy_of_demo_drive(tmp_path)
