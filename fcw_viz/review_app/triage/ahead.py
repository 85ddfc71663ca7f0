"""What the next unjudged event shows is read while somebody still looks at something else."""

import threading

from fcw.errors import UserError
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.place import Place


class Ahead:
    """Reads ahead for one tab, in threads of its own."""

    def __init__(self, place: Place) -> None:
        """Nothing is read before `look`.

        Args:
            place: where the person of the tab is.
        """
        self._place = place
        self._lock = threading.Lock()
        self._reads = self._closed = False
        self._ready: tuple[Drive, FramePictures] | None = None

    def look(self) -> None:
        """Find the event that `U` would lead to, and have its drive and picture read if it is in another."""
        with self._lock:
            if self._reads or self._closed or self._place.session.unread:
                return
            self._reads = True
        place = self._place
        name = None if place.drive is None else place.drive.name
        threading.Thread(
            target=self._read, args=(name, place.selected), name="read ahead", daemon=True
        ).start()

    def take(self, drive: Drive) -> FramePictures:
        """The pictures of a drive, which may stand at the wanted one already."""
        with self._lock:
            ready, self._ready = self._ready, None
        if ready is not None:
            if ready[0] is drive:
                return ready[1]
            ready[1].close()
        return FramePictures(drive)

    def close(self) -> None:
        """Let go of what was read; from whichever thread."""
        with self._lock:
            self._closed = True
            ready, self._ready = self._ready, None
        if ready is not None:
            ready[1].close()
        self._place.session.leave(self)

    def _read(self, name: str | None, selected: int | None) -> None:
        place, session = self._place, self._place.session
        try:
            found = place.asked.next_unjudged(session.cards, name, selected)
            if found is None or found[0] == name:
                return
            drive = session.open(self, found[0])
            with self._lock:
                if self._ready is not None and self._ready[0] is drive:
                    return
            pictures = FramePictures(drive)
            if found[1] < len(drive.events):
                row = drive.row_at(drive.events[found[1]].peak_s)
                pictures.image(row, pictures.result(row))
            with self._lock:
                before, self._ready = self._ready, None if self._closed else (drive, pictures)
            if before is not None:
                before[1].close()
            if self._closed:
                pictures.close()
                session.leave(self)
        except UserError:
            return  # who goes there is told
        finally:
            with self._lock:
                self._reads = False
