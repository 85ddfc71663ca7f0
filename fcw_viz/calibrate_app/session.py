"""One calibration worked on by all tabs: who does what, what it makes of the document, and who is told."""

import functools
import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.camera.file import write_calibration
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edit_form import edit_from_json, edit_to_json
from fcw_viz.calibrate_app.document.edits import Edit, Load
from fcw_viz.calibrate_app.document.history import Action, Event
from fcw_viz.calibrate_app.document.journal import file_digest
from fcw_viz.calibrate_app.document.resume import Beginning, begin, now
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import Result, SessionState, Solution, Status

LOGGER = logging.getLogger(__name__)

SOLUTIONS_KEPT = 256
"""Undo and redo over as many steps find their solutions ready."""
RESULTS_KEPT = 4096
"""How far back the last good result is looked for without solving again, for each event of a drag."""

Listener = Callable[[SessionState], None]


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody at a tab.

    Attributes:
        name: what the others are shown, e.g. "tab 1".
    """

    name: str


@dataclass(slots=True)
class _Seat:
    """A listener and the last revision it has seen."""

    listener: Listener
    revision: int


class CalibrationSession:
    """The one document of a server; every method may be called from any thread.

    Each event is on the disk before it counts, so the state always equals a replay of the journal. Previews
    are the one exception: while somebody drags, the drag is shown and not kept.
    """

    def __init__(self, beginning: Beginning, save_path: Path) -> None:
        """Use `open`."""
        self._save_path = save_path
        self._journal = beginning.journal
        self._history = beginning.history
        self._saved = beginning.saved
        self._saved_stamp = _stamp(save_path)
        self._notice = beginning.notice
        self._previews: dict[Person, Edit] = {}
        self._people: list[Person] = []
        self._seats: dict[Person, _Seat] = {}
        self._tabs = 0
        self._solve = functools.lru_cache(SOLUTIONS_KEPT)(solve)
        self._result = functools.lru_cache(RESULTS_KEPT)(lambda document: solve(document, False).result)
        self._lock = threading.RLock()
        self._publishing = False
        self._state = self._next_state(0)

    @classmethod
    def open(
        cls,
        source: Path,
        image_size: ImageSize,
        save_path: Path,
        notice: str = "",
        fitted: Callable[[Calibration], Calibration] | None = None,
    ) -> "CalibrationSession":
        """Resume the journal beside `save_path`, else take the points of the calibration there, else none.

        Args:
            source: what the pictures come from.
            image_size: of the pictures.
            save_path: where the calibration is saved.
            notice: what everybody should know of the source.
            fitted: gives a saved calibration for the pictures; None where at most their size differs.

        Raises:
            UserError: the journal is in use by another page, damaged, for pictures of another size, or cannot
                be written.
        """
        beginning = begin(source, image_size, save_path, fitted)
        notices = " ".join(filter(None, (notice, beginning.notice)))
        return cls(replace(beginning, notice=notices), save_path)

    @property
    def state(self) -> SessionState:
        """The present moment."""
        with self._lock:
            return self._state

    def join(self, listener: Listener) -> Person:
        """Somebody comes; the listener gets the present state before this returns, and each later one.

        Listeners are called in the order of the states, from whatever thread made the change; several
        changes at once may come as one state, the last. What a listener raises is logged.
        """
        with self._lock:
            self._tabs += 1
            person = Person(f"tab {self._tabs}")
            self._people.append(person)
            state = self._change()
        _call(listener, state)
        with self._lock:
            self._seats[person] = _Seat(listener, state.revision)
        self._publish()
        return person

    def leave(self, person: Person) -> None:
        """Somebody goes; what they were dragging stays where it was."""
        with self._lock:
            if person not in self._people:
                return
            self._people.remove(person)
            self._seats.pop(person, None)
            self._previews.pop(person, None)
            self._change()
        self._publish()

    def apply(self, person: Person, *edits: Edit) -> None:
        """Make edits, as one step of undo; ends this person's preview.

        Raises:
            UserError: one of them cannot be applied, or the step cannot be kept; nothing changes then, but
                that the preview ends.
        """
        # Through their form on the disk, so that the state is what a replay gives, to the last bit.
        self._do(person, Action.STEP, lambda: tuple(edit_from_json(edit_to_json(edit)) for edit in edits))

    def preview(self, person: Person, edit: Edit | None) -> None:
        """Show an edit to all without keeping it, while somebody drags.

        It holds until the person's next preview, step, undo or redo; those of others go on beside it. None
        takes it back.
        """
        with self._lock:
            # The last to move is on top.
            self._previews.pop(person, None)
            if edit is not None and person in self._people:
                self._previews[person] = edit
            self._change()
        self._publish()

    def undo(self, person: Person) -> None:
        """Take back the last step, whoever made it; of somebody else's everybody is told.

        Raises:
            UserError: there is none, or this cannot be kept.
        """
        with self._lock:
            position = self._history.position
            maker = self._history.people[position - 1] if position else person.name
            others = maker != person.name and maker in self._others(person)
            told = f"{person.name} undid a step of {maker}; redo restores it." if others else ""
            self._do(person, Action.UNDO, notice=told)

    def redo(self, person: Person) -> None:
        """Make the last undone step again.

        Raises:
            UserError: there is none, or this cannot be kept.
        """
        self._do(person, Action.REDO)

    def start_anew(self, person: Person) -> None:
        """Empty the document; can be undone.

        Raises:
            UserError: this cannot be kept.
        """
        with self._lock:
            document = self._history.document
            self.apply(person, Load(Document(document.image_size, imperial=document.imperial)))

    def save(self) -> Path:
        """Write the calibration file; an implausible calibration is written too.

        Returns:
            The file.

        Raises:
            UserError: something has still to be said, the points determine no camera, or the file cannot be
                written.
        """
        with self._lock:
            solution = self._solve(self._history.document)
            if not solution.can_save or solution.result is None:
                raise UserError(f"not saved: {_why_not(solution)}")
            calibration = solution.result.calibration
            write_calibration(calibration, self._save_path, solution.warnings)
            self._saved, self._saved_stamp = calibration, _stamp(self._save_path)
            # Without this line a resumed session compares what the file holds, which tells as well.
            with suppress(UserError):
                self._journal.add_saved(file_digest(self._save_path))
            self._change()
        self._publish()
        return self._save_path

    def look_at_file(self) -> None:
        """Tell everybody where the saved file was changed or deleted by another hand."""
        with self._lock:
            if not self._state.saved or _stamp(self._save_path) == self._saved_stamp:
                return
            self._saved = None
            self._notice = f"{self._save_path.name} was changed or deleted elsewhere; saving writes it again."
            self._change()
        self._publish()

    def announce(self, address: str) -> None:
        """Keep the page's address, which whoever starts a second page on this work is told.

        Raises:
            UserError: it cannot be written.
        """
        with self._lock:
            self._journal.add_page(address)

    def close(self) -> None:
        """Let go of the journal; one in which nothing ever happened is removed."""
        with self._lock:
            self._journal.close()

    def _others(self, person: Person) -> set[str]:
        return {other.name for other in self._people if other != person}

    def _do(
        self,
        person: Person,
        action: Action,
        edits: Callable[[], tuple[Edit, ...]] = tuple,
        notice: str = "",
    ) -> None:
        try:
            with self._lock:
                ended = self._previews.pop(person, None)
                try:
                    event = Event(now(), person.name, action, edits())
                    history = self._history.after(event)
                    # A step that a fault of ours cannot solve must not be kept: no page could open it again.
                    self._solve(history.document)
                    self._journal.add(event)
                except BaseException:
                    if ended is not None:
                        self._change()
                    raise
                self._history = history
                self._notice = notice
                self._change()
        finally:
            self._publish()

    def _change(self) -> SessionState:
        """Make the next state; the caller holds the lock, and publishes after."""
        self._state = self._next_state(self._state.revision + 1)
        return self._state

    def _next_state(self, revision: int) -> SessionState:
        committed = self._solve(self._history.document)
        document, solution = self._history.document, committed
        for edit in self._previews.values():
            try:
                document = edit.apply(document)
            except UserError:
                # What is being dragged was deleted in the meantime.
                continue
        if document != self._history.document:
            solution = replace(solve(document, effects=False), effects=committed.effects)
        calibration = None if committed.result is None else committed.result.calibration
        return SessionState(
            revision=revision,
            document=document,
            solution=solution,
            shown=solution.result or self._last_good(),
            current=solution.result is not None,
            can_undo=self._history.can_undo,
            can_redo=self._history.can_redo,
            save_path=self._save_path,
            saved=committed.can_save and calibration is not None and calibration == self._saved,
            people=tuple(person.name for person in self._people),
            notice=self._notice,
        )

    def _last_good(self) -> Result | None:
        """The result of the last step that had one, since there was no mark at all."""
        for document in reversed(self._history.documents[: self._history.position + 1]):
            result = self._result(document)
            if result is not None or not document.marks:
                return result
        return None

    def _publish(self) -> None:
        """Tell everybody; one thread at a time does so for all, hence in order."""
        while True:
            with self._lock:
                state = self._state
                seats = [seat for seat in self._seats.values() if seat.revision < state.revision]
                if self._publishing or not seats:
                    return
                self._publishing = True
            try:
                for seat in seats:
                    seat.revision = state.revision
                    _call(seat.listener, state)
            finally:
                with self._lock:
                    self._publishing = False


def _stamp(path: Path) -> tuple[int, int, int] | None:
    """By which a change of a file is noticed; None where it is not there."""
    try:
        state = path.stat()
    except OSError:
        return None
    return state.st_ino, state.st_size, state.st_mtime_ns


def _call(listener: Listener, state: SessionState) -> None:
    try:
        listener(state)
    except Exception:
        LOGGER.exception("a tab could not show revision %d", state.revision)


def _why_not(solution: Solution) -> str:
    if solution.status is Status.DEGENERATE:
        return " ".join(trouble.text for trouble in solution.troubles)
    return f"something is still missing. {solution.hint}"
