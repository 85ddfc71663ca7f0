"""A file that one process has to itself."""

import os
import sys
from contextlib import suppress
from pathlib import Path

from fcw.errors import UserError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

LOCKED_BYTE = 1 << 40
"""Windows locks bytes of a file, even beyond its end, and nobody else can read them: one far away."""


def open_locked(path: Path) -> int | None:
    """Open a file for appending, made where it is not there, and lock it until it is closed.

    Returns:
        Its descriptor; None where another process, or another place in this one, has locked it.

    Raises:
        UserError: it cannot be opened or made.
    """
    while True:
        try:
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
            descriptor = os.open(path, flags, 0o644)
        except OSError as error:
            raise UserError(
                f"{path}: cannot keep your work there ({error.strerror}); "
                "name a calibration file in a folder that can be written with `--save FILE`"
            ) from error
        if not _lock(descriptor):
            os.close(descriptor)
            return None
        # Whoever had it may have removed the file between our opening and our locking it.
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        os.close(descriptor)


def _lock(descriptor: int) -> bool:
    """Whether the file is ours alone; the system lets go of it when the process ends, however it ends."""
    try:
        if sys.platform == "win32":
            os.lseek(descriptor, LOCKED_BYTE, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        # A file system without locks; two pages on one journal are then not noticed.
        return True
    return True
