"""Whether a log that was opened is still that log: it may go on, be written anew, or be deleted."""

from enum import Enum, auto

from fcw.logs.mcap.reader import DriveLog

_TAIL_BYTES = 64
_Stamp = tuple[int, int, int]


class LogChange(Enum):
    """What became of a log since it was opened."""

    NONE = auto()
    GROWN = auto()
    REPLACED = auto()
    GONE = auto()

    @property
    def is_other(self) -> bool:
        """Whether what was opened is not there any more."""
        return self in (LogChange.REPLACED, LogChange.GONE)


class LogWatch:
    """Looks after the file of one open log, whose writer may be at work."""

    def __init__(self, log: DriveLog) -> None:
        """What is there now is the log."""
        self._log = log
        self._stamp = self._look()
        self._tail = b"" if log.complete else self._known_tail()

    def look(self) -> LogChange:
        """What became of it; of a log that was replaced or is gone nothing may be read any more."""
        stamp = self._look()
        if stamp is None:
            return LogChange.GONE
        if stamp == self._stamp:
            return LogChange.NONE
        if self._log.complete or self._stamp is None or stamp[0] != self._stamp[0]:
            return LogChange.REPLACED
        # `fcw run` into the same folder writes the same file from its beginning on.
        return LogChange.GROWN if self._known_tail() == self._tail else LogChange.REPLACED

    def _look(self) -> _Stamp | None:
        try:
            state = self._log.path.stat()
        except OSError:
            return None
        return state.st_ino, state.st_size, state.st_mtime_ns

    def _known_tail(self) -> bytes:
        """The end of what was read of a log that is being written: its times and checksums are no other's."""
        try:
            with self._log.path.open("rb") as file:
                file.seek(max(self._log.chunks.whole_bytes - _TAIL_BYTES, 0))
                return file.read(_TAIL_BYTES)
        except OSError:
            return b""
