"""A batch's two tables: the events of all drives, and the drives."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fcw.annotation.review import judged_events
from fcw.annotation.store import read_review
from fcw.batch.fleet import FLEET_NAME, Fleet
from fcw.batch.ledger import Record, State
from fcw.batch.review_list import ListedDrive, write_review_list
from fcw.files import write_whole
from fcw.logs.events import find_events
from fcw.logs.export.columns import EVENT_COLUMNS, Column, EventRow
from fcw.logs.export.table import write_parquet
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME

EVENTS_NAME, DRIVES_NAME = "events.parquet", "drives.parquet"


@dataclass(frozen=True, slots=True)
class _Event:
    """An event with what is known of its drive, and what people say of it."""

    row: EventRow
    verdict: str | None
    camera: str
    source: str
    version: str


def _told(column: Column[EventRow]) -> Column[_Event]:
    return Column(column.name, column.kind, column.unit, column.meaning, lambda told: column.value(told.row))


BATCH_EVENT_COLUMNS: tuple[Column[_Event], ...] = (
    *map(_told, EVENT_COLUMNS),
    Column(
        "verdict",
        "string",
        "",
        "what all who judged it say, disagreed, or empty where nobody did",
        lambda told: told.verdict,
    ),
    Column("camera", "string", "", "name of the folder that holds the drive", lambda told: told.camera),
    Column("source", "string", "", "the drive's file", lambda told: told.source),
    Column("version", "string", "", "of the program that ran it", lambda told: told.version),
)

DRIVE_COLUMNS: tuple[Column[Record], ...] = (
    Column("drive", "string", "", "name of the drive, and of its folder", lambda record: record.name),
    Column("camera", "string", "", "name of the folder that holds it", lambda record: record.camera),
    Column("source", "string", "", "its file", lambda record: record.source),
    Column(
        "state",
        "string",
        "",
        "done, failed, no calibration, duplicate, not finished",
        lambda r: r.state.value,
    ),
    Column("reason", "string", "", "why it is not done; empty where it is", lambda r: r.reason or None),
    Column("frames", "int64", "", "so many", lambda record: record.frames),
    Column(
        "duration_s", "float64", "s", "from its first frame to its last", lambda record: record.duration_s
    ),
    Column("warnings", "int64", "", "events of level warning", lambda record: record.warnings),
)


def write_tables(out: Path, records: Sequence[Record]) -> int:
    """Write `events.parquet` and `drives.parquet`, the review page's list and `fleet.html`, by drives' names.

    Args:
        out: the batch's folder.
        records: of all its drives.

    Returns:
        Number of events.

    Raises:
        UserError: pyarrow is not installed, a log cannot be read, or a table cannot be written.
    """
    records = sorted(records, key=lambda record: record.name)
    write_parquet(out / DRIVES_NAME, DRIVE_COLUMNS, records)
    listed: list[ListedDrive] = []
    fleet = Fleet()
    count = write_parquet(out / EVENTS_NAME, BATCH_EVENT_COLUMNS, _events(out, records, listed, fleet))
    write_review_list(out, listed)
    write_whole(out / FLEET_NAME, fleet.html(out))
    return count


def _events(
    out: Path, records: Sequence[Record], listed: list[ListedDrive], fleet: Fleet
) -> Iterator[_Event]:
    """The events of all drives; each log is read once, and the list and the fleet get what they need."""
    for record in records:
        if record.state is not State.DONE:
            continue
        log = DriveLog(out / record.name / MCAP_NAME)
        series = log.series()
        found = find_events(series)
        listed.append(ListedDrive.of(log.path.parent, series.duration_s, log.header.imperial, found))
        fleet.add(record, series, found, log.header.calibration.camera.pitch_rad, out)
        version = log.header.versions.get("fcw", "")
        judged, _ = judged_events(read_review(log)[0], found)
        for one in judged:
            agreed = one.judgement.value if one.judgement else None
            verdict = "disagreed" if one.disagreement else agreed
            row = EventRow(record.name, one.event)
            yield _Event(row, verdict, record.camera, record.source, version)
