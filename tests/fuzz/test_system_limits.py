"""Too few files or too little memory: one message, at once."""

import subprocess
import sys
import threading

import pytest

from fcw.threads import available_cores
from fcw_viz import cli
from fcw_viz.commands.run.options import RunCommand

LEAST_MB = 4000 + 200 * available_cores()

resource = pytest.importorskip("resource", reason="limits of a process are POSIX's")


@pytest.mark.parametrize(
    ("kind", "amount", "message"),
    [
        ("RLIMIT_NOFILE", 12, "12 files open (ulimit -n), expected at least 64"),
        ("RLIMIT_AS", 400 << 20, f"400 MB of memory (ulimit -v), expected at least {LEAST_MB} MB"),
        ("RLIMIT_AS", 4000 << 20, f"4000 MB of memory (ulimit -v), expected at least {LEAST_MB} MB"),
    ],
)
def test_a_limit_that_is_too_low_is_named_with_its_mend(kind: str, amount: int, message: str):
    limit = getattr(resource, kind)
    ended = subprocess.run(
        [sys.executable, "-m", "fcw_viz", "run", "drive.mp4"],
        preexec_fn=lambda: resource.setrlimit(limit, (amount, amount)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 2
    assert message in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
    assert ended.stdout == ""


def test_a_thread_that_cannot_be_started_is_one_message(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def refused(_thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setitem(cli.RUNNERS, RunCommand, lambda _command: threading.Thread().start())
    monkeypatch.setattr(threading.Thread, "start", refused)
    assert cli.main(["run", "drive.mp4"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("fcw: the system cannot start more threads")
