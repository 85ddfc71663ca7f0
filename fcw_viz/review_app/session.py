"""What all tabs of a review page share: the drives, their reviews, and listeners for changes."""

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from fcw.annotation.records import Entry, Said, TakenBack
from fcw.annotation.review import JudgedEvent, Review, judged_events
from fcw.annotation.store import ReviewStore
from fcw.errors import UserError
from fcw.logs.mcap.following import LogChange
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.drive_card import DriveCard, card_of, review_troubles
from fcw_viz.review_app.folder import Folder
from fcw_viz.review_app.taking import RerunViewers

LOGGER = logging.getLogger(__name__)

DRIVES_KEPT = 4
"""Number of drives that stay open after their tabs left; the columns of an hour take a few megabytes."""
REFRESH_S = 1.0
"""How often it is checked whether other programs have added to a review or a drive."""

Listener = Callable[[], None]


@dataclass(frozen=True, slots=True, eq=False)
class DriveReview:
    """The review of a drive as a tab shows it.

    Attributes:
        review: the review.
        events: the events of the drive with their verdicts, by time.
        troubles: messages about the files for the user.
    """

    review: Review
    events: tuple[JudgedEvent, ...]
    troubles: tuple[str, ...]


@dataclass(slots=True)
class _Open:
    """A drive that is open in a tab, or was a moment ago."""

    drive: Drive
    store: ReviewStore
    shown: DriveReview


class ReviewSession:
    """The drives of a server and their reviews; thread-safe.

    Attributes:
        reviewer: name under which this program writes.
        folder: the list of the drives.
        rerun: viewers that were started from the page.
    """

    def __init__(self, drives: Mapping[str, Path], reviewer: str, root: Path | None = None) -> None:
        """Make the session; nothing is read before `start`, or before a drive is opened.

        Args:
            drives: the logs by name.
            reviewer: name under which this program writes.
            root: the folder in which they were found, where new ones may appear; None if there is none.
        """
        self.reviewer = reviewer
        self.folder = Folder(drives, root, self._publish)
        self.rerun = RerunViewers()
        self._open: OrderedDict[str, _Open] = OrderedDict()
        self._in_use: dict[object, str] = {}
        self._listeners: dict[object, Listener] = {}
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="watch", daemon=True)

    def start(self) -> None:
        """Read the folder, and watch for changes by other programs, each in a thread."""
        self.folder.start()
        self._thread.start()

    def close(self) -> None:
        """End the threads and the viewers, and close the files."""
        self.rerun.close()
        self._stop.set()
        self.folder.close()
        if self._thread.is_alive():
            self._thread.join()
        with self._lock:
            for opened in self._open.values():
                opened.store.close()
            self._open.clear()

    # Who is here

    def join(self, person: object, listener: Listener) -> None:
        """Register a listener, which is called, from any thread, whenever anything has changed."""
        with self._lock:
            self._listeners[person] = listener

    def leave(self, person: object) -> None:
        """Remove somebody's listener, and release their drive."""
        with self._lock:
            self._listeners.pop(person, None)
            self._in_use.pop(person, None)

    # The folder

    @property
    def drives(self) -> dict[str, Path]:
        """The logs by name."""
        return self.folder.drives

    @property
    def cards(self) -> tuple[DriveCard, ...]:
        """Every drive, the one with the worst event first; those not read yet come last."""
        return self.folder.cards

    @property
    def unread(self) -> int:
        """How many drives have not been read yet."""
        return self.folder.unread

    # One drive

    def open(self, person: object, name: str) -> Drive:
        """Open the drive with this name for somebody, who looks at it from now on.

        Raises:
            UserError: there is no such drive, or it cannot be read.
        """
        path = self.drives.get(name)
        if path is None:
            raise UserError(f"no drive {name!r} here; choose one from the list")
        with self._lock:
            opened = self._open.get(name)
            replaced = opened is not None and opened.drive.watch.look() is LogChange.REPLACED
        drive = Drive.open(name, path) if opened is None or replaced else opened.drive
        with self._lock:
            before = self._open.get(name)
            if before is None or (replaced and before is opened):  # else somebody else was quicker
                store = ReviewStore(drive.log)
                self._open[name] = _Open(drive, store, _shown(drive, store))
                if before is not None:
                    before.store.close()
            drive = self._open[name].drive
            self._open.move_to_end(name)
            self._in_use[person] = name
            self._let_go()
        if replaced:
            self._publish()  # who looks at the old one is told
        return drive

    def release(self, person: object) -> None:
        """Release somebody's drive."""
        with self._lock:
            self._in_use.pop(person, None)
            self._let_go()

    def current(self, name: str) -> Drive:
        """An open drive in its present state: it may have grown or been replaced."""
        with self._lock:
            return self._open[name].drive

    def review(self, name: str, seen: Drive | None = None) -> DriveReview:
        """The present review of an open drive.

        Args:
            name: name of the drive.
            seen: the drive as somebody still sees it; the events are those of this state.
        """
        with self._lock:
            opened = self._open[name]
            return opened.shown if seen is None or seen is opened.drive else _shown(seen, opened.store)

    def say(self, name: str, *said: Said, seen: Drive | None = None) -> tuple[Entry[Said], ...]:
        """Store what the reviewer says about an open drive; it is on the disk when this returns.

        Args:
            name: name of the drive.
            said: one or several things, which are stored together.
            seen: the drive as the reviewer sees it.

        Raises:
            UserError: it cannot be stored; then it does not count.
        """
        with self._lock:
            entries = self._told(name, seen).store.add_all(self.reviewer, said)
            self._show(name)
        self._publish()
        return entries

    def take_back(self, name: str, entry_id: str) -> Entry[Said]:
        """Take back something that the reviewer said about an open drive; a `TakenBack` too.

        Raises:
            UserError: somebody else said it, or it cannot be stored.
        """
        return self.say(name, TakenBack(entry_id))[0]

    def _show(self, name: str) -> None:
        """Update what is shown of a drive from its store; the caller holds the lock."""
        opened = self._open[name]
        opened.shown = _shown(opened.drive, opened.store)
        store, thumbnail = opened.store, self.folder.thumbnail(name)
        self.folder.put(card_of(opened.drive, store.review, store.troubles, thumbnail))

    def _told(self, name: str, seen: Drive | None) -> _Open:
        """The open drive with this name, if it is still the one that was seen; the caller holds the lock."""
        opened = self._open[name]
        if (seen or opened.drive).origin is not opened.drive.origin or opened.drive.watch.look().is_other:
            raise UserError(
                f"{opened.drive.log.path}: the log was replaced or deleted while it was open here, so "
                "nothing is kept for it; open the drive again"
            )
        return opened

    def _let_go(self) -> None:
        """Close drives that no tab shows; the caller holds the lock."""
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

    def _watch(self) -> None:
        """Watch for what other programs add to the open drives and their reviews."""
        while not self._stop.wait(REFRESH_S):
            changed = False
            with self._lock:
                names = list(self._open)
            for name in names:
                try:
                    changed |= self._refresh(name)
                except UserError as error:
                    LOGGER.warning("%s", error)
                except Exception:
                    LOGGER.exception("%s cannot be followed", name)
            if changed:
                self._publish()

    def _refresh(self, name: str) -> bool:
        """Update an open drive from the disk; returns whether anything is new."""
        with self._lock:
            opened = self._open.get(name)
        if opened is None:
            return False
        drive, change = opened.drive, opened.drive.watch.look()
        if change is LogChange.GROWN:
            drive = drive.grown()
        elif change is LogChange.REPLACED:
            drive = Drive.open(name, drive.log.path)
        elif change is LogChange.GONE:
            return False  # who says something of it is told
        with self._lock:
            if self._open.get(name) is not opened:
                return False
            if change is LogChange.REPLACED:
                before, opened.store = opened.store, ReviewStore(drive.log)
                before.close()
            opened.drive = drive
            if not opened.store.refresh() and change is LogChange.NONE:
                return False
            self._show(name)
        return True


def _shown(drive: Drive, store: ReviewStore) -> DriveReview:
    judged, lost = judged_events(store.review, drive.events)
    return DriveReview(store.review, judged, review_troubles(store.troubles, len(lost)))
