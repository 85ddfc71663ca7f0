"""Missed events and notes: adding them at the moment that is shown, and the list of everybody's."""

from collections.abc import Sequence
from html import escape
from typing import Any

import viser

from fcw.annotation.records import Entry, MissedEvent, Note
from fcw.warning.types import WarningLevel
from fcw_viz.page.channel import chooses, enters, says
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.time.timeline import MISSED_COLOR, NOTE_COLOR
from fcw_viz.review_app.words import when_words


def run_html(notes: Sequence[str]) -> str:
    """What the run told of the drive; empty where it told nothing."""
    lines = "".join(f'<p class="fcw-told">{escape(note)}</p>' for note in notes)
    return f'<div class="fcw-said"><b>Notes from the run</b>{lines}</div>' if notes else ""


class RemarksPanel:
    """The second of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, place: Place) -> None:
        self._place = place
        self._head = gui.add_html("")
        self._list = gui.add_html("")

    def show(self) -> None:
        """Bring the list to what is said by now."""
        place = self._place
        missed = f"<button {says('missed:')}>A warning was missed here<kbd>M</kbd></button>"
        set_html(self._head, text_block(f"<p>At <b>{time_text(place.time_s, 2)}</b>: {missed}</p>"))
        review = place.review.review
        rows = [(entry.said.start_s, self._missed_html(entry)) for entry in review.missed]
        rows += [(entry.said.time_s, self._note_html(entry)) for entry in review.notes]
        html = "".join(row for _, row in sorted(rows, key=lambda row: row[0]))
        told = () if place.drive is None else place.drive.notes
        set_html(self._list, text_block((html or '<p class="dim">No notes yet.</p>') + run_html(told)))

    def _note_html(self, entry: Entry[Note]) -> str:
        goes, moment = says(f"goto:{entry.said.time_s!r}"), time_text(entry.said.time_s)
        return (
            f'<div class="fcw-remark" style="--kind: {NOTE_COLOR}"><span {goes}><b>{moment}</b></span>'
            f"<span {goes}>{escape(entry.said.text)}</span>{self._take_back_html(entry)}"
            f"{_by_html(entry)}</div>"
        )

    def _missed_html(self, entry: Entry[MissedEvent]) -> str:
        """A missed event; one's own with what changes it."""
        said, entry_id = entry.said, entry.entry_id
        span = f"{time_text(said.start_s)} to {time_text(said.end_s)}"
        about = f"Missed {said.level.name.lower()}" + (f": {said.text}" if said.text else "")
        change = ""
        if self._is_own(entry):
            about = "Missed"
            options = "".join(
                f'<option value="{escape(entry_id)} {level.name}"{" selected" * (level is said.level)}>'
                f"{level.name.lower()}</option>"
                for level in reversed(WarningLevel)
                if level
            )
            change = (
                f'<div class="fcw-change"><select {chooses("missedlevel")}>{options}</select>'
                f"{self._range_html(entry_id)}"
                f"<button {says(f'missedstart:{entry_id}')}>start here</button>"
                f"<button {says(f'missedend:{entry_id}')}>end here</button>"
                f'<input type="text" {enters(f"fcw-{entry_id}", f"missedtext:{entry_id}")} '
                f'value="{escape(said.text)}" placeholder="What happened? Enter saves it" autocomplete="off">'
                "</div>"
            )
        return (
            f'<div class="fcw-remark" style="--kind: {MISSED_COLOR}">'
            f"<span {says(f'goto:{said.start_s!r}')}><b>{span}</b></span><span>{escape(about)}</span>"
            f"{self._take_back_html(entry)}{change}{_by_html(entry)}</div>"
        )

    def _range_html(self, entry_id: str) -> str:
        if self._place.marked is None:
            return ""
        return f"<button class='wide' {says(f'missedrange:{entry_id}')}>use the marked range</button>"

    def _is_own(self, entry: Entry[Any]) -> bool:
        return entry.person == self._place.session.reviewer

    def _take_back_html(self, entry: Entry[Any]) -> str:
        if not self._is_own(entry):
            return "<span></span>"
        return f'<button {says(f"takeback:{entry.entry_id}")} title="Remove">✕</button>'


def _by_html(entry: Entry[Any]) -> str:
    return f"<small>{escape(entry.person)}, {when_words(entry.time)}</small>"
