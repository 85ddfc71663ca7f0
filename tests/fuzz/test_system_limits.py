"""Too few files or too little memory: one message, at once."""

import subprocess
import sys

import pytest

resource = pytest.importorskip("resource", reason="limits of a process are POSIX's")


@pytest.mark.parametrize(
    ("kind", "amount", "message"),
    [
        ("RLIMIT_NOFILE", 12, "12 files open (ulimit -n), expected at least 64"),
        ("RLIMIT_AS", 400 << 20, "400 MB of memory (ulimit -v), expected at least 3000 MB"),
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
