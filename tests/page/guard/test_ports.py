"""Ports of the pages."""

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from fcw.errors import UserError
from fcw_viz.cli import main
from fcw_viz.page.server import _free_port


@pytest.mark.parametrize("port", ["0", "-1", "65536"])
@pytest.mark.parametrize("command", ["review", "calibrate"])
def test_a_port_that_is_none_is_the_users_mistake(command: str, port: str, tmp_path: Path, capsys):
    log = Path(__file__).parents[3] / "recordings" / "demo" / "drive.mp4"
    drive = tmp_path / "drive.mcap"
    drive.touch()
    source = drive if command == "review" else log
    assert main([command, str(source), "--no-open", "--port", port]) == 2
    assert f"--port {port}: expected a number from 1 to 65535" in capsys.readouterr().err


def test_no_port_is_tried_beyond_the_last_one():
    with socket.socket() as last:
        last.bind(("127.0.0.1", 65535))
        last.listen()
        with pytest.raises(UserError, match="--port 65535: neither this port nor one after it is free"):
            _free_port(65535)


# In a process of its own, as viser ends its server when the program exits.
INTERRUPTED_TWICE = """
from contextlib import suppress
from fcw_viz.page import server
from fcw_viz.signals import Interrupted

class Page(server.PageServer):
    def open_tab(self, client):
        raise AssertionError

def again():
    raise Interrupted

page = Page(8470, "", False)
page._server.stop = again
with suppress(KeyboardInterrupt):
    page.stop()
"""


def test_who_interrupts_the_end_of_a_page_hears_nothing_of_its_server():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED_TWICE], capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
