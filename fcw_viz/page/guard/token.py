"""The secret in the address of this user's pages.

It is kept in a private file, so that a page that is loaded anew, or whose program was started again, goes on
at the same address. Without such a file (no home, a disk that cannot be written) it holds as long as the
program runs. To have another one, delete the file.
"""

import os
import re
import secrets
import stat
import sys
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path

FILE_NAME = "page-token"
TOKEN_BYTES = 32
_TOKEN = re.compile(rb"[A-Za-z0-9_-]{43}")  # of so many bytes, in URL-safe base64
_OTHERS = 0o077


@cache
def page_token() -> str:
    """The token of this user's pages."""
    token = secrets.token_urlsafe(TOKEN_BYTES)
    try:
        path = state_folder() / FILE_NAME
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        return _read(path) or _keep(path, token)
    except (OSError, RuntimeError):  # Path.home raises RuntimeError for somebody without a home
        return token


def state_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Where programs keep what they know of a user from one run to the next (XDG Base Directory 0.8)."""
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_STATE_HOME"
    base = environment.get(variable, "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".local" / "state") / "fcw"


def _read(path: Path) -> str | None:
    """The token in a file that is ours, and that nobody else can read; None where there is none."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        descriptor = os.open(path, flags)
    except OSError:
        return None
    try:
        facts = os.fstat(descriptor)
        if not stat.S_ISREG(facts.st_mode):
            return None
        if sys.platform != "win32" and (facts.st_uid != os.getuid() or facts.st_mode & _OTHERS):
            return None
        text = os.read(descriptor, 2 * TOKEN_BYTES)
    finally:
        os.close(descriptor)
    return text.decode("ascii") if _TOKEN.fullmatch(text) else None


def _keep(path: Path, token: str) -> str:
    """Write the token to a private file; where another program was quicker its token holds."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f"{FILE_NAME}-")
    partial = Path(name)
    try:
        with os.fdopen(descriptor, "w") as file:
            file.write(token)
        try:
            os.link(partial, path)  # unlike a renaming it fails where there is one
        except FileExistsError:
            if theirs := _read(path):
                return theirs
            partial.replace(path)  # damaged, or others could read it
    finally:
        with suppress(OSError):
            partial.unlink()
    return token
