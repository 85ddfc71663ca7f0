"""A batch's two tables: the events of all drives, and the drives."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from fcw.annotation.review import judged_events
from fcw.annotation.store import read_review
from fcw.batch.fleet import FLEET_NAME, Fleet
from fcw.batch.ledger import DRIVES_NAME, MANIFEST_NAME, RECORD_NAME, Record, State
from fcw.batch.review_list import REVIEW_LIST_NAME, ListedDrive, fill_review_list
from fcw.bounded.gpx import GpxTrack
from fcw.errors import UserError
from fcw.files import check_kind, whole_files
from fcw.logs.events import find_events, seen_s
from fcw.logs.export.columns import EVENT_COLUMNS, NOTE_SEPARATOR, Column, EventRow
from fcw.logs.export.table import fill_parquet
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw.units import NS_PER_S

EVENTS_NAME = "events.parquet"
TABLE_NAMES = (EVENTS_NAME, DRIVES_NAME, REVIEW_LIST_NAME, FLEET_NAME)
"""All that `write_tables` writes."""


@dataclass(frozen=True, slots=True)
class _Event:
    """An event with what is known of its drive, and what people say of it."""

    row: EventRow
    verdict: str | None
    record: Record
    version: str
    log_span: tuple[int, int]
    place: tuple[float, float] | None


def _told(column: Column[EventRow]) -> Column[_Event]:
    return Column(column.name, column.kind, column.unit, column.meaning, lambda told: column.value(told.row))


BATCH_EVENT_COLUMNS: tuple[Column[_Event], ...] = (
    *map(_told, EVENT_COLUMNS),
    Column(
        "verdict",
        "string",
        "",
        "right, too early, too late or false if all who judged it agree; disagreed if they do not; empty "
        "if nobody judged it",
        lambda told: told.verdict,
    ),
    Column(
        "camera", "string", "", "name of the folder that holds the drive", lambda told: told.record.camera
    ),
    Column("source", "string", "", "the drive's file", lambda told: told.record.source),
    Column("version", "string", "", "of the program that ran it", lambda told: told.version),
    Column(
        "warning_policy",
        "string",
        "",
        "that judged the drive",
        lambda told: told.record.warning_policy or None,
    ),
    Column(
        "log_offset",
        "int64",
        "",
        "offset in drive.mcap of the first byte of the event, so that it can be fetched alone",
        lambda told: told.log_span[0],
    ),
    Column("log_bytes", "int64", "", "number of bytes from that offset on", lambda told: told.log_span[1]),
    Column(
        "latitude_deg",
        "float64",
        "deg",
        "where the own vehicle was at the peak, north positive; empty without a GPX track",
        lambda told: told.place and told.place[0],
    ),
    Column(
        "longitude_deg",
        "float64",
        "deg",
        "likewise, east positive",
        lambda told: told.place and told.place[1],
    ),
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
    Column(
        "seen_s",
        "float64",
        "s",
        "the part of that in which something could be seen, so that a warning was possible",
        lambda record: record.duration_s - record.unseen_s,
    ),
    Column("events", "int64", "", "of every kind", lambda record: record.events),
    Column("warnings", "int64", "", "events of level warning", lambda record: record.warnings),
    Column("warning_policy", "string", "", "that judged it", lambda record: record.warning_policy or None),
    Column(
        "notes",
        "string",
        "",
        "notes on the drive, e.g. that a part of its file is damaged; empty where there are none",
        lambda record: NOTE_SEPARATOR.join(record.notes) or None,
    ),
)


def check_batch_folder(out: Path) -> None:
    """See that what stands under the names of a batch's files is of an earlier batch: beside its manifest.

    Raises:
        UserError: it is of another program.
    """
    manifest = out / MANIFEST_NAME
    check_kind(manifest, "manifest of a batch", (b'"fcw":',))
    for name in TABLE_NAMES:
        if (out / name).exists() and not manifest.exists():
            raise UserError(
                f"--out {out}: the {name} in it would be replaced, and is of no batch (there is no "
                f"{MANIFEST_NAME} of one beside it); name another folder"
            )


def write_tables(out: Path, records: Iterable[Record]) -> tuple[int, tuple[Record, ...]]:
    """Write `events.parquet` and `drives.parquet`, the review page's list and `fleet.html`, by drives' names.

    They belong together: where one cannot be written, as on a full disk, all stay as they were.

    Args:
        out: the batch's folder.
        records: of all its drives.

    Returns:
        Number of events; and new records of those drives whose logs cannot be read, which are run again by
        the next batch.

    Raises:
        UserError: pyarrow is not installed, or a table cannot be written.
    """
    by_name = {record.name: record for record in sorted(records, key=lambda record: record.name)}
    gathered = _Gathered(out)
    with whole_files([out / name for name in TABLE_NAMES]) as (events, drives, listed, fleet):
        count = fill_parquet(events, BATCH_EVENT_COLUMNS, gathered.events(by_name.values()))
        by_name |= {record.name: record for record in (*gathered.read, *gathered.unreadable)}
        fill_parquet(drives, DRIVE_COLUMNS, by_name.values())
        fill_review_list(listed, gathered.listed)
        gathered.fleet.unfinished = [one.state for one in by_name.values() if one.state is not State.DONE]
        fleet.write_text(gathered.fleet.html(out), encoding="utf-8")
    return count, tuple(gathered.unreadable)


def unfinished_drives(out: Path) -> tuple[Record, ...]:
    """The drives of a batch that are not done, by their names, as `drives.parquet` has them.

    Where that file is missing or torn, or pyarrow is not installed, there are none to tell of.
    """
    path = out / DRIVES_NAME
    if not path.is_file():
        return ()
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        return ()
    columns = ["drive", "source", "camera", "state", "reason"]
    try:
        rows = pq.ParquetFile(path).read(columns).to_pylist()
        records = [
            Record(row["drive"], row["source"], row["camera"], State(row["state"]), row["reason"] or "")
            for row in rows
        ]
    except (OSError, ValueError, KeyError, pa.ArrowException):
        return ()
    return tuple(record for record in records if record.state is not State.DONE)


class _Gathered:
    """What the list and the fleet need, gathered while the events go by: each log is read once."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.listed: list[ListedDrive] = []
        self.fleet = Fleet()
        self.read: list[Record] = []
        self.unreadable: list[Record] = []

    def events(self, records: Iterable[Record]) -> Iterator[_Event]:
        """Those of all drives that are done."""
        for record in records:
            if record.state is not State.DONE:
                continue
            folder = self.out / record.name
            if not (folder / MCAP_NAME).exists():
                continue  # deleted, as it holds no event; see `Ledger`
            try:
                yield from self._of_drive(record)
            except UserError as error:
                (folder / RECORD_NAME).unlink(missing_ok=True)
                reason = f"{error}; run the batch again, which makes the log anew"
                self.unreadable.append(replace(record, state=State.LOST, reason=reason))

    def _of_drive(self, record: Record) -> list[_Event]:
        log = DriveLog(self.out / record.name / MCAP_NAME)
        series, chunks = log.series(), log.chunks
        found = find_events(series)
        judged, _ = judged_events(read_review(log)[0], found)
        version = log.header.versions.get("fcw", "")
        start_ns, track = int(series.time_ns[0]), _track(log)
        events = []
        for one in judged:
            agreed = one.judgement.value if one.judgement else None
            verdict = "disagreed" if one.disagreement else agreed
            times_ns = (start_ns + round(s * NS_PER_S) for s in (one.event.start_s, one.event.end_s))
            span = chunks.span(*times_ns)
            place = None if track is None else track.place_at(one.event.peak_s)
            events.append(_Event(EventRow(record.name, one.event), verdict, record, version, span, place))
        unseen_s = record.duration_s - seen_s(record.duration_s, found)
        self.read.append(replace(record, events=len(events), unseen_s=unseen_s))
        self.listed.append(ListedDrive.of(log.path.parent, log, found, record))
        self.fleet.add(record, series, found, log.header, self.out)
        return events


def _track(log: DriveLog) -> GpxTrack | None:
    """Where a drive went; None where its own speed came from no GPX track."""
    with suppress(UserError):
        return log.track()
    return None
