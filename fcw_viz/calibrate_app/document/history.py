"""What happened to a document: steps of edits, and undo and redo over the steps of everybody."""

from dataclasses import dataclass, replace
from enum import Enum

from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import Edit


class Action(Enum):
    """What an event does to the history."""

    STEP = "step"
    UNDO = "undo"
    REDO = "redo"


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that somebody did.

    Attributes:
        time: when, ISO 8601 with its zone.
        person: who.
        action: what.
        edits: of a step, applied one after the other; empty otherwise.
    """

    time: str
    person: str
    action: Action
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True, slots=True)
class History:
    """The documents from the first one to the last undone one, and which of them counts now.

    Immutable: the next history is made, kept on disk and only then put in place of this one.

    Attributes:
        documents: before the first step, and after each.
        position: of the one that counts.
        people: who did each step, the first one being that from `documents[0]` to `documents[1]`.
    """

    documents: tuple[Document, ...]
    position: int = 0
    people: tuple[str, ...] = ()

    @property
    def document(self) -> Document:
        """The one that counts."""
        return self.documents[self.position]

    @property
    def can_undo(self) -> bool:
        """Whether there is a step before."""
        return self.position > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step."""
        return self.position < len(self.documents) - 1

    def after(self, event: Event) -> "History":
        """The history after one more event; a step forgets the undone ones.

        Raises:
            UserError: an edit cannot be applied, or there is nothing to undo or redo.
        """
        if event.action is Action.UNDO:
            if not self.can_undo:
                raise UserError("there is nothing to undo")
            return replace(self, position=self.position - 1)
        if event.action is Action.REDO:
            if not self.can_redo:
                raise UserError("there is nothing to redo")
            return replace(self, position=self.position + 1)
        document = self.document
        for edit in event.edits:
            document = edit.apply(document)
        return History(
            (*self.documents[: self.position + 1], document),
            self.position + 1,
            (*self.people[: self.position], event.person),
        )
