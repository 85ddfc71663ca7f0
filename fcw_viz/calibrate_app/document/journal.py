"""The journal: every event of a session as one line of JSON beside the calibration file.

It is the autosave: a line is on the disk before its effect is shown, so that a killed server loses no click.
The first line contains the source of the pictures and the first document. Each other line is an `Event`, the
digest of a saved calibration file, or the address of the page that uses the journal.
"""

import hashlib
import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fcw.bounded.files import MalformedError, read_bytes
from fcw.errors import UserError
from fcw.json_form import from_json, object_of_line, to_json
from fcw.locked_file import LockedFile
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.edits import Edit
from fcw_viz.calibrate_app.document.history import Action, Event, History
from fcw_viz.page.guard.guard import whole_address

FORMAT_VERSION = 1
MOST_JOURNAL_BYTES = 64 << 20
VERSION_FIELD = "fcw_calibration_journal_version"
HEADER_START = f'{{"{VERSION_FIELD}":'.encode()


def journal_path(save_path: Path) -> Path:
    """`<name>.calibration.work.jsonl` beside `<name>.calibration.yaml`."""
    return save_path.with_suffix(".work.jsonl")


def file_digest(path: Path) -> str | None:
    """SHA-256 of a file; None if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


@dataclass(frozen=True, slots=True)
class JournalContent:
    """The content of a journal.

    Attributes:
        history: the result of its events on the first document.
        event_count: number of events.
        saved_digest: digest of the calibration file that the session wrote last, or began with.
        page: address of the page that opened it last, if it had one.
        whole_bytes: length of its complete lines.
        torn: whether an incomplete line follows them.
    """

    history: History
    event_count: int
    saved_digest: str | None
    page: str | None
    whole_bytes: int
    torn: bool


class Journal:
    """An open journal, locked for this process. Not thread-safe: the session serialises its calls."""

    def __init__(self, path: Path, file: LockedFile, content: JournalContent) -> None:
        """Use `open`."""
        self.path = path
        self.content = content
        self._file = file
        self._events = content.event_count

    @classmethod
    def open(
        cls, path: Path, source_name: str, start: Document, saved_digest: str | None
    ) -> tuple["Journal", bool]:
        """Open the journal at `path`, or begin a new one.

        Args:
            path: path of the journal.
            source_name: name of the source of the pictures, for people who read the file.
            start: the first document of a new journal.
            saved_digest: digest of the calibration file from which `start` was made.

        Returns:
            The journal, and whether it existed before.

        Raises:
            UserError: another page uses it, it cannot be read or written, it is damaged, or it belongs to
                pictures of another size.
        """
        try:
            file = LockedFile.open(path)
        except OSError as error:
            raise UserError(
                f"{path}: cannot keep your work there ({error.strerror}); "
                "name a calibration file in a folder that can be written with `--save FILE`"
            ) from error
        if file is None:
            raise _in_use(path)
        try:
            content = read_journal(path)
            existed = content is not None
            if content is None:
                content = JournalContent(History((start,)), 0, saved_digest, None, 0, torn=False)
            elif content.history.document.image_size != start.image_size:
                size = content.history.document.image_size
                raise UserError(
                    f"{path}: its points were clicked in pictures of {size}, these are {start.image_size}; "
                    "name another file with `--save FILE`, or delete this one to start anew"
                )
            file.cut(content.whole_bytes)
            journal = cls(path, file, content)
            if not existed:
                journal._append(
                    {
                        VERSION_FIELD: FORMAT_VERSION,
                        "source": source_name,
                        "saved": saved_digest,
                        "start": to_json(start),
                    }
                )
        except BaseException:
            file.close()
            raise
        return journal, existed

    def add(self, event: Event) -> None:
        """Store an event; it is on the disk when this returns.

        Raises:
            UserError: it cannot be written; then the journal is unchanged.
        """
        line: dict[str, Any] = {"time": event.time, "person": event.person}
        if event.action is Action.STEP:
            line["edits"] = [edit_to_json(edit) for edit in event.edits]
        else:
            line[event.action.value] = True
        self._append(line)
        self._events += 1

    def add_saved(self, digest: str | None) -> None:
        """Store the digest of the calibration file just written, to recognise changes by others."""
        self._append({"saved": digest})

    def add_page(self, address: str) -> None:
        """Store the address of the page that uses this journal, for those who start a second one."""
        self._append({"page": address})

    def close(self) -> None:
        """Close the file; a journal without any event is deleted."""
        if self._file.closed:
            return
        if self._events == 0:
            self._file.remove(self.path)
        self._file.close()

    def _append(self, value: dict[str, Any]) -> None:
        data = (json.dumps(value, allow_nan=False, separators=(",", ":")) + "\n").encode()
        if self._file.closed:
            raise UserError(f"{self.path}: the session is closed; start `fcw calibrate` again")
        try:
            self._file.append(data)
        except OSError as error:
            raise UserError(
                f"{self.path}: cannot be written ({error.strerror}), so nothing was changed; "
                "mend that (a full disk?) and do it again"
            ) from error


def read_journal(path: Path) -> JournalContent | None:
    """Read the journal at `path`; an incomplete last line, left by a kill or a full disk, does not count.

    Returns:
        None if the file does not exist, or its first line is incomplete.

    Raises:
        UserError: it cannot be read, has another version, or is damaged.
    """
    try:
        data = read_bytes(path, MOST_JOURNAL_BYTES)
    except FileNotFoundError:
        return None
    except (OSError, MalformedError) as error:
        raise UserError(
            f"{path}: cannot read the work so far ({getattr(error, 'strerror', None) or error}); "
            "name another file with `--save FILE`"
        ) from error
    lines = data.split(b"\n")
    # What follows the last line feed was never written to its end.
    whole, torn = lines[:-1], lines[-1] != b""
    if whole and not torn and object_of_line(whole[-1]) is None:
        whole, torn = whole[:-1], True
    if not whole:
        if not data.startswith(HEADER_START[: len(data)]):
            raise _damaged(path, 1, "it is not the beginning of a journal")
        return None
    history: History | None = None
    event_count, saved_digest, page = 0, None, None
    for number, line in enumerate(whole, 1):
        value = object_of_line(line)
        if value is None:
            raise _damaged(path, number, "it is not a JSON object")
        if history is None:
            version = value.get(VERSION_FIELD)
            if version != FORMAT_VERSION:
                raise UserError(
                    f"{path}: {VERSION_FIELD} is {version!r}, this program reads {FORMAT_VERSION}; "
                    "use the program that wrote it, or delete the file to start anew"
                )
        try:
            if history is None:
                history = History((from_json(Document, value["start"]),))
                saved_digest = value["saved"]
            elif "saved" in value:
                saved_digest = value["saved"]
            elif "page" in value:
                page = value["page"]
            else:
                history = history.after(_event(value))
                event_count += 1
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, UserError) as error:
            raise _damaged(path, number, f"{type(error).__name__}: {error}") from error
    assert history is not None
    whole_bytes = sum(len(line) + 1 for line in whole)
    return JournalContent(history, event_count, saved_digest, page, whole_bytes, torn)


def _event(value: dict[str, Any]) -> Event:
    time, person = from_json(str, value["time"]), from_json(str, value["person"])
    for action in (Action.UNDO, Action.REDO):
        if value.get(action.value) is True:
            return Event(time, person, action)
    edits: tuple[Edit, ...] = tuple(edit_from_json(edit) for edit in value["edits"])
    return Event(time, person, Action.STEP, edits)


def _damaged(path: Path, number: int, reason: str) -> UserError:
    return UserError(
        f"{path}: line {number} is damaged ({reason}); "
        f"delete that line and all after it to keep the work before it, or the file to start anew"
    )


def _in_use(path: Path) -> UserError:
    content = None
    with suppress(UserError):
        content = read_journal(path)
    where = f" at {whole_address(content.page)}" if content is not None and content.page is not None else ""
    return UserError(
        f"{path}: a calibration page{where} is already working on this; use that one, "
        "stop it first, or name another file with `--save FILE`"
    )
