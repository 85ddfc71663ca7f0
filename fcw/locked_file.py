"""A file that only grows, that one process has to itself, and that never holds half of what was added."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Self

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

LOCKED_BYTE = 1 << 40
"""Windows locks bytes of a file, even beyond its end, and nobody else can read them: one far away."""


class LockedFile:
    """An open file, locked for this process until it is closed or the process ends. Not thread-safe."""

    def __init__(self, descriptor: int) -> None:
        """Use `open`."""
        self._descriptor: int | None = descriptor
        self._size = os.fstat(descriptor).st_size

    @classmethod
    def open(cls, path: Path) -> Self | None:
        """Open a file for appending, made where it is not there, and lock it.

        Returns:
            None where another process, or another place in this one, has locked it.

        Raises:
            OSError: it cannot be opened or made.
        """
        while True:
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
            descriptor = os.open(path, flags, 0o644)
            if not _lock(descriptor):
                os.close(descriptor)
                return None
            # Whoever had it may have removed the file between our opening and our locking it.
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), path.stat()):
                    return cls(descriptor)
            os.close(descriptor)

    @property
    def closed(self) -> bool:
        """Whether it is."""
        return self._descriptor is None

    def cut(self, size: int) -> None:
        """Keep only the first bytes: what a kill or a full disk left after them goes away.

        Raises:
            OSError: it cannot be written.
        """
        self._size = size
        self._restore()

    def append(self, data: bytes) -> None:
        """Add bytes; they are on the disk when this returns.

        Raises:
            OSError: they cannot be written; the file is as it was before.
        """
        try:
            self._restore()
            _write_all(self._open_descriptor, data)
            os.fsync(self._open_descriptor)
        except OSError:
            with suppress(OSError):
                self._restore()
            raise
        self._size += len(data)

    def close(self) -> None:
        """Let go of the file."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def remove(self, path: Path) -> None:
        """Let go of the file, which is at `path`, and remove it; where that is refused it stays."""
        if sys.platform == "win32":
            self.close()  # an open file cannot be removed; one that somebody else opened meanwhile neither
        with suppress(OSError):
            path.unlink()
        self.close()

    @property
    def _open_descriptor(self) -> int:
        if self._descriptor is None:
            raise ValueError("the file is closed")
        return self._descriptor

    def _restore(self) -> None:
        """Cut off what a failed write left behind."""
        if os.fstat(self._open_descriptor).st_size != self._size:
            os.ftruncate(self._open_descriptor, self._size)


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
        # A file system without locks; two processes on one file are then not noticed.
        return True
    return True


def _write_all(descriptor: int, data: bytes) -> None:
    while data:
        data = data[os.write(descriptor, data) :]
