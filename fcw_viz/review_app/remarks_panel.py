"""Missed events and notes: adding them at the moment that is shown, and the list of everybody's."""

from html import escape
from typing import TYPE_CHECKING

import viser

from fcw_viz.page.controls import on_button
from fcw_viz.page.page_channel import says
from fcw_viz.page.page_style import set_html, text_block
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.timeline import MISSED_COLOR, NOTE_COLOR
from fcw_viz.review_app.words import when_words

if TYPE_CHECKING:
    from fcw_viz.review_app.tab import Tab


class RemarksPanel:
    """The second of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, tab: "Tab") -> None:
        self._tab = tab
        self._head = gui.add_html("")
        self._form = gui.add_form(None)
        with self._form:
            self._words = gui.add_text("Note", "", hint="On the moment that is shown; Enter keeps it")
        self._add = gui.add_button("Add the note", icon=viser.Icon.NOTE, color="gray")
        self._missed = gui.add_button(
            "A warning was missed here (M)",
            icon=viser.Icon.ALERT_TRIANGLE,
            color="gray",
            hint="With the words of the note, if there are any",
        )
        self._list = gui.add_html("")
        on_button(self._add, tab.run, self.add_note)
        on_button(self._missed, tab.run, self.add_missed)

        @self._form.on_submit
        async def _(_: viser.GuiEvent[viser.GuiFormHandle]) -> None:
            tab.run(self.add_note)

    def add_note(self) -> None:
        """Keep what was typed."""
        self._tab.annotating.add_note(self._words.value)
        self._words.value = ""

    def add_missed(self) -> None:
        """A missed event, with what was typed."""
        self._tab.annotating.add_missed(self._words.value)
        self._words.value = ""

    @property
    def words_field(self) -> viser.GuiTextHandle:
        """Where a note is typed."""
        return self._words

    def show(self) -> None:
        """Bring the list to what is said by now."""
        tab = self._tab
        set_html(self._head, text_block(f"<p>At <b>{time_text(tab.time_s, 2)}</b>:</p>"))
        review = tab.review.review
        remarks = [
            (entry.said.start_s, MISSED_COLOR, "Missed warning", entry.said.text, entry)
            for entry in review.missed
        ]
        remarks += [(entry.said.time_s, NOTE_COLOR, "", entry.said.text, entry) for entry in review.notes]
        rows = ""
        for time_s, color, kind, text, entry in sorted(remarks, key=lambda remark: remark[0]):
            words = ": ".join(part for part in (kind, text) if part)
            own = entry.person == tab.session.reviewer
            button = (
                f'<button {says(f"takeback:{entry.entry_id}")} title="Take it back">✕</button>'
                if own
                else "<span></span>"
            )
            goes = says(f"goto:{time_s!r}")
            rows += (
                f'<div class="fcw-remark" style="--kind: {color}"><span {goes}><b>{time_text(time_s)}</b>'
                f"</span><span {goes}>{escape(words)}</span>{button}"
                f"<small>{escape(entry.person)}, {when_words(entry.time)}</small></div>"
            )
        set_html(self._list, text_block(rows or '<p class="dim">Nobody has remarked anything yet.</p>'))
