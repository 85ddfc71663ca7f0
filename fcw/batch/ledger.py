"""What came of each drive, kept in its folder, and the manifest of the whole batch."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

from fcw.batch.identity import Identity
from fcw.bounded.files import read_text
from fcw.bounded.formats import json_value
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.json_form import from_json
from fcw.versions import versions

RECORD_NAME = "batch.json"
MANIFEST_NAME = "manifest.json"


class State(Enum):
    """Of a drive in a batch."""

    DONE = "done"
    FAILED = "failed"
    """Its source, calibration or an option is wrong: running it again helps only once that is mended."""
    UNCALIBRATED = "no calibration"
    DUPLICATE = "duplicate"
    LOST = "not finished"
    """Its worker died, or the batch was stopped: the next one runs it."""


@dataclass(frozen=True, slots=True)
class Record:
    """A drive of a batch, and what came of it.

    Attributes:
        name: of its folder.
        source: its file.
        camera: name of the folder that holds the source.
        state: what came of it.
        reason: why it is not done, with the mend; empty where it is.
        identity: key of what was run, see `fcw.batch.identity`; empty where nothing could be.
        frames: so many.
        seconds: that it took.
        duration_s: of the drive.
        warnings: events of level `warning`.
    """

    name: str
    source: str
    camera: str
    state: State
    reason: str = ""
    identity: str = ""
    frames: int = 0
    seconds: float = 0.0
    duration_s: float = 0.0
    warnings: int = 0

    @property
    def frames_per_second(self) -> float:
        """How fast it was run; 0 where it was not."""
        return self.frames / self.seconds if self.seconds else 0.0


class Ledger:
    """The records of a batch's folder.

    Args:
        out: the batch's folder, which is made where it is not there.

    Raises:
        UserError: it cannot be made or read.
    """

    def __init__(self, out: Path) -> None:
        self.out = out
        self._known: dict[str, Record] = {}
        try:
            out.mkdir(parents=True, exist_ok=True)
            files = sorted(out.glob(f"*/{RECORD_NAME}"))
        except OSError as error:
            raise UserError(
                f"--out {out}: cannot be the batch's folder ({error.strerror}); name one that can be written"
            ) from error
        for file in files:
            record = _read(file)
            if record is not None:
                self._known[record.identity] = record

    def folder(self, name: str) -> Path:
        """Where a drive's log, summary and record are."""
        return self.out / name

    def known(self, identity: Identity) -> Record | None:
        """What came of a drive earlier, under whatever name; None where it was not run to an end."""
        return self._known.get(identity.key)

    def write_manifest(self, records: Iterable[Record], identities: dict[str, Identity]) -> None:
        """What ran, with which version, calibration and model, and what came of it."""
        drives = [
            as_json(record) | {"ran": asdict(identities[record.name]) if record.name in identities else None}
            for record in records
        ]
        write_whole(
            self.out / MANIFEST_NAME, json.dumps({"versions": versions(), "drives": drives}, indent=2) + "\n"
        )


def write_record(record: Record, folder: Path) -> None:
    """Keep what came of a drive; the last thing that is written of it."""
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / RECORD_NAME, json.dumps(as_json(record), indent=2) + "\n")


def as_json(record: Record) -> dict[str, Any]:
    """Its fields."""
    return asdict(record) | {"state": record.state.value}


def _read(file: Path) -> Record | None:
    """None where nothing whole is there: the drive is run again."""
    try:
        fields = json_value(read_text(file))
        record = from_json(Record, fields | {"state": State(fields["state"]).name.lower()})
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return replace(record, name=file.parent.name)
