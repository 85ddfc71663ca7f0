"""`fcw review --rerun` with a real process: it serves on loopback only, and Ctrl-C leaves nothing behind."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from http import HTTPStatus
from pathlib import Path
from urllib.parse import unquote

import cv2
import pytest
from running.programs import start_program
from strangers.bare_client import get

from fcw.sources import open_source
from fcw_viz.cli import main
from fcw_viz.rerun.viewer import has_display

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and process groups are POSIX's")
DEMO = Path(__file__).parents[2] / "recordings" / "demo"
PATIENCE_S = 120


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the logs of three pictures."""
    folder = tmp_path_factory.mktemp("drive")
    pictures = folder / "pictures"
    pictures.mkdir()
    for frame in open_source(DEMO / "drive.mp4").frames():
        if frame.index == 3:
            break
        cv2.imwrite(str(pictures / f"{frame.index}.jpg"), frame.image)
    arguments = ["run", str(pictures), "--frame-rate", "30", "--out", str(folder / "out")]
    assert main([*arguments, "--calibration", str(DEMO / "drive.calibration.yaml")]) == 0
    return folder / "out"


def start(path: Path, *more: str) -> subprocess.Popen[str]:
    environment = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}
    environment["PYTHONUNBUFFERED"] = "1"
    return start_program("review", path, "--rerun", "--no-open", *more, env=environment)


def address(process: subprocess.Popen[str]) -> tuple[str, int]:
    """The URL it says, and its port."""
    assert process.stdout is not None
    for line in process.stdout:
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\S+/\?url=\S+", line)
        if found:
            return found[0], int(found[1])
    raise AssertionError(process.communicate()[1])


def descendants(root: int) -> list[int]:
    """Processes below one, at any depth."""
    table = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    pairs = [tuple(map(int, line.split())) for line in table.splitlines()]
    found, queue = [], [root]
    while queue:
        parent = queue.pop()
        children = [pid for pid, above in pairs if above == parent]
        found += children
        queue += children
    return found


def alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and waits to be taken note of does not."""
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return bool(state.stdout.strip()) and not state.stdout.startswith("Z")


def listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def end(process: subprocess.Popen[str], number: signal.Signals) -> None:
    os.kill(process.pid, number)
    process.communicate(timeout=PATIENCE_S)


def listening_addresses(port: int) -> set[str]:
    """Where a port is listened on, as the kernel tells it: hexadecimal, in the machine's byte order."""
    rows = [
        line.split()
        for table in ("tcp", "tcp6")
        for line in Path("/proc/net", table).read_text().splitlines()[1:]
    ]
    return {row[1].split(":")[0] for row in rows if row[3] == "0A" and int(row[1].split(":")[1], 16) == port}


LOOPBACK = f"{int.from_bytes(socket.inet_aton('127.0.0.1'), sys.byteorder):08X}"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ps") is None, reason="needs ps")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_the_viewer_is_served_to_this_computer_and_ends_with_all_its_children(
    drive: Path, number: signal.Signals
) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        named_port = probe.getsockname()[1]
    process = start(drive, "--port", str(named_port))
    url, page_port = address(process)
    assert page_port == named_port
    status, _, page = get(url)
    assert status == 200
    assert b"rerun" in page.lower()
    recording = unquote(url.partition("?url=")[2])
    assert get(recording)[2] == (drive / "drive.rrd").read_bytes()
    for stranger in (
        {"Host": "attacker.example"},
        {"Origin": "https://evil.example"},
        {"path": "/drive.rrd"},
        {"path": "/"},
    ):
        assert get(recording, **stranger)[0] == HTTPStatus.FORBIDDEN
    if Path("/proc/net/tcp").exists():
        assert listening_addresses(page_port) == {LOOPBACK}
    children = descendants(process.pid)
    assert len(children) >= 2  # rerun's wrapper, and the viewer below it
    end(process, number)
    assert process.returncode == (-number if number is signal.SIGKILL else 0)
    deadline = time.monotonic() + PATIENCE_S
    while any(map(alive, children)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(alive, children))
    assert not listens(page_port)


@pytest.mark.slow
def test_a_drive_without_a_recording_is_shown_from_its_log(drive: Path, tmp_path: Path) -> None:
    shutil.copy(drive / "drive.mcap", tmp_path)
    process = start(tmp_path / "drive.mcap")
    try:
        _, page_port = address(process)
        assert listens(page_port)
    finally:
        end(process, signal.SIGINT)
    assert [path.name for path in tmp_path.iterdir()] == ["drive.mcap"]


def test_a_port_that_is_taken_is_named(drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["review", str(drive), "--rerun", "--no-open", "--port", str(port)]) == 2
    assert f"--port {port}: taken" in capsys.readouterr().err


def test_no_drive_is_the_users_mistake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["review", str(tmp_path), "--rerun"]) == 2
    assert "not a drive; expected a folder written by `fcw run`" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="there is always a display elsewhere")
def test_a_display_is_one_of_x_or_of_wayland() -> None:
    assert not has_display({})
    assert not has_display({"DISPLAY": ""})
    assert has_display({"DISPLAY": ":0"})
    assert has_display({"WAYLAND_DISPLAY": "wayland-0"})
