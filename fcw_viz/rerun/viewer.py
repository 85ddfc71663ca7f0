"""The rerun viewer as a child process: started, and ended with its own children."""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from fcw.errors import UserError
from fcw_viz.page.guard.guard import HOST
from fcw_viz.rerun.page import RerunPage

FOREIGN_WORDS = (
    "rerun's page is not part of fcw: when opened, it contacts servers of the rerun project on the internet"
)
"""What a person should know before."""
START_TIMEOUT_S = 60.0
"""The program is large: a cold disk takes seconds to read it."""
END_TIMEOUT_S = 5.0
POLL_S = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Viewer:
    """A running viewer.

    Attributes:
        process: its first process, which leads a group of its own.
        url: where a browser finds it; None for a window of its own.
        ticket_url: the same, once, for a browser's command line.
    """

    process: subprocess.Popen[bytes]
    url: str | None = None
    ticket_url: str | None = None


def has_display(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether a window can be opened here."""
    return sys.platform in ("win32", "darwin") or any(
        environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )


@contextmanager
def native_viewer(recording: Path) -> Iterator[Viewer]:
    """The viewer in a window of its own; it ends with the context, or when the window is closed."""
    with _started(["--new", "--bind", HOST, str(recording)]) as (process, _):
        yield Viewer(process)


@contextmanager
def web_viewer(recording: Path, port: int | None = None) -> Iterator[Viewer]:
    """The viewer for a browser, for this user on this machine only; see `fcw_viz.rerun.page`.

    Args:
        recording: the `.rrd` file.
        port: of the page; None takes a free one.

    Raises:
        UserError: the port is taken, or the viewer does not start.
    """
    if port is not None and not _is_free(port):
        raise UserError(f"--port {port}: taken by another program; name another port")
    viewer_port = _free_port()
    # Told to view something that is elsewhere, rerun serves its viewer's files and no data.
    nowhere = f"http://{HOST}:{viewer_port}/nothing.rrd"
    arguments = ["--serve-web", "--bind", HOST, "--web-viewer-port", str(viewer_port), nowhere]
    with _started(arguments) as (process, output):
        _await_port(viewer_port, process, output)
        page = RerunPage(port or 0, recording, viewer_port)
        try:
            yield Viewer(process, page.url, page.ticket_url)
        finally:
            page.close()


@contextmanager
def _started(arguments: list[str]) -> Iterator[tuple[subprocess.Popen[bytes], IO[bytes]]]:
    """rerun's command line in a session of its own: Ctrl-C reaches us alone, and we end the whole group."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(
            [sys.executable, "-m", "fcw_viz.rerun.supervisor", *arguments],
            stdin=subprocess.PIPE,  # by whose end it knows that we are gone, even killed
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=os.environ | {"CI": "1"},  # where rerun sends no usage data
        )
        try:
            yield process, output
        finally:
            if process.stdin is not None:
                process.stdin.close()
            _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and its children; rerun's Python wrapper would leave its child behind."""
    if sys.platform == "win32":
        subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], capture_output=True, check=False)
        process.wait()
        return
    for number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, number)
        except ProcessLookupError:
            break
        if _group_ends(process):
            break
    process.wait()


def _group_ends(process: subprocess.Popen[bytes]) -> bool:
    """Whether the whole group is gone in time, not only the process that leads it."""
    deadline = time.monotonic() + END_TIMEOUT_S
    while time.monotonic() < deadline:
        process.poll()  # a child that has ended but was not waited for still counts as one of the group
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(POLL_S)
    return False


def _await_port(port: int, process: subprocess.Popen[bytes], output: IO[bytes]) -> None:
    deadline = time.monotonic() + START_TIMEOUT_S
    while not _answers(port):
        if process.poll() is not None or time.monotonic() > deadline:
            output.seek(0)
            words = output.read().decode(errors="replace").strip().splitlines()
            raise UserError(f"the rerun viewer did not start: {words[-1] if words else 'no message'}")
        time.sleep(POLL_S)


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex((HOST, port)) == 0


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError:
            return False
        return True


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])
