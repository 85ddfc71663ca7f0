"""What the list of drives shows about each drive."""

import base64
import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fcw.annotation.review import JudgedEvent, Review, judged_events
from fcw.annotation.store import read_review, review_files
from fcw.batch.ledger import RECORD_NAME, read_record
from fcw.batch.review_list import ListedDrive
from fcw.errors import UserError
from fcw.logs.events import DriveEvent
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.thumbnail import thumbnail_jpeg
from fcw_viz.review_app.drive import Drive, utc_text

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class DriveCard:
    """What the list shows about a drive.

    Attributes:
        name: name of the drive.
        path: its log.
        duration_s: from its first frame to its last.
        events: its events by time.
        complete: False if the program that wrote it was killed.
        imperial: whether its words use imperial units.
        review: its review.
        judged: the events with their verdicts.
        thumbnail: its worst moment, a JPEG in base 64; empty before it was read.
        trouble: why it cannot be read; empty if it can.
        review_troubles: what is wrong with the files of its review.
        read: False before it was read.
        source: the source that was run; empty before it was read.
        camera: folder of its source according to a batch; empty if there was none.
        begun_utc_ns: time of its first frame in UTC, since 1970; None if its source does not state it.
        notes: notes for the user from its run or its batch.
        file: path of its source according to a batch; empty if there was none.
    """

    name: str
    path: Path
    duration_s: float = 0.0
    events: tuple[DriveEvent, ...] = ()
    complete: bool = True
    imperial: bool = False
    review: Review = field(default_factory=Review)
    judged: tuple[JudgedEvent, ...] = ()
    thumbnail: str = ""
    trouble: str = ""
    read: bool = True
    source: str = ""
    review_troubles: tuple[str, ...] = ()
    camera: str = ""
    begun_utc_ns: int | None = None
    notes: tuple[str, ...] = ()
    file: str = ""

    @property
    def date(self) -> str:
        """The day on which it began, in UTC: 2026-11-20; empty if not known."""
        return "" if self.begun_utc_ns is None else utc_text(self.begun_utc_ns, True).partition(" ")[0]

    @property
    def severity(self) -> float:
        """Severity of its worst event; below 0 if there is none."""
        return max((event.severity for event in self.events), default=-1.0)


def list_key(card: DriveCard) -> tuple[bool, bool, float, int, str]:
    """Sorts the list: the worst drive first, then those that cannot be read, then those not read yet."""
    return not card.read, bool(card.trouble), -card.severity, -len(card.events), card.name


def read_card(name: str, path: Path, drive: Drive | None = None, thumbnail: str = "") -> DriveCard:
    """Read a drive for the list, without its picture; if it cannot be read, the card says why.

    Args:
        name: name of the drive.
        path: its log.
        drive: the drive if it is open; else it is opened.
        thumbnail: its picture, if it is known.
    """
    try:
        drive = drive or Drive.open(name, path)
        review, troubles = read_review(drive.log)
    except UserError as error:
        return DriveCard(name, path, trouble=str(error))
    except Exception:
        LOGGER.exception("%s cannot be read", path)
        return DriveCard(name, path, trouble=f"{path}: cannot be read; see the terminal for the reason")
    return card_of(drive, review, troubles, thumbnail)


def card_of(drive: Drive, review: Review, troubles: Sequence[str], thumbnail: str) -> DriveCard:
    """The card of a drive that can be read.

    Args:
        drive: the drive.
        review: its review.
        troubles: messages about the files of its review.
        thumbnail: its picture, if it is known.
    """
    judged, lost = judged_events(review, drive.events)
    record = read_record(drive.log.path.with_name(RECORD_NAME))
    return DriveCard(
        drive.name,
        drive.log.path,
        drive.duration_s,
        drive.events,
        drive.complete,
        drive.header.imperial,
        review,
        judged,
        thumbnail,
        source=drive.header.source,
        review_troubles=review_troubles(troubles, len(lost)),
        camera="" if record is None else record.camera,
        begun_utc_ns=drive.zero_utc_ns,
        notes=drive.notes if record is None else record.notes,
        file="" if record is None else record.source,
    )


def review_troubles(troubles: Sequence[str], lost: int) -> tuple[str, ...]:
    """Messages about the files of a review for the reviewer.

    Args:
        troubles: messages from reading them.
        lost: number of verdicts whose event is not in the log.
    """
    if not lost:
        return tuple(troubles)
    verdicts = "1 verdict is about an event" if lost == 1 else f"{lost} verdicts are about events"
    return (*troubles, f"{verdicts} that this log does not have; nothing is deleted")


def read_thumbnail(name: str, path: Path) -> str:
    """The picture for the card of a drive; empty if there is none."""
    try:
        return _thumbnail(Drive.open(name, path))
    except UserError:
        return ""  # its card says why
    except Exception:
        LOGGER.exception("%s has no picture", path)
        return ""


def _thumbnail(drive: Drive) -> str:
    """The picture of a drive's worst moment, or of its middle; empty if it is missing."""
    worst = drive.worst_event()
    moment_s = drive.duration_s / 2 if worst is None else drive.events[worst].peak_s
    pictures = drive.pictures()
    try:
        image = pictures.at(drive.frame_index(drive.row_at(moment_s)))
    except UserError:
        return ""
    finally:
        pictures.close()
    return base64.b64encode(thumbnail_jpeg(image)).decode()


def listed_card(name: str, path: Path, listed: ListedDrive) -> DriveCard:
    """The card of a drive of a batch, from the batch's own list; the review is read again."""
    try:
        review, troubles = read_review(DriveLog(path)) if review_files(path) else (Review(), ())
    except UserError as error:
        return DriveCard(name, path, trouble=str(error))
    judged, lost = judged_events(review, listed.events)
    return DriveCard(
        name,
        path,
        listed.duration_s,
        listed.events,
        imperial=listed.imperial,
        review=review,
        judged=judged,
        thumbnail=base64.b64encode(listed.thumbnail).decode(),
        camera=listed.camera,
        begun_utc_ns=listed.begun_utc_ns,
        notes=listed.notes,
        file=listed.source,
        review_troubles=review_troubles(troubles, len(lost)),
    )
