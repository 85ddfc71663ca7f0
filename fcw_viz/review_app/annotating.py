"""What a person says of a drive in a tab: verdicts, missed events, notes, and taking them back."""

from collections.abc import Callable, Mapping

from fcw.annotation.records import Entry, Judgement, MissedEvent, Note, Reason, Said, TakenBack, Verdict
from fcw.annotation.review import reference_to
from fcw.errors import UserError
from fcw.warning.types import WarningLevel
from fcw_viz.review_app.place import Place

MISSED_BEFORE_S, MISSED_AFTER_S = 1.0, 1.0
"""A missed event reaches so far around the moment at which it is added."""


class Annotating:
    """What the person of one tab says; it is kept, and told to the other tabs, at once."""

    def __init__(self, place: Place, notify: Callable[[str, str], object]) -> None:
        """Nothing is said yet.

        Args:
            place: where the person is.
            notify: tells the person something, as a title and a text.
        """
        self._place, self._notify = place, notify
        self._said: list[tuple[str, str]] = []
        self._taken_back: list[tuple[str, str]] = []

    @property
    def messages(self) -> Mapping[str, Callable[[str], object]]:
        """What the page's elements say, and what is done then."""
        return {
            "verdict": lambda about: self.judge(Judgement[about]),
            "reason": lambda about: self.give_reason(Reason[about] if about else None),
            "takeback": self.take_back,
            "explain": self.explain,
            "note": self.add_note,
            "missed": self.add_missed,
        }

    def judge(self, judgement: Judgement) -> None:
        """Give a verdict on the selected event; the same one again takes it back."""
        own = self.own_verdict
        if own is not None and own.said.judgement is judgement:
            self.take_back(own.entry_id)
            return
        self._judge(judgement, None, own.said.text if own is not None else "")

    def give_reason(self, reason: Reason | None) -> None:
        """Say why, with the verdict that was given."""
        own = self._told_verdict()
        self._judge(own.said.judgement, reason, own.said.text)

    def explain(self, text: str) -> None:
        """Say more in own words, with the verdict that was given."""
        own = self._told_verdict()
        self._judge(own.said.judgement, own.said.reason, text.strip())

    def add_note(self, text: str) -> None:
        """Remark something on the moment that is shown."""
        self.say(Note(self._place.time_s, text.strip()))

    def add_missed(self, text: str = "", level: WarningLevel = WarningLevel.WARNING) -> None:
        """Say that a warning was missed around the moment that is shown."""
        time_s, duration_s = self._place.time_s, self._place.opened.duration_s
        start_s, end_s = max(time_s - MISSED_BEFORE_S, 0.0), min(time_s + MISSED_AFTER_S, duration_s)
        self.say(MissedEvent(start_s, end_s, text.strip(), level))
        self._notify("Missed event added", "It stands on the time line. Ctrl Z takes it back.")

    def say(self, *said: Said) -> None:
        """Keep something said of the open drive."""
        name = self._place.opened.name
        for entry in self._place.session.say(name, *said):
            self._said.append((name, entry.entry_id))
        self._taken_back.clear()

    def take_back(self, entry_id: str) -> None:
        """Take back one of the reviewer's own words."""
        name = self._place.opened.name
        taken_back = self._place.session.take_back(name, entry_id)
        self._said = [said for said in self._said if said[1] != entry_id]
        self._taken_back.append((name, taken_back.entry_id))

    def undo(self) -> None:
        """Take back what was said last in this tab of this drive."""
        name = self._place.opened.name
        last = next((said for said in reversed(self._said) if said[0] == name), None)
        if last is None:
            raise UserError("nothing to undo here; older words are taken back in the list of remarks")
        self.take_back(last[1])

    def redo(self) -> None:
        """Say again what was taken back last in this tab of this drive."""
        name = self._place.opened.name
        last = next((said for said in reversed(self._taken_back) if said[0] == name), None)
        if last is None:
            raise UserError("nothing to do again")
        self._taken_back.remove(last)
        target = self._target(last[1])
        self._place.session.take_back(name, last[1])
        if target is not None:
            self._said.append((name, target))

    @property
    def own_verdict(self) -> Entry[Verdict] | None:
        """The reviewer's verdict on the selected event."""
        judged = self._place.judged
        if judged is None:
            return None
        return next((one for one in judged.verdicts if one.person == self._place.session.reviewer), None)

    def _target(self, entry_id: str) -> str | None:
        """What a taking back took back."""
        for entry in self._place.review.review.entries:
            if entry.entry_id == entry_id and isinstance(entry.said, TakenBack):
                return entry.said.entry_id
        return None

    def _told_verdict(self) -> Entry[Verdict]:
        own = self.own_verdict
        if own is None:
            raise UserError("give a verdict first: right, too early, too late or false")
        return own

    def _judge(self, judgement: Judgement, reason: Reason | None, text: str) -> None:
        judged = self._place.judged
        if judged is None:
            raise UserError("select an event first: click one of the list, or press N")
        own = self.own_verdict
        event = reference_to(judged.event) if own is None else own.said.event
        self.say(Verdict(event, judgement, reason, text))
