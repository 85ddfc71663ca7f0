"""What a person says about a drive in a tab: verdicts, missed events and notes, with undo."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from fcw.annotation.records import Entry, Judgement, MissedEvent, Note, Reason, Said, TakenBack, Verdict
from fcw.annotation.review import fold, reference_to, verdicts_of
from fcw.annotation.warning_labels import LEVEL_OF_KIND
from fcw.errors import UserError
from fcw.warning.types import WarningLevel
from fcw_viz.review_app.place import Place

MISSED_BEFORE_S, MISSED_AFTER_S = 1.0, 1.0
"""A missed event extends so far before and after the moment at which it is added."""
NOTHING_TO_UNDO = (
    "nothing to undo: only what this tab did since it was loaded can be undone. To clear a verdict, "
    "press its key (1 to 4) again; to remove a note or a missed event, press ✕ under Notes"
)


class _Words(NamedTuple):
    """One step of undo: entries that count, or are taken back, together."""

    drive: str
    entry_ids: tuple[str, ...]


class Annotating:
    """What the person of one tab says; it is stored, and shown in the other tabs, at once."""

    def __init__(self, place: Place, notify: Callable[[str, str], object]) -> None:
        """Begin with nothing said.

        Args:
            place: the place of the tab.
            notify: shows the user a message with a title and a text.
        """
        self._place, self._notify = place, notify
        self._said: list[_Words] = []
        self._taken_back: list[_Words] = []

    @property
    def messages(self) -> Mapping[str, Callable[[str], object]]:
        """Handlers of the messages from the elements of the page."""
        return {
            "reason": lambda about: self.give_reason(Reason[about] if about else None),
            "takeback": self.take_back,
            "explain": self.explain,
            "note": self.add_note,
            "missed": lambda _: self.add_missed(),
            "missedrange": self._set_to_range,
            "missedstart": lambda about: self.change_missed(about, start_s=self._place.time_s),
            "missedend": lambda about: self.change_missed(about, end_s=self._place.time_s),
            "missedfrom": lambda about: self._drag_missed(about, start=True),
            "missedto": lambda about: self._drag_missed(about, start=False),
            "missedlevel": self._choose_level,
            "missedtext": self._write_missed,
        }

    def judge(self, judgement: Judgement) -> None:
        """Give a verdict on the selected event; the same one again clears it."""
        own = self.own_verdict
        if own is not None and own.said.judgement is judgement:
            self._clear_verdict()
            return
        self._judge(judgement, None, own.said.text if own is not None else "")

    def give_reason(self, reason: Reason | None) -> None:
        """Add a reason to the verdict that was given."""
        own = self._told_verdict()
        self._judge(own.said.judgement, reason, own.said.text)

    def explain(self, text: str) -> None:
        """Add a remark to the verdict that was given."""
        own = self._told_verdict()
        self._judge(own.said.judgement, own.said.reason, text.strip())

    def add_note(self, text: str) -> None:
        """Add a note to the moment that is shown."""
        self.say(Note(self._place.time_s, text.strip()))

    def add_missed(self, text: str = "", level: WarningLevel = WarningLevel.WARNING) -> None:
        """Add a missed warning in the marked range or, without one, around the moment that is shown.

        Raises:
            UserError: a warning was shown then; it can be judged instead.
        """
        time_s, duration_s = self._place.time_s, self._place.opened.duration_s
        start_s, end_s = max(time_s - MISSED_BEFORE_S, 0.0), min(time_s + MISSED_AFTER_S, duration_s)
        if self._place.marked is not None:
            start_s, end_s = self._place.marked
            time_s = (start_s + end_s) / 2
        for event in self._place.opened.events:
            if LEVEL_OF_KIND.get(event.kind, WarningLevel.NONE) < level:
                continue
            if event.start_s <= time_s <= event.end_s:
                raise UserError(
                    f"a {event.kind} is shown at this moment, so none was missed: judge that one instead"
                )
            if event.end_s < time_s:
                start_s = max(start_s, event.end_s)
            else:
                end_s = min(end_s, event.start_s)
        self.say(MissedEvent(start_s, end_s, text.strip(), level))
        self._notify("Missed event added", "Change its start, end, level and text under Notes.")

    def change_missed(
        self,
        entry_id: str,
        *,
        start_s: float | None = None,
        end_s: float | None = None,
        level: WarningLevel | None = None,
        text: str | None = None,
    ) -> None:
        """Change one of the reviewer's own missed events; None leaves a field as it is.

        Raises:
            UserError: the event would end before it starts, or belongs to somebody else.
        """
        missed = self._place.review.review.missed
        entry = next((one for one in missed if one.entry_id == entry_id), None)
        if entry is None or entry.person != self._place.session.reviewer:
            raise UserError("only its author can change it; add your own note instead")
        said = entry.said
        start_s = said.start_s if start_s is None else start_s
        end_s = said.end_s if end_s is None else end_s
        if start_s > end_s:
            raise UserError(
                f"a missed event cannot start at {start_s:.2f} s and end at {end_s:.2f} s: "
                "move its other end first"
            )
        changed = MissedEvent(
            start_s, end_s, said.text if text is None else text.strip(), level or said.level
        )
        if changed != said:
            self.say(TakenBack(entry_id), changed)

    def say(self, *said: Said) -> None:
        """Store something about the open drive; all of it is one step of undo."""
        name = self._place.opened.name
        entries = self._place.session.say(name, *said, seen=self._place.opened)
        self._said.append(_Words(name, tuple(entry.entry_id for entry in entries)))
        self._taken_back.clear()

    def take_back(self, entry_id: str) -> None:
        """Take back one of the reviewer's own entries."""
        self._take_back(_Words(self._place.opened.name, (entry_id,)))

    @property
    def last_drive(self) -> str | None:
        """The drive of the last entry in this tab; None if nothing can be undone."""
        return self._said[-1].drive if self._said else None

    def undo(self) -> None:
        """Undo the last step of this tab in this drive."""
        name = self._place.opened.name
        counting = {entry.entry_id for entry in self._place.review.review.entries}
        while (last := next((said for said in reversed(self._said) if said.drive == name), None)) is not None:
            if counting.issuperset(last.entry_ids) and self._counts(last):
                self._take_back(last)
                return
            self._said.remove(last)  # another tab has taken it back meanwhile, or said something else
        raise UserError(NOTHING_TO_UNDO)

    def redo(self) -> None:
        """Redo the last step that was undone in this tab in this drive."""
        name = self._place.opened.name
        last = next((said for said in reversed(self._taken_back) if said.drive == name), None)
        if last is None:
            raise UserError("nothing to redo")
        self._taken_back.remove(last)
        targets = [self._target(entry_id) for entry_id in last.entry_ids]
        self._place.session.say(name, *map(TakenBack, reversed(last.entry_ids)))
        known = tuple(target for target in reversed(targets) if target is not None)
        self._said.append(_Words(name, known))

    @property
    def own_verdict(self) -> Entry[Verdict] | None:
        """The reviewer's verdict on the selected event."""
        judged = self._place.judged
        if judged is None:
            return None
        return next((one for one in judged.verdicts if one.person == self._place.session.reviewer), None)

    def _counts(self, words: "_Words") -> bool:
        """Whether undoing a step would change anything; not if a later verdict has replaced it."""
        review, step = self._place.review.review, set(words.entry_ids)
        if any(isinstance(one.said, TakenBack) for one in review.entries if one.entry_id in step):
            return True  # what it took back is not in the review
        left = fold(one for one in review.entries if one.entry_id not in step)
        return (left.verdicts, left.missed, left.notes, left.frames) != (
            review.verdicts,
            review.missed,
            review.notes,
            review.frames,
        )

    def _clear_verdict(self) -> None:
        """Clear the verdict on the selected event, and those that it replaced, in one step."""
        place = self._place
        assert place.selected is not None
        person, shown = place.session.reviewer, place.review
        own = verdicts_of(person, place.selected, shown.review, [one.event for one in shown.events])
        self.say(*(TakenBack(entry.entry_id) for entry in reversed(own)))

    def _take_back(self, words: "_Words") -> None:
        """Take back all entries of a step, the last one first."""
        entries = self._place.session.say(words.drive, *map(TakenBack, reversed(words.entry_ids)))
        self._said = [said for said in self._said if said != words]
        self._taken_back.append(_Words(words.drive, tuple(entry.entry_id for entry in entries)))

    def _set_to_range(self, entry_id: str) -> None:
        if self._place.marked is None:
            raise UserError("mark a range first: press A at its start and S at its end")
        start_s, end_s = self._place.marked
        self.change_missed(entry_id, start_s=start_s, end_s=end_s)

    def _drag_missed(self, about: str, *, start: bool) -> None:
        """Move an end of a missed event; beyond the other end, it moves that too."""
        entry_id, _, text = about.partition(":")
        time_s = min(max(float(text), 0.0), self._place.opened.duration_s)
        entry = next((one for one in self._place.review.review.missed if one.entry_id == entry_id), None)
        if entry is None:
            return  # somebody has changed it meanwhile
        if start:
            self.change_missed(entry_id, start_s=time_s, end_s=max(entry.said.end_s, time_s))
        else:
            self.change_missed(entry_id, start_s=min(entry.said.start_s, time_s), end_s=time_s)

    def _choose_level(self, about: str) -> None:
        entry_id, _, level = about.partition(" ")
        self.change_missed(entry_id, level=WarningLevel[level])

    def _write_missed(self, about: str) -> None:
        entry_id, _, text = about.partition(":")
        self.change_missed(entry_id, text=text)

    def _target(self, entry_id: str) -> str | None:
        """The entry that a `TakenBack` entry takes back."""
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
            raise UserError("select an event first: click one in the list, or press N")
        own = self.own_verdict
        event = reference_to(judged.event) if own is None else own.said.event
        self.say(Verdict(event, judgement, reason, text))
