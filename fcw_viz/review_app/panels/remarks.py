"""Missed events and notes: adding them at the moment that is shown, and the list of everybody's."""

from html import escape

import viser

from fcw_viz.page.channel import says
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.time.timeline import MISSED_COLOR, NOTE_COLOR
from fcw_viz.review_app.words import when_words


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
        remarks = [
            (entry.said.start_s, MISSED_COLOR, "Missed warning", entry.said.text, entry)
            for entry in review.missed
        ]
        remarks += [(entry.said.time_s, NOTE_COLOR, "", entry.said.text, entry) for entry in review.notes]
        rows = ""
        for time_s, color, kind, text, entry in sorted(remarks, key=lambda remark: remark[0]):
            words = ": ".join(part for part in (kind, text) if part)
            own = entry.person == place.session.reviewer
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
