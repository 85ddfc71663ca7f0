"""Small files, whole: regular ones only, since a pipe could block, and no larger than a stated limit."""

import os
import stat
from pathlib import Path

MOST_TEXT_BYTES = 16 << 20
"""Of a table: ten hours of speeds, ten a second, are 7 MB."""


class MalformedError(ValueError):
    """What is in a file cannot be taken as what it should be; the text says why, in a few words."""


def read_bytes(path: Path, most: int) -> bytes:
    """All of a file.

    Raises:
        OSError: it is not there, or cannot be read.
        MalformedError: it is no regular file, or larger than `most` bytes.
    """
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as file:
        facts = os.fstat(descriptor)
        if not stat.S_ISREG(facts.st_mode):
            raise MalformedError("not a regular file")
        data = file.read(most + 1)
    if len(data) > most:
        raise MalformedError(f"larger than {_size(most)}")
    return data


def read_text(path: Path, most: int = MOST_TEXT_BYTES) -> str:
    """All of a text file in UTF-8, with or without a byte order mark.

    Raises:
        OSError: it is not there, or cannot be read.
        MalformedError: it is no regular file, too large, or not UTF-8.
    """
    try:
        return read_bytes(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise MalformedError(f"not UTF-8 at byte {error.start}") from error


def _size(count: int) -> str:
    return f"{count >> 20} MB" if count >= 1 << 20 else f"{count >> 10} kB"
