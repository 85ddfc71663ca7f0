"""The history of a document: steps of edits, with undo and redo over the steps of all people."""

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
    """One action of a person.

    Attributes:
        time: when it happened, ISO 8601 with time zone.
        person: who did it.
        action: what was done.
        edits: the edits of a step, which are applied in order; else empty.
    """

    time: str
    person: str
    action: Action
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True, slots=True)
class History:
    """The documents from the first one to the last undone one, and which one is current.

    It is immutable: the next history is made, stored on disk, and only then replaces this one.

    Attributes:
        documents: the documents before the first step and after each one.
        position: index of the current document.
        people: who did each step, beginning with that from `documents[0]` to `documents[1]`.
    """

    documents: tuple[Document, ...]
    position: int = 0
    people: tuple[str, ...] = ()

    @property
    def document(self) -> Document:
        """The current document."""
        return self.documents[self.position]

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return self.position > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to redo."""
        return self.position < len(self.documents) - 1

    def after(self, event: Event) -> "History":
        """The history after one more event; a new step removes the undone ones.

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
