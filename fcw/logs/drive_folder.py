"""The folder that a drive is written to: ours alone, and an earlier drive stays until there is a new one.

What stands there under the names of a drive's files must be no input, and no other program's: our files say
in their first bytes that they are ours, also those that a killed run left. The earlier files wait in a hidden
folder beside the new ones until these are whole. They stay there after a kill, and go away when a later run
is whole. When the run fails they come back, and what there is of the failed one is kept under names that say
so.
"""

import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fcw.errors import UserError
from fcw.files import is_same_file
from fcw.json_form import object_of_line
from fcw.locked_file import LockedFile
from fcw.logs.names import FAILED_MCAP_NAME, FAILED_PREFIX, MCAP_NAME, RRD_NAME, SUMMARY_NAME

NAMES = (MCAP_NAME, RRD_NAME, SUMMARY_NAME)
LOCK_NAME = ".fcw.lock"
PARTIAL_RRD_NAME = "drive.partial.rrd"
"""The recording until it is whole, which the application writes."""
EARLIER_PREFIX = ".earlier-"
_TOUCHED = (*NAMES, PARTIAL_RRD_NAME, *(f"{FAILED_PREFIX}{name}" for name in NAMES))
"""What a run replaces, moves or removes in the folder, besides its lock."""
_EARLIER_BYTES = 4
_MARKS = {".mcap": (b"\x89MCAP", b"\0fcw "), ".rrd": (b"RRF", b"\x03fcw")}
"""How our logs begin, and what stands in their first bytes: the end of a string's length, and the writing
program (MCAP's library, rerun's application)."""
_MARK_BYTES = 256
_MOST_SUMMARY_BYTES = 16 << 20


class FolderBusyError(UserError):
    """Another run is writing to the folder."""


@contextmanager
def drive_folder(out: Path, inputs: Iterable[Path]) -> Iterator[None]:
    """The folder, made, locked and cleared, for the time of a run.

    Args:
        out: the folder.
        inputs: files that the run reads; none of them is touched.

    Raises:
        FolderBusyError: another run writes to it.
        UserError: it cannot be made or written, or a file in it is an input or no drive's.
    """
    inputs = list(inputs)
    try:
        out.mkdir(parents=True, exist_ok=True)
        _check(out, LOCK_NAME, inputs)
        lock = LockedFile.open(out / LOCK_NAME)
    except OSError as error:
        raise UserError(
            f"--out {out}: cannot be the folder of the logs ({error.strerror}); name one that can be written"
        ) from error
    if lock is None:
        raise FolderBusyError(
            f"--out {out}: another run is writing to this folder; name another one, or wait"
        )
    try:
        for name in _TOUCHED:
            _check(out, name, inputs)
        earlier = _put_aside(out)
        try:
            yield
        except BaseException as error:
            kept = _name_failed(out)
            again = earlier is not None and _bring_back(out, earlier)
            if not kept or not isinstance(error, UserError):
                raise
            told = f"what was written of this drive is {out / FAILED_MCAP_NAME}"
            if again:
                told += f", and {out / MCAP_NAME} is the earlier one again"
            raise UserError(f"{error}; {told}") from error
        for aside in out.glob(f"{EARLIER_PREFIX}{'[0-9a-f]' * 2 * _EARLIER_BYTES}"):
            _remove(aside, inputs)
    finally:
        lock.remove(out / LOCK_NAME)


def _check(out: Path, name: str, inputs: Iterable[Path]) -> None:
    path = out / name
    for read in inputs:
        if is_same_file(path, read):
            raise UserError(f"--out {out}: the new {name} would replace {read}; name another folder")
    if path.is_symlink() or not path.exists():
        return
    if not path.is_file() or not _is_ours(path):
        raise UserError(f"--out {out}: the {name} in it is no drive's of this program; name another folder")


def _is_ours(path: Path) -> bool:
    """Whether it is of an earlier run, however that ended; other programs give files such names too."""
    with path.open("rb") as file:
        start = file.read(_MARK_BYTES)
        if not start:  # as a run leaves it that is killed at its start
            return True
        if path.suffix == ".json":
            summary = object_of_line(start + file.read(_MOST_SUMMARY_BYTES)) or {}
            versions = summary.get("versions")
            return isinstance(versions, dict) and "fcw" in versions
    magic, mark = _MARKS.get(path.suffix, (None, b""))
    return magic is not None and start.startswith(magic) and mark in start


def _put_aside(out: Path) -> Path | None:
    """Where the earlier drive waits; None where there is none. A link is removed, never followed."""
    for name in (*NAMES, PARTIAL_RRD_NAME):
        if (out / name).is_symlink() or name not in NAMES:
            (out / name).unlink(missing_ok=True)
    if not any((out / name).exists() for name in NAMES):
        return None
    earlier = out / f"{EARLIER_PREFIX}{secrets.token_hex(_EARLIER_BYTES)}"
    earlier.mkdir(mode=0o700)
    for name in NAMES:
        if (out / name).exists():
            (out / name).rename(earlier / name)
    return earlier


def _name_failed(out: Path) -> bool:
    """Whether a log of the failed run is kept, under its new name."""
    kept = False
    with suppress(OSError):
        # Its writer failed; the log has all that it has, and the disk may be full.
        (out / PARTIAL_RRD_NAME).unlink(missing_ok=True)
        for name in NAMES:
            if (out / name).exists():
                (out / name).replace(out / f"{FAILED_PREFIX}{name}")
                kept |= name == MCAP_NAME
    return kept


def _bring_back(out: Path, earlier: Path) -> bool:
    """Whether the earlier drive is there again."""
    with suppress(OSError):
        for path in earlier.iterdir():
            path.replace(out / path.name)
        earlier.rmdir()
        return True
    return False


def _remove(earlier: Path, inputs: Iterable[Path]) -> None:
    """An earlier drive, where it is one."""
    if earlier.is_symlink():
        return
    with suppress(OSError):
        for path in [earlier / name for name in NAMES]:
            if path.is_file() and _is_ours(path) and not any(is_same_file(path, read) for read in inputs):
                path.unlink()
        earlier.rmdir()
