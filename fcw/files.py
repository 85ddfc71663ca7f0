"""Files that are whole or not there."""

import errno
import os
import secrets
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from fcw.errors import UserError

CALIBRATION = "calibration", (b"fcw_calibration_version",)
"""Kind and mark, for `check_kind`, of the file that two commands replace without being told to."""
OTHER_FOLDER = "name a folder that can be made and written to"
MARK_BYTES = 1 << 16
"""Where a file says of what kind it is; comments may stand before."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A partial name beside `path` to write to; it becomes `path` at the end, or goes away on failure.

    The partial name keeps the suffix, by which some writers tell the format; nobody can guess it, and put a
    link there before.

    Raises:
        UserError: the file cannot be written there, or what is there is no file.
    """
    with whole_files([path]) as (partial,):
        yield partial


@contextmanager
def whole_files(paths: Sequence[Path]) -> Iterator[tuple[Path, ...]]:
    """As `whole_file`, for files that belong together: they get their names together, at the end.

    Raises:
        UserError: one of them cannot be written there, or what is there is no file.
    """
    for path in paths:
        check_replaceable(path)
    partials = tuple(
        path.with_name(f".{path.stem[:40]}.{secrets.token_hex(8)}.partial{path.suffix}") for path in paths
    )
    try:
        yield partials
        for partial, path in zip(partials, paths, strict=True):
            partial.replace(path)
    except BaseException as error:
        for partial in partials:
            with suppress(OSError):
                partial.unlink()
        if isinstance(error, OSError):
            names, what = ", ".join(map(str, paths)), "this file" if len(paths) == 1 else "these files"
            raise not_written(f"{names}: cannot write {what}", error) from error
        raise


def not_written(
    what: str, error: OSError, mend: str = "name a file in a folder that exists and can be written"
) -> UserError:
    """The error that says what could not be done, why, and what to do: room on the disk, or another place."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        mend = "make room on the disk"
    elif error.errno == errno.EFBIG:
        mend = "allow larger files (ulimit -f)"
    reason = os.strerror(error.errno) if error.errno else str(error)  # Arrow has words of its own
    return UserError(f"{what} ({reason}); {mend}")


def make_folder(path: Path) -> None:
    """Make a folder, with those above it, where it is not there.

    Raises:
        UserError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(f"{path}: cannot make this folder", error, OTHER_FOLDER) from error


def check_replaceable(path: Path) -> None:
    """See that a file may take this name: a device or a pipe would be lost, `/dev/null` for all programs.

    Raises:
        UserError: a device, a pipe or a folder has it.
    """
    if path.exists() and not path.is_file():
        raise UserError(f"{path}: this is no file, but a device, a pipe or a folder; name a file")


def is_same_file(one: Path, other: Path) -> bool:
    """Whether two paths name one file, by whatever link; False where either is not there."""
    try:
        return one.samefile(other)
    except OSError:
        return False


def check_kind(path: Path, what: str, marks: Sequence[bytes]) -> None:
    """See that a file that is there, and not empty, may be replaced by one of a kind: it is of that kind too.

    Args:
        path: of the file.
        what: the kind, in words.
        marks: of which one stands near the start of every such file.

    Raises:
        UserError: it is of another kind.
    """
    if path.is_file() and path.stat().st_size and not is_kind(path, marks):
        raise UserError(f"{path}: is there already, and is no {what}; name another file, or move it away")


def is_kind(path: Path, marks: Sequence[bytes]) -> bool:
    """Whether a file is there and has one of these marks near its start."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        start = file.read(MARK_BYTES)
    return any(mark in start for mark in marks)


def check_place(path: Path, option: str = "") -> None:
    """See before long work that its result can be written there.

    Args:
        path: of the file.
        option: that names another place; for a path that nobody named.

    Raises:
        UserError: its folder does not exist or cannot be written to, or what is there is no file.
    """
    check_replaceable(path)
    if not os.access(path.parent, os.W_OK):
        reason = "it cannot be written to" if path.parent.is_dir() else "there is no such folder"
        mend = f"name another folder{f' with {option}' if option else ''}"
        raise UserError(f"{path}: cannot write this file into {path.parent}, {reason}; {mend}")


def write_whole(path: Path, text: str) -> None:
    """Write a text file, whole or not at all.

    Raises:
        UserError: the file cannot be written there.
    """
    with whole_file(path) as partial:
        partial.write_bytes(text.encode())  # line ends as they are: Windows would make two characters of them
