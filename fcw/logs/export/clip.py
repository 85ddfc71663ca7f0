"""The drives to export, and the part of each."""

import itertools
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import VideoPacket
from fcw.logs.drive_folder import EARLIER_PREFIX
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import FAILED_MCAP_NAME, MCAP_NAME
from fcw.logs.records import FrameResult
from fcw.units import NS_PER_S

LONGEST_S = 1e9
"""Thirty years; their nanoseconds still fit into 64 bits."""

Between = tuple[float, float]
"""A range in seconds from the first frame of the drive, including both ends."""


@dataclass(frozen=True, slots=True, eq=False)
class DriveClip:
    """A drive, or the frames in a time range of it.

    Attributes:
        name: name of the drive in files and rows.
        log: its log.
        first_ns: time of the first frame of the drive, from which seconds count, also in a range.
        times_ns: (N,) int64 times of the frames of the clip, at least one.
    """

    name: str
    log: DriveLog
    first_ns: int
    times_ns: NDArray[np.int64]

    @classmethod
    def open(cls, path: Path, name: str = "", between: Between | None = None) -> "DriveClip":
        """Open a drive, or a range of it.

        Args:
            path: its log.
            name: its name; by default that of its folder.
            between: the range; None for the whole drive.

        Raises:
            UserError: the file is not a drive log, or there is no frame in it or in the range.
        """
        log = DriveLog(path)
        times_ns = log.series().time_ns
        if not len(times_ns):
            raise UserError(f"{path}: the log holds no frame; there is nothing to export")
        first_ns = int(times_ns[0])
        if between is not None:
            since_ns = times_ns - first_ns
            start_ns, end_ns = (round(second * NS_PER_S) for second in between)
            last_s = since_ns[-1] / NS_PER_S
            times_ns = times_ns[(since_ns >= start_ns) & (since_ns <= end_ns)]
            if not len(times_ns):
                raise UserError(
                    f"--between {between[0]:g} {between[1]:g}: {path} has no frame there; "
                    f"its frames are from 0 to {last_s:.2f} s"
                )
        return cls(name or _names(path.resolve())[0], log, first_ns, times_ns)

    def results(self) -> Iterator[FrameResult]:
        """The results of the frames in order."""
        return self.log.results(int(self.times_ns[0]), int(self.times_ns[-1]) + 1)

    def entries(self) -> Iterator[tuple[FrameResult, tuple[VideoPacket, ...]]]:
        """The results of the frames with their video packets, which need not start at a keyframe."""
        return self.log.entries(int(self.times_ns[0]), int(self.times_ns[-1]) + 1)

    def time_s(self, time_ns: int) -> float:
        """Seconds from the drive's first frame."""
        return (time_ns - self.first_ns) / NS_PER_S


def check_between(between: Between) -> None:
    """Check a range.

    Raises:
        UserError: it ends before it starts, or its numbers are negative or not finite.
    """
    start_s, end_s = between
    if not 0 <= start_s <= end_s <= LONGEST_S:
        raise UserError(
            f"--between {start_s:g} {end_s:g}: expected two times in seconds from the drive's first frame, "
            f"the earlier one first, at most {LONGEST_S:g}"
        )


def find_drives(paths: Sequence[Path]) -> dict[str, Path]:
    """Find the drive logs under some paths, each once, and give them unique names.

    Args:
        paths: drive logs, folders with a `drive.mcap`, and folders of such folders.

    Returns:
        Logs by name. The name is that of the folder, or of the file if that is not called `drive.mcap`. Equal
        names get the folders above as a prefix or, if that does not help, a number as a suffix.

    Raises:
        UserError: a path does not exist, or is a folder without any drive.
    """
    logs = list(dict.fromkeys(log for path in paths for log in _logs(path)))
    paths_of = [_names(log) for log in logs]
    different, deepest = len(set(map(tuple, paths_of))), max(map(len, paths_of), default=0)
    depth = 1
    names = [path[0] for path in paths_of]
    while len(set(names)) < different and depth < deepest:
        depth += 1
        counts = Counter(names)
        names = [
            "-".join(reversed(path[:depth])) if counts[name] > 1 else name
            for name, path in zip(names, paths_of, strict=True)
        ]
    named: dict[str, Path] = {}
    for name, log in zip(names, logs, strict=True):  # monday.mcap beside monday/drive.mcap
        numbered = (f"{name}-{number}" for number in itertools.count(2))
        named[next(one for one in itertools.chain((name,), numbered) if one not in named)] = log
    return named


def _logs(path: Path) -> list[Path]:
    """The resolved paths of the logs under a path."""
    if not path.exists():
        raise UserError(f"{path}: no such file or folder; expected a drive.mcap of `fcw run`, or its folder")
    if not path.is_dir():
        return [path.resolve()]
    own = path / MCAP_NAME
    if own.is_file():
        return [own.resolve()]
    # Pages look for new drives every second: `rglob`, and resolving each path, would take ten times as long.
    # A run keeps the earlier drive in a hidden folder until its own is whole.
    below = (
        Path(folder, MCAP_NAME)
        for folder, _, files in os.walk(path.resolve())
        if MCAP_NAME in files and not Path(folder).name.startswith(EARLIER_PREFIX)
    )
    # A link may lead nowhere, or to itself.
    logs = sorted(log.resolve() if log.is_symlink() else log for log in below if log.exists())
    if not logs:
        failed = path / FAILED_MCAP_NAME
        raise UserError(
            f"{path}: no {MCAP_NAME} in this folder or below it; name a drive's log, "
            + (f"such as {failed} of a run that failed, " if failed.is_file() else "")
            + "or the folder that `fcw run` wrote"
        )
    return logs


def _names(log: Path) -> list[str]:
    """Names of a log, whose path is resolved, and of the folders above it, the nearest first.

    Bytes that are not UTF-8 are escaped, so that every table and page can be written.
    """
    parts = list(log.parent.parts[1:]) or ["drive"]
    own = [] if log.name == MCAP_NAME else [log.stem]
    return [name.encode("utf-8", "backslashreplace").decode() for name in (*own, *parts[::-1])]
