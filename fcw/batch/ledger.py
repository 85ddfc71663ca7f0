"""The record of each drive, which is kept in its folder, and the manifest of the whole batch."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

from fcw.batch.identity import Identity
from fcw.bounded.files import read_text
from fcw.bounded.formats import json_value
from fcw.files import OTHER_FOLDER, make_folder, not_written, write_whole
from fcw.json_form import from_json
from fcw.logs.names import MCAP_NAME
from fcw.versions import versions

RECORD_NAME = "batch.json"
MANIFEST_NAME = "manifest.json"
DRIVES_NAME = "drives.parquet"
MOST_MANIFEST_BYTES = 256 << 20
"""A kilobyte a drive."""
RETRY_WORDS = "; once it is mended, run it again with --retry"
"""Follows the reason of a drive that failed earlier; later batches only report it."""


class State(Enum):
    """The state of a drive in a batch."""

    DONE = "done"
    FAILED = "failed"
    """Its source, calibration or an option is wrong; running it again helps only after that is fixed."""
    UNCALIBRATED = "no calibration"
    DUPLICATE = "duplicate"
    LOST = "not finished"
    """Its worker died, or the batch was stopped: the next one runs it."""


@dataclass(frozen=True, slots=True)
class Record:
    """The result of one drive of a batch.

    Attributes:
        name: name of its folder.
        source: its file.
        camera: name of the folder that contains the source.
        state: state of the drive.
        reason: why it is not finished, and what to do; empty if it is.
        identity: key of what was run, see `fcw.batch.identity`; empty if nothing could be run.
        content: SHA-256 of the source, likewise.
        warning_policy: warning policy that was used; empty if it was not run.
        frames: number of frames.
        seconds: how long the run took.
        duration_s: duration of the drive.
        events: number of events of every kind.
        warnings: number of events of level `warning`.
        log_bytes: size of its log.
        notes: what the user should know about the source and the drive, for example that a part is lost.
        unseen_s: how long nothing could be seen; known after the tables are made.
    """

    name: str
    source: str
    camera: str
    state: State
    reason: str = ""
    identity: str = ""
    content: str = ""
    warning_policy: str = ""
    frames: int = 0
    seconds: float = 0.0
    duration_s: float = 0.0
    events: int = 0
    warnings: int = 0
    log_bytes: int = 0
    notes: tuple[str, ...] = ()
    unseen_s: float = 0.0

    def __post_init__(self) -> None:
        """Show bytes of names that are no UTF-8 as escapes, so that every table and page can be written."""
        for field in ("name", "source", "camera", "reason"):
            text: str = getattr(self, field)
            object.__setattr__(self, field, text.encode("utf-8", "backslashreplace").decode())

    @property
    def frames_per_second(self) -> float:
        """Speed of the run; 0 if it was not run."""
        return self.frames / self.seconds if self.seconds else 0.0


class Ledger:
    """The records in the folder of a batch.

    Args:
        out: the folder of the batch, which is made if it does not exist.

    Attributes:
        finished: all finished drives in this folder by name, also those of earlier batches.

    Raises:
        UserError: the folder cannot be made or read.
    """

    def __init__(self, out: Path) -> None:
        self.out = out
        try:
            out.mkdir(parents=True, exist_ok=True)
            files = sorted(out.glob(f"*/{RECORD_NAME}"))
        except OSError as error:
            raise not_written(f"--out {out}: cannot be the batch's folder", error, OTHER_FOLDER) from error
        read = filter(None, map(read_record, files))
        records = [one for one in read if one.state is not State.DONE or self._has_its_log(one)]
        self.finished = {record.name: record for record in records if record.state is State.DONE}
        self._known = {record.identity: record for record in records}
        self._alike: dict[str, list[Record]] = {}
        for record in self.finished.values():
            self._alike.setdefault(record.content, []).append(record)
        failed = [record for record in records if record.state is State.FAILED]
        self._failed = {mark for one in failed for mark in (one.identity, one.source, one.content)} - {""}
        self._ran = _ran(out / MANIFEST_NAME)

    def folder(self, name: str) -> Path:
        """The folder of a drive's log, summary and record."""
        return self.out / name

    def known(self, identity: Identity) -> Record | None:
        """The earlier record of a drive, under any name; None if it was not run to its end."""
        return self._known.get(identity.key)

    def names_of(self, source: str, content: str) -> tuple[str, ...]:
        """Names under which a drive with this content was finished, with any calibration and options.

        First those at its present place, then those at places where it no longer is: it was moved, and counts
        only once.
        """
        alike = self._alike.get(content, [])
        here = [record.name for record in alike if record.source == source]
        gone = [record.name for record in alike if record.source != source and _is_gone(record.source)]
        return (*here, *gone)

    def has_failed(self, identity: Identity, source: str) -> bool:
        """Whether a drive failed earlier, in its present form or before it was fixed or moved."""
        return not self._failed.isdisjoint((identity.key, identity.content, source))

    def note_places(self, records: Iterable[Record]) -> None:
        """Record the new places of drives that were moved, for later batches and the review page.

        Raises:
            UserError: a record cannot be written.
        """
        for record in records:
            known = self._known.get(record.identity)
            if known is not None and known.source != record.source and _is_gone(known.source):
                moved = replace(known, source=record.source, camera=record.camera)
                write_record(moved, self.folder(known.name))

    def write_manifest(self, records: Iterable[Record], identities: dict[str, Identity]) -> None:
        """Write what was run, with which version, calibration and model, and the results.

        Args:
            records: records of all drives.
            identities: identities of this batch's drives, by key; those of earlier ones are in the manifest.
        """
        ran = self._ran | {key: asdict(identity) for key, identity in identities.items()}
        drives = [as_json(record) | {"ran": ran.get(record.identity)} for record in records]
        write_whole(
            self.out / MANIFEST_NAME, json.dumps({"versions": versions(), "drives": drives}, indent=2) + "\n"
        )

    def _has_its_log(self, record: Record) -> bool:
        """Whether the log is complete, or may be missing because the drive has no events."""
        try:
            size = (self.folder(record.name) / MCAP_NAME).stat().st_size
        except OSError:
            return record.log_bytes > 0 and not record.events
        return size == record.log_bytes or not record.log_bytes


def _is_gone(source: str) -> bool:
    """Whether a file of this machine is no longer where it was; files in a store are not checked."""
    return "://" not in source and not Path(source).exists()


def write_record(record: Record, folder: Path) -> None:
    """Write the record of a drive, after everything else of the drive.

    Raises:
        UserError: it cannot be written.
    """
    make_folder(folder)
    write_whole(folder / RECORD_NAME, json.dumps(as_json(record), indent=2) + "\n")


def read_record(file: Path) -> Record | None:
    """Read the record of a drive; None if there is no complete one, so that the drive is run again."""
    try:
        fields = json_value(read_text(file))
        record = from_json(Record, fields | {"state": State(fields["state"]).name.lower()})
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return replace(record, name=file.parent.name)


def as_json(record: Record) -> dict[str, Any]:
    """The fields of a record."""
    return asdict(record) | {"state": record.state.value}


def _ran(manifest: Path) -> dict[str, Any]:
    """What an earlier batch ran, by key; empty if its manifest is missing or damaged."""
    try:
        return {
            drive["identity"]: drive["ran"]
            for drive in json_value(read_text(manifest, MOST_MANIFEST_BYTES))["drives"]
        }
    except (OSError, ValueError, TypeError, KeyError):
        return {}
