"""Stores what people say about a drive: one file for each person beside the log, which never changes.

`drive.review.<person>.jsonl` has one entry on each line, after a first line that names the format and the
log. Lines are only added, and are on the disk before they count, so that a killed program loses nothing. The
files of all people beside a log are read; copying somebody's file there merges the reviews.
"""

import hashlib
import json
import re
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from fcw.annotation.records import SAID_TYPES, Entry, Said, TakenBack
from fcw.annotation.review import Review, fold
from fcw.bounded.files import MalformedError, read_bytes
from fcw.bounded.formats import json_value
from fcw.camera.file import calibration_text
from fcw.errors import UserError
from fcw.json_form import from_json, object_of_line, tagged_from_json, tagged_to_json
from fcw.locked_file import LockedFile
from fcw.logs.mcap.format import drive_metadata
from fcw.logs.mcap.reader import DriveLog

FORMAT_VERSION = 1
MOST_REVIEW_BYTES = 64 << 20
"""Largest file of one person: a hundred thousand entries about one drive."""
VERSION_FIELD = "fcw_review_version"
SAID_FIELD = "said"
SUFFIX = ".jsonl"
LONGEST_NAME = 40
"""Longest name of a person; together with the log's name it must fit into a file name of 255 bytes."""
TIME_FORMAT = "%Y-%m-%dT%H:%M:%S.%fZ"


def review_path(log_path: Path, person: str) -> Path:
    """`drive.review.<person>.jsonl` beside `drive.mcap`.

    Raises:
        UserError: the name is empty, too long or cannot be printed.
    """
    if not (person == person.strip() != "" and person.isprintable() and len(person) <= LONGEST_NAME):
        raise UserError(f"{person!r}: expected the name of a person, of 1 to {LONGEST_NAME} letters")
    return log_path.with_name(_file_prefix(log_path) + re.sub(r"[^\w-]+", "_", person) + SUFFIX)


def review_files(log_path: Path) -> tuple[Path, ...]:
    """The files of all people beside a log, sorted by name.

    Raises:
        UserError: the folder cannot be read.
    """
    prefix = _file_prefix(log_path)
    try:
        names = [path.name for path in log_path.parent.iterdir()]
    except OSError as error:
        raise UserError(
            f"{log_path.parent}: cannot read this folder of a drive ({error.strerror}); is it still there?"
        ) from error
    return tuple(
        log_path.with_name(name)
        for name in sorted(names)
        if name.startswith(prefix) and name.endswith(SUFFIX)
    )


def read_review(log: DriveLog) -> tuple[Review, tuple[str, ...]]:
    """The review of a drive, and messages about its files for the user, for example about damage.

    Raises:
        UserError: a file cannot be read.
    """
    paths = review_files(log.path)
    if not paths:  # nobody has said anything, as of most drives of a long list
        return Review(), ()
    digest = log_digest(log)
    contents = [_read_file(path, digest) for path in paths]
    review = fold(entry for content in contents for entry in content.entries)
    return review, tuple(trouble for content in contents for trouble in content.troubles)


def log_digest(log: DriveLog) -> str:
    """A digest that shows whether a drive was run again, after which track ids and events are different.

    It depends only on the start of the log, so that a recovered log has the same digest.
    """
    header = log.header
    known = [drive_metadata(header), sorted(header.versions.items()), calibration_text(header.calibration)]
    return hashlib.sha256(json.dumps(known).encode()).hexdigest()


class ReviewStore:
    """The review of one drive, for reading and adding. Not thread-safe: the session serialises its calls.

    The file of a person is made with their first entry, and is locked until `close`.

    Attributes:
        log_path: the log of the drive.
        review: the review so far.
        troubles: messages about the files for the user.
    """

    def __init__(self, log: DriveLog) -> None:
        """Read the existing files.

        Raises:
            UserError: a file cannot be read.
        """
        self.log_path = log.path
        self._digest = log_digest(log)
        self._contents: dict[Path, _Content] = {}
        self._files: dict[Path, LockedFile] = {}
        self._closed = False
        self._fold()
        self.refresh()

    def refresh(self) -> bool:
        """Read what others have written since, and return whether anything is new.

        Raises:
            UserError: a file cannot be read.
        """
        paths = sorted({*review_files(self.log_path), *self._files})
        contents = {
            path: self._contents[path]
            if path in self._files or (path in self._contents and self._contents[path].stamp == _stamp(path))
            else _read_file(path, self._digest)
            for path in paths
        }
        if contents == self._contents:
            return False
        self._contents = contents
        self._fold()
        return True

    def add(self, person: str, said: Said) -> Entry[Said]:
        """Store what a person says; see `add_all`."""
        return self.add_all(person, (said,))[0]

    def add_all(self, person: str, said: Sequence[Said]) -> tuple[Entry[Said], ...]:
        """Store several things that a person says at once; they are on the disk when this returns.

        Raises:
            UserError: another program writes as this person, the file cannot be written, or an entry to take
                back does not count or is another person's. Then nothing has changed.
        """
        path = review_path(self.log_path, person)
        for one in said:
            if isinstance(one, TakenBack):
                self._check_taken_back(person, one.entry_id)
        file = self._file(path)
        time, lines = self._now(), []
        for one in said:
            fields = {"id": uuid.uuid4().hex, "time": time, "person": person}
            lines.append(_line(fields | tagged_to_json(one, SAID_FIELD)))
            time = _later(time)
        # Converted to its form on the disk and back, so that the state equals that after reading the file.
        entries = tuple(_entry(json.loads(line)) for line in lines)
        try:
            file.append(b"".join(lines))
        except OSError as error:
            raise _cannot_write(path, error) from error
        content = self._contents[path]
        self._contents[path] = _Content(
            (*content.entries, *entries), content.whole_bytes, content.troubles, None
        )
        self._fold()
        return entries

    def take_back(self, person: str, entry_id: str) -> Entry[Said]:
        """Take back an entry of this person, which may itself be a `TakenBack`.

        Raises:
            UserError: as for `add`.
        """
        return self.add(person, TakenBack(entry_id))

    def close(self) -> None:
        """Close and unlock the files."""
        self._closed = True
        for file in self._files.values():
            file.close()
        self._files.clear()

    def _fold(self) -> None:
        self._entries = {
            entry.entry_id: entry for content in self._contents.values() for entry in content.entries
        }
        self.review = fold(self._entries.values())
        self.troubles = tuple(trouble for content in self._contents.values() for trouble in content.troubles)

    def _now(self) -> str:
        """The time now, made later than that of every known entry, so that an answer follows its question."""
        latest = max((entry.time for entry in self._entries.values()), default="")
        now = datetime.now(UTC).strftime(TIME_FORMAT)
        if now > latest:
            return now
        return _later(latest)

    def _check_taken_back(self, person: str, entry_id: str) -> None:
        entry = next((entry for entry in self.review.entries if entry.entry_id == entry_id), None)
        if entry is None:
            raise UserError("this was taken back already, or never said; there is nothing to take back")
        if entry.person != person:
            raise UserError(f"only {entry.person} can take this back; add your own note instead")

    def _file(self, path: Path) -> LockedFile:
        """The file of a person, opened and locked, and begun if it is new."""
        if self._closed:
            raise UserError(f"{path}: the review is closed; start `fcw review` again")
        if path in self._files:
            return self._files[path]
        try:
            file = LockedFile.open(path)
        except OSError as error:
            raise _cannot_write(path, error) from error
        if file is None:
            raise UserError(
                f"{path}: another `fcw review` writes to this file; add it there, or stop that one first"
            )
        try:
            content = _read_file(path, self._digest)
            if content.whole_bytes is None:
                raise UserError(f"{content.troubles[0]}; move it away to add something about this drive")
            file.cut(content.whole_bytes)
            if content.whole_bytes == 0:
                file.append(_line({VERSION_FIELD: FORMAT_VERSION, "log": self._digest}))
        except BaseException as error:
            file.close()
            if isinstance(error, OSError):
                raise _cannot_write(path, error) from error
            raise
        self._contents[path], self._files[path] = content, file
        self._fold()
        return file


@dataclass(frozen=True, slots=True)
class _Content:
    """The content of a file.

    Attributes:
        entries: the entries, in the order in which they were made.
        whole_bytes: length of its complete lines; None for a file that this program cannot add to.
        troubles: messages about it for the user.
        stamp: stamp of the file when it was read; None for one that we write.
    """

    entries: tuple[Entry[Said], ...]
    whole_bytes: int | None
    troubles: tuple[str, ...]
    stamp: tuple[int, int] | None


def _read_file(path: Path, digest: str) -> _Content:
    """Read a file. What follows the last line feed was not written completely and does not count.

    A damaged line is left out and reported; the other lines do not depend on it.
    """
    try:
        stamp = _stamp(path)
        data = read_bytes(path, MOST_REVIEW_BYTES)
    except MalformedError as error:
        return _Content((), None, (f"{path}: {error}, left out",), None)
    except OSError as error:
        raise UserError(
            f"{path}: cannot read this review ({error.strerror}); make it readable, or move it away"
        ) from error
    *lines, torn = data.split(b"\n")
    if not lines:
        header_start = _line({VERSION_FIELD: FORMAT_VERSION})[:-2]
        if not torn.startswith(header_start[: len(torn)]):
            return _Content((), None, (f"{path}: not a review of fcw, left out",), stamp)
        return _Content((), 0, (), stamp)
    header = object_of_line(lines[0])
    if header is None or VERSION_FIELD not in header:
        return _Content((), None, (f"{path}: not a review of fcw, left out",), stamp)
    if header[VERSION_FIELD] != FORMAT_VERSION:
        version = f"{VERSION_FIELD} is {header[VERSION_FIELD]!r}, this program reads {FORMAT_VERSION}"
        return _Content((), None, (f"{path}: {version}; left out",), stamp)
    entries, troubles = [], []
    if header.get("log") != digest:
        troubles.append(
            f"{path}: was written for an earlier run of this drive; vehicle numbers and boxes may be "
            "different now, so check what it says about them"
        )
    for number, line in enumerate(lines[1:], 2):
        try:
            entries.append(_entry(json_value(line.decode())))
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, UserError) as error:
            troubles.append(
                f"{path}: line {number} is damaged and left out ({type(error).__name__}: {error})"
            )
    return _Content(tuple(entries), len(data) - len(torn), tuple(troubles), stamp)


def _entry(value: dict[str, Any]) -> Entry[Said]:
    fields = dict(value)
    entry_id, time, person = (from_json(str, fields.pop(name)) for name in ("id", "time", "person"))
    if datetime.strptime(time, TIME_FORMAT).strftime(TIME_FORMAT) != time:
        raise ValueError(f"{time!r} is no time with microseconds")
    return Entry(entry_id, time, person, tagged_from_json(SAID_TYPES, fields, SAID_FIELD))


def _later(time: str) -> str:
    """The next later time that is distinguishable."""
    return (datetime.strptime(time, TIME_FORMAT) + timedelta(microseconds=1)).strftime(TIME_FORMAT)


def _line(value: dict[str, Any]) -> bytes:
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.encode() + b"\n"


def _stamp(path: Path) -> tuple[int, int] | None:
    """A stamp that shows whether a file has changed; None if the file does not exist."""
    try:
        state = path.stat()
    except FileNotFoundError:
        return None
    return state.st_size, state.st_mtime_ns


def _file_prefix(log_path: Path) -> str:
    return f"{log_path.stem}.review."


def _cannot_write(path: Path, error: OSError) -> UserError:
    return UserError(
        f"{path}: cannot be written ({error.strerror}), so nothing was changed; correct that (a full disk? "
        "a folder without permission to write?) and do it again"
    )
