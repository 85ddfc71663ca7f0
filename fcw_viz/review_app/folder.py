"""The drives that a page serves: their list, which is kept up to date."""

import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from fcw.annotation.store import review_files
from fcw.batch.ledger import DRIVES_NAME, Record
from fcw.batch.review_list import read_review_list
from fcw.batch.tables import unfinished_drives
from fcw.errors import UserError
from fcw.logs.export.clip import find_drives
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.drive_card import DriveCard, list_key, listed_card, read_card, read_thumbnail

LOOK_S = 1.0
"""How often the folder is checked for changes."""
TOLD_S = 0.8
"""Interval at which the list is updated while it is read; each update takes the browser tens of
milliseconds."""
PICTURES_S = 2.0
"""How long pictures are read before the folder is checked again."""

_Stamp = tuple[tuple[str, int, int], ...]


class Folder:
    """The list of drives; thread-safe."""

    def __init__(self, drives: Mapping[str, Path], root: Path | None, publish: Callable[[], None]) -> None:
        """Make the list; nothing is read before `start`.

        Args:
            drives: the logs by name.
            root: the folder in which they were found, where new ones may appear; None if there is none.
            publish: called when the list has changed.
        """
        self._drives, self._root, self._publish = dict(drives), root, publish
        self._cards = {name: DriveCard(name, path, read=False) for name, path in drives.items()}
        self._stamps: dict[str, _Stamp] = {}
        self._growing: dict[str, Drive] = {}
        self._unread = set(drives)
        self._pictured: set[str] = set()
        self._unfinished: tuple[Record, ...] = ()
        self._tables_stamp: tuple[int, int] | None = None
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="folder", daemon=True)

    def start(self) -> None:
        """Read the drives and follow changes, in a thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def drives(self) -> dict[str, Path]:
        """The logs by name."""
        with self._lock:
            return dict(self._drives)

    @property
    def several(self) -> bool:
        """Whether there are several drives, or may be later."""
        return self._root is not None or len(self._drives) > 1

    @property
    def cards(self) -> tuple[DriveCard, ...]:
        """Every drive, the one with the worst event first; those not read yet come last."""
        with self._lock:
            return tuple(sorted(self._cards.values(), key=list_key))

    @property
    def unfinished(self) -> tuple[Record, ...]:
        """Unfinished drives by name, if the folder is that of a batch."""
        with self._lock:
            return self._unfinished

    @property
    def unread(self) -> int:
        """How many drives have not been read yet."""
        with self._lock:
            return len(self._unread)

    def thumbnail(self, name: str) -> str:
        """The picture for the card of a drive; empty before it was read."""
        with self._lock:
            card = self._cards.get(name)
            return "" if card is None else card.thumbnail

    def put(self, card: DriveCard) -> None:
        """Replace the card of a drive."""
        with self._lock:
            if card.name in self._cards:
                self._cards[card.name] = card

    def _follow(self) -> None:
        told_s = -math.inf
        if self._root is not None:
            self._find_unfinished()
            self._take_list(self._root)
        while not self._stop.is_set():
            changed = self._find() | self._find_unfinished()
            for name, path in self.drives.items():
                if self._stop.is_set():
                    return
                stamp = _stamp(path)
                if self._stamps.get(name) == stamp:
                    continue
                self._read(name, path)
                self._stamps[name], changed = stamp, True
                if time.monotonic() - told_s > TOLD_S:
                    told_s, changed = time.monotonic(), False
                    self._publish()
            if changed:
                self._publish()
            self._add_pictures()
            self._stop.wait(LOOK_S)

    def _add_pictures(self) -> None:
        """Add pictures to the cards, from the top of the list, until something has changed.

        All cards are read before the first picture, so that the list is soon sorted and can be searched.
        """
        told_s, changed = time.monotonic(), False
        end_s = told_s + PICTURES_S
        for card in self.cards:
            if self._stop.is_set() or time.monotonic() > end_s:
                break
            if card.name in self._pictured or not card.read or card.trouble:
                continue
            self._pictured.add(card.name)
            thumbnail = read_thumbnail(card.name, card.path)
            with self._lock:
                now = self._cards.get(card.name)
                if now is not None:
                    self._cards[card.name], changed = replace(now, thumbnail=thumbnail), True
            if changed and time.monotonic() - told_s > TOLD_S:
                told_s, changed = time.monotonic(), False
                self._publish()
        if changed:
            self._publish()

    def _take_list(self, root: Path) -> None:
        """Show the list that a batch wrote, at once; later changes are read as for any drive."""
        listed = read_review_list(root)
        for name, path in self.drives.items():
            one = listed.get(path)
            if one is None or self._stop.is_set():
                continue
            self._stamps[name] = _stamp(path)
            card = listed_card(name, path, one)
            with self._lock:
                self._cards[name] = card
                self._pictured.add(name)
                self._unread.discard(name)
        if listed:
            self._publish()

    def _find(self) -> bool:
        """Add new drives and remove those that are gone; returns whether there are any."""
        if self._root is None:
            return False
        try:
            found = find_drives([self._root])
        except (UserError, OSError):
            found = {}  # the last one has gone, or the folder itself
        with self._lock:
            known, there = set(self._drives.values()), set(found.values())
            new = {name: path for name, path in found.items() if path not in known}
            gone = [name for name, path in self._drives.items() if path not in there]
            for name in gone:
                for kept in (self._drives, self._cards, self._stamps, self._growing):
                    kept.pop(name, None)
                self._pictured.discard(name)
                self._unread.discard(name)
            for wanted, path in new.items():
                # Known drives keep their names, which are part of the addresses of open pages.
                name, number = wanted, 2
                while name in self._drives:
                    name, number = f"{wanted} ({number})", number + 1
                self._drives[name] = path
                self._cards[name] = DriveCard(name, path, read=False)
                self._unread.add(name)
        return bool(new or gone)

    def _find_unfinished(self) -> bool:
        """Find the unfinished drives of a batch; returns whether they have changed."""
        if self._root is None:
            return False
        try:
            state = (self._root / DRIVES_NAME).stat()
        except OSError:
            return False
        stamp = state.st_size, state.st_mtime_ns
        if stamp == self._tables_stamp:
            return False
        self._tables_stamp, before = stamp, self._unfinished
        with self._lock:
            self._unfinished = unfinished_drives(self._root)
        return self._unfinished != before

    def _read(self, name: str, path: Path) -> None:
        """Read the card of a drive; if it is still being written, only what is new is read."""
        drive = self._growing.pop(name, None)
        try:
            drive = Drive.open(name, path) if drive is None or _is_other(drive, path) else drive.grown()
        except Exception:  # whatever a damaged file raises: its card says so, and the others are read
            drive = None
        card = read_card(name, path, drive, self.thumbnail(name))
        # Its worst moment may be another one by now.
        self._pictured.discard(name)
        if drive is not None and not drive.complete:
            self._growing[name] = drive
        with self._lock:
            self._unread.discard(name)
            if name in self._drives:
                self._cards[name] = card


def _stamp(path: Path) -> _Stamp:
    """A stamp that shows whether a drive or its review has changed."""
    try:
        states = [(file.name, file.stat()) for file in (path, *review_files(path))]
    except (OSError, UserError):
        return ()
    return tuple((name, state.st_size, state.st_mtime_ns) for name, state in states)


def _is_other(drive: Drive, path: Path) -> bool:
    return drive.log.path != path or drive.watch.look().is_other
