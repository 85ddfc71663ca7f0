"""What the review page's list says of a batch's drives, in one file: so it need not open a thousand logs."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from fcw.batch.ledger import Record
from fcw.batch.moments import WORST_NAME, read_moment
from fcw.bounded.formats import json_value
from fcw.logs.events import DriveEvent
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME

REVIEW_LIST_NAME = "review.parquet"


@dataclass(frozen=True, slots=True)
class ListedDrive:
    """A drive of the list.

    Attributes:
        drive: name of its folder.
        log_bytes: size of its log,
        log_ns: and when that was written; a log with others is another one.
        duration_s: from its first frame to its last.
        imperial: units of its words.
        events: by time.
        thumbnail: its worst moment as JPEG; empty where there is no picture.
        camera: name of the folder that holds the source.
        begun_utc_ns: its first frame, in UTC since 1970; None where its source does not say it.
        notes: what a person should know of it.
        source: its file; empty in lists of before it was kept.
    """

    drive: str
    log_bytes: int
    log_ns: int
    duration_s: float
    imperial: bool
    events: tuple[DriveEvent, ...]
    thumbnail: bytes
    camera: str = ""
    begun_utc_ns: int | None = None
    notes: tuple[str, ...] = ()
    source: str = ""

    @staticmethod
    def of(folder: Path, log: DriveLog, events: tuple[DriveEvent, ...], record: Record) -> "ListedDrive":
        """That of a drive's folder.

        Raises:
            OSError: its log is not there.
        """
        header, series = log.header, log.series()
        state = (folder / MCAP_NAME).stat()
        ordered = tuple(sorted(events, key=lambda event: (event.start_s, event.end_s)))
        thumbnail = read_moment(folder, WORST_NAME)
        return ListedDrive(
            folder.name,
            state.st_size,
            state.st_mtime_ns,
            series.duration_s,
            header.imperial,
            ordered,
            thumbnail,
            record.camera,
            header.begun_utc_ns(int(series.time_ns[0])),
            record.notes,
            record.source,
        )


def fill_review_list(path: Path, drives: Iterable[ListedDrive]) -> None:
    """Write the list of a batch into a partial file that the caller takes care of; pyarrow must be installed.

    Raises:
        OSError: the file cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = [
        {
            "drive": one.drive,
            "log_bytes": one.log_bytes,
            "log_ns": one.log_ns,
            "duration_s": one.duration_s,
            "imperial": one.imperial,
            "events": json.dumps([asdict(event) for event in one.events]),
            "thumbnail": one.thumbnail,
            "camera": one.camera,
            "begun_utc_ns": one.begun_utc_ns,
            "notes": one.notes,
            "source": one.source,
        }
        for one in drives
    ]
    schema = pa.schema(
        {
            "drive": pa.string(),
            "log_bytes": pa.int64(),
            "log_ns": pa.int64(),
            "duration_s": pa.float64(),
            "imperial": pa.bool_(),
            "events": pa.string(),
            "thumbnail": pa.binary(),
            "camera": pa.string(),
            "begun_utc_ns": pa.int64(),
            "notes": pa.list_(pa.string()),
            "source": pa.string(),
        }
    )
    pq.write_table(pa.Table.from_pylist(rows, schema), path, compression="zstd")


def read_review_list(out: Path) -> dict[Path, ListedDrive]:
    """The drives of a batch by their logs, of those logs that are as they were; empty where there is no list.

    A file that is missing or torn, or pyarrow that is not installed, only makes the list slower.
    """
    path = out / REVIEW_LIST_NAME
    if not path.is_file():
        return {}
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        return {}
    found = {}
    try:
        for row in pq.ParquetFile(path).read().to_pylist():  # read_table would import pandas
            log = out / row["drive"] / MCAP_NAME
            if log.parent.parent != out:
                continue  # a name with a folder in it is none of ours
            state = log.stat()
            if (state.st_size, state.st_mtime_ns) == (row["log_bytes"], row["log_ns"]):
                events = tuple(DriveEvent(**event) for event in json_value(row.pop("events")))
                notes = tuple(map(str, row.pop("notes", None) or ()))  # earlier lists have none
                found[log] = ListedDrive(**row, events=events, notes=notes)
    except (OSError, ValueError, TypeError, KeyError, pa.ArrowException):
        return found
    return found
