"""`fcw` as a program of its own."""

import subprocess
import sys
from typing import Any


def start_program(*arguments: object, **options: Any) -> "subprocess.Popen[str]":
    """`fcw` with these arguments, in a session of its own: a signal must reach it alone."""
    return subprocess.Popen(
        [sys.executable, "-m", "fcw_viz.cli", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **options,
    )


def serve_page(*arguments: object) -> tuple["subprocess.Popen[str]", str]:
    """The program of a page, and the address that it says."""
    process = start_program(*arguments)
    assert process.stdout is not None
    for line in process.stdout:
        if "http://" in line:
            return process, line[line.index("http://") :].split()[0]
    raise AssertionError(f"no address: {process.communicate()[1]}")
