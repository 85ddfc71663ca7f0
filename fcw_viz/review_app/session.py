"""What all tabs of a review page share: the drives, what people say of them, and who is told of changes."""

import base64
import logging
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import cv2

from fcw.annotation.records import Entry, Said
from fcw.annotation.review import JudgedEvent, Review, judged_events
from fcw.annotation.store import ReviewStore, read_review
from fcw.errors import UserError
from fcw.events import DriveEvent
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.taking import RerunViewers

LOGGER = logging.getLogger(__name__)

DRIVES_KEPT = 4
"""Open drives that nobody looks at any more; the columns of an hour are a few megabytes."""
REFRESH_S = 1.5
"""So often it is looked whether other programs have added to a review."""
FOLDER_TOLD_S = 0.4
"""A folder that is being read is shown anew so often."""
THUMBNAIL_PX, THUMBNAIL_QUALITY = (294, 165), 72

Listener = Callable[[], None]


@dataclass(frozen=True, slots=True, eq=False)
class DriveCard:
    """What the folder list says of a drive.

    Attributes:
        name: of the drive.
        path: its log.
        duration_s: from its first frame to its last.
        events: by time.
        complete: False where the program that wrote it was killed.
        imperial: units of its words.
        review: what people said of it.
        thumbnail: its worst moment, a JPEG in base 64; empty before it was read.
        trouble: why it cannot be read; empty where it can.
        read: False before it was looked at.
    """

    name: str
    path: Path
    duration_s: float = 0.0
    events: tuple[DriveEvent, ...] = ()
    complete: bool = True
    imperial: bool = False
    review: Review = field(default_factory=Review)
    thumbnail: str = ""
    trouble: str = ""
    read: bool = True

    @property
    def severity(self) -> float:
        """Of its worst event; below 0 where there is none."""
        return max((event.severity for event in self.events), default=-1.0)


@dataclass(frozen=True, slots=True, eq=False)
class DriveReview:
    """A drive's review as a tab shows it.

    Attributes:
        review: what counts of all that was said.
        events: the drive's events with their verdicts, by time.
        troubles: what a person should be told of the files.
    """

    review: Review
    events: tuple[JudgedEvent, ...]
    troubles: tuple[str, ...]


@dataclass(slots=True)
class _Open:
    """A drive somebody looks at, or looked at a moment ago."""

    drive: Drive
    store: ReviewStore
    shown: DriveReview


class ReviewSession:
    """The drives of a server and their reviews; every method may be called from any thread.

    Attributes:
        reviewer: in whose name this program writes.
        drives: the logs by their names.
        rerun: viewers that were started from the page.
    """

    def __init__(self, drives: Mapping[str, Path], reviewer: str) -> None:
        """Nothing is read before `start`, or before a drive is opened."""
        self.reviewer = reviewer
        self.drives = dict(drives)
        self.rerun = RerunViewers()
        self._cards = {name: DriveCard(name, path, read=False) for name, path in self.drives.items()}
        self._unread = set(self.drives)
        self._open: OrderedDict[str, _Open] = OrderedDict()
        self._in_use: dict[object, str] = {}
        self._listeners: dict[object, Listener] = {}
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._threads = [
            threading.Thread(target=self._read_cards, name="folder", daemon=True),
            threading.Thread(target=self._watch, name="watch reviews", daemon=True),
        ]

    def start(self) -> None:
        """Read the folder, and watch what others write, each in a thread."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End the threads and the viewers, and let go of the files."""
        self.rerun.close()
        self._stop.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join()
        with self._lock:
            for opened in self._open.values():
                opened.store.close()
            self._open.clear()

    # Who is here

    def join(self, person: object, listener: Listener) -> None:
        """Have a listener called, from any thread, whenever anything has changed."""
        with self._lock:
            self._listeners[person] = listener

    def leave(self, person: object) -> None:
        """Somebody goes."""
        with self._lock:
            self._listeners.pop(person, None)
            self._in_use.pop(person, None)

    # The folder

    @property
    def cards(self) -> tuple[DriveCard, ...]:
        """Every drive, the one with the worst event first; those not read yet come last."""
        with self._lock:
            cards = list(self._cards.values())
            return tuple(sorted(cards, key=_list_key))

    @property
    def unread(self) -> int:
        """How many drives have still to be read for the list."""
        with self._lock:
            return len(self._unread)

    # One drive

    def open(self, person: object, name: str) -> Drive:
        """The drive of a name, for somebody who looks at it from now on.

        Raises:
            UserError: there is no such drive, or it cannot be read.
        """
        if name not in self.drives:
            raise UserError(f"no drive {name!r} here; choose one of the list")
        with self._lock:
            opened = self._open.get(name)
        if opened is None:
            drive = Drive.open(name, self.drives[name])
            with self._lock:
                opened = self._open.get(name)
                if opened is None:
                    store = ReviewStore(drive.log)
                    opened = self._open[name] = _Open(drive, store, _shown(drive, store))
        with self._lock:
            self._open.move_to_end(name)
            self._in_use[person] = name
            self._let_go()
        return opened.drive

    def release(self, person: object) -> None:
        """Somebody looks at no drive any more."""
        with self._lock:
            self._in_use.pop(person, None)
            self._let_go()

    def review(self, name: str) -> DriveReview:
        """What is said of an open drive by now."""
        with self._lock:
            return self._open[name].shown

    def say(self, name: str, *said: Said) -> tuple[Entry[Said], ...]:
        """Keep what the reviewer says of an open drive; it is on the disk when this returns.

        Raises:
            UserError: it cannot be kept; what was not kept does not count.
        """
        entries: list[Entry[Said]] = []
        try:
            with self._lock:
                opened = self._open[name]
                for one in said:
                    entries.append(opened.store.add(self.reviewer, one))
        finally:
            with self._lock:
                self._show(name)
            self._publish()
        return tuple(entries)

    def take_back(self, name: str, entry_id: str) -> Entry[Said]:
        """Take back something the reviewer said of an open drive; taking that back says it again.

        Raises:
            UserError: it was another person, or it cannot be kept.
        """
        with self._lock:
            entry = self._open[name].store.take_back(self.reviewer, entry_id)
            self._show(name)
        self._publish()
        return entry

    def _show(self, name: str) -> None:
        """Bring what is shown of a drive to what its store knows; the caller holds the lock."""
        opened = self._open[name]
        opened.shown = _shown(opened.drive, opened.store)
        thumbnail = self._cards[name].thumbnail
        self._cards[name] = _card(name, self.drives[name], opened.drive, opened.shown.review, thumbnail)

    def _let_go(self) -> None:
        """Close drives that nobody looks at; the caller holds the lock."""
        idle = [name for name in self._open if name not in self._in_use.values()]
        for name in idle[: max(len(idle) - DRIVES_KEPT, 0)]:
            self._open.pop(name).store.close()

    def _publish(self) -> None:
        with self._lock:
            listeners = list(self._listeners.values())
        for listener in listeners:
            try:
                listener()
            except Exception:
                LOGGER.exception("a tab could not be told of a change")

    def _read_cards(self) -> None:
        """Read the drives for the list, one after the other."""
        told_s = -math.inf
        for name, path in self.drives.items():
            if self._stop.is_set():
                return
            card = _read_card(name, path)
            with self._lock:
                self._unread.discard(name)
                self._cards[name] = card
                if name in self._open:
                    self._show(name)
            if time.monotonic() - told_s > FOLDER_TOLD_S or not self.unread:
                told_s = time.monotonic()
                self._publish()

    def _watch(self) -> None:
        """See what other programs add to the reviews of the drives that are open."""
        while not self._stop.wait(REFRESH_S):
            changed = False
            with self._lock:
                for name, opened in self._open.items():
                    try:
                        if opened.store.refresh():
                            self._show(name)
                            changed = True
                    except UserError as error:
                        LOGGER.warning("%s", error)
            if changed:
                self._publish()


def _list_key(card: DriveCard) -> tuple[bool, bool, float, int, str]:
    """Drives not read yet come last, before them those that cannot be read; the worst is first."""
    return not card.read, bool(card.trouble), -card.severity, -len(card.events), card.name


def _shown(drive: Drive, store: ReviewStore) -> DriveReview:
    judged, lost = judged_events(store.review, drive.events)
    troubles = list(store.troubles)
    if lost:
        verdicts = f"{len(lost)} verdict{'s' * (len(lost) != 1)}"
        troubles.append(f"{verdicts} are about events that are not found any more; they are kept")
    return DriveReview(store.review, judged, tuple(troubles))


def _read_card(name: str, path: Path) -> DriveCard:
    try:
        drive = Drive.open(name, path)
        review, _ = read_review(drive.log)
        thumbnail = _thumbnail(drive)
    except UserError as error:
        return DriveCard(name, path, trouble=str(error))
    except Exception:
        LOGGER.exception("%s cannot be read", path)
        return DriveCard(name, path, trouble=f"{path}: cannot be read; the program's terminal says why")
    return _card(name, path, drive, review, thumbnail)


def _card(name: str, path: Path, drive: Drive, review: Review, thumbnail: str) -> DriveCard:
    return DriveCard(
        name,
        path,
        drive.duration_s,
        drive.events,
        drive.complete,
        drive.header.imperial,
        review,
        thumbnail,
    )


def _thumbnail(drive: Drive) -> str:
    """The picture of a drive's worst moment, or of its middle; empty where it is missing."""
    worst = drive.worst_event()
    moment_s = drive.duration_s / 2 if worst is None else drive.events[worst].peak_s
    pictures = drive.pictures()
    try:
        image = pictures.at(drive.frame_index(drive.row_at(moment_s)))
    except UserError:
        return ""
    finally:
        pictures.close()
    width_px, height_px = THUMBNAIL_PX
    scale = max(width_px / image.shape[1], height_px / image.shape[0])
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, THUMBNAIL_QUALITY])
    return base64.b64encode(data.tobytes()).decode()
