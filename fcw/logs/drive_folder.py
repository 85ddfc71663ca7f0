"""The folder that a drive is written to: ours alone, and an earlier drive stays until there is a new one.

What stands there under the names of a drive's files must be no input, and no other program's. The earlier
files wait in a hidden folder beside the new ones until these are whole. They stay there after a kill, and go
away when a later run is whole. When the run fails they come back, and what there is of the failed one is kept
under names that say so.
"""

import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fcw.errors import UserError
from fcw.json_form import object_of_line
from fcw.locked_file import LockedFile
from fcw.logs.names import MCAP_NAME, RRD_NAME, SUMMARY_NAME

NAMES = (MCAP_NAME, RRD_NAME, SUMMARY_NAME)
LOCK_NAME = ".fcw.lock"
EARLIER_PREFIX = ".earlier-"
FAILED_PREFIX = "failed-"
_MOST_SUMMARY_BYTES = 16 << 20


@contextmanager
def drive_folder(out: Path, inputs: Iterable[Path]) -> Iterator[None]:
    """The folder, made, locked and cleared, for the time of a run.

    Args:
        out: the folder.
        inputs: files that the run reads.

    Raises:
        UserError: it cannot be made or written, another run writes to it, or a file in it is an input or no
            drive's.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = LockedFile.open(out / LOCK_NAME)
    except OSError as error:
        raise UserError(
            f"--out {out}: cannot be the folder of the logs ({error.strerror}); name one that can be written"
        ) from error
    if lock is None:
        raise UserError(f"--out {out}: another run is writing to this folder; name another one, or wait")
    try:
        for name in NAMES:
            _check(out, name, inputs)
        earlier = _put_aside(out)
        try:
            yield
        except BaseException:
            if earlier is not None:
                _bring_back(out, earlier)
            raise
        for aside in out.glob(f"{EARLIER_PREFIX}*"):
            _remove(aside)
    finally:
        with suppress(OSError):
            (out / LOCK_NAME).unlink()
        lock.close()


def _check(out: Path, name: str, inputs: Iterable[Path]) -> None:
    path = out / name
    for read in inputs:
        with suppress(OSError):
            if path.samefile(read):
                raise UserError(f"--out {out}: the new {name} would replace {read}; name another folder")
    if path.is_symlink() or not path.exists():
        return
    if not path.is_file() or not _is_ours(path):
        raise UserError(f"--out {out}: the {name} in it is no drive's of this program; name another folder")


def _is_ours(path: Path) -> bool:
    """Whether it may be of an earlier run; other programs call results `summary.json` too."""
    if path.name != SUMMARY_NAME:
        return True
    with path.open("rb") as file:
        found = object_of_line(file.read(_MOST_SUMMARY_BYTES))
    return found is None or "versions" in found


def _put_aside(out: Path) -> Path | None:
    """Where the earlier drive waits; None where there is none. A link is removed, never followed."""
    for name in (*NAMES, "drive.partial.rrd"):
        if (out / name).is_symlink() or name not in NAMES:
            (out / name).unlink(missing_ok=True)
    if not any((out / name).exists() for name in NAMES):
        return None
    earlier = out / f"{EARLIER_PREFIX}{secrets.token_hex(4)}"
    earlier.mkdir(mode=0o700)
    for name in NAMES:
        if (out / name).exists():
            (out / name).rename(earlier / name)
    return earlier


def _bring_back(out: Path, earlier: Path) -> None:
    with suppress(OSError):
        for name in NAMES:
            if (out / name).exists():
                (out / name).replace(out / f"{FAILED_PREFIX}{name}")
        for path in earlier.iterdir():
            path.replace(out / path.name)
        earlier.rmdir()


def _remove(earlier: Path) -> None:
    with suppress(OSError):
        for path in earlier.iterdir():
            path.unlink()
        earlier.rmdir()
