"""The selected event: why it came, in words, and what people say of it; and the list of all events."""

from html import escape
from typing import TYPE_CHECKING

import viser

from fcw.logs.records import FrameResult
from fcw.warning.types import WarningLevel
from fcw_viz.page.channel import enters, says
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.panels.event_list import list_html, verdict_html
from fcw_viz.review_app.time.timeline import kind_color
from fcw_viz.review_app.words import MOUNT_MOVED, NEAR_MISS, kind_title, why

if TYPE_CHECKING:
    from fcw_viz.review_app.tab import Tab


class EventPanel:
    """The first of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, tab: "Tab") -> None:
        self._tab = tab
        self._reasons: dict[tuple[str, int], FrameResult] = {}
        self._event = gui.add_html("")
        self._words = gui.add_html("")
        self._list = gui.add_html("")

    def show(self) -> None:
        """Bring it to the tab's drive, event and verdicts."""
        tab = self._tab
        drive = tab.opened
        imperial = drive.header.imperial
        set_html(self._list, text_block(list_html(tab.review.events, tab.by_time, tab.selected, imperial)))
        own = tab.annotating.own_verdict
        # On its own: half typed words stay when the rest is drawn anew.
        set_html(self._words, text_block(_words_field(own.said.text)) if own is not None else "")
        set_html(self._event, text_block(self._event_html(drive)))

    def _event_html(self, drive: Drive) -> str:
        tab, judged = self._tab, self._tab.judged
        if judged is None or tab.selected is None:
            words = "No event is selected; N goes to the next one." if drive.events else "No event here."
            return f'<p class="dim">{words}</p>'
        event = judged.event
        title = (
            f'<div class="fcw-title" style="--kind: {kind_color(event.kind)}"><i></i>'
            f"<b>{kind_title(event.kind)}</b>"
            f"<button {says('playevent:')} title='Shift space'>play it</button>"
            f"<span>{time_text(event.start_s)} to {time_text(event.end_s)}</span></div>"
        )
        if event.kind == MOUNT_MOVED:
            return f"{title}<p>{escape(event.note)}</p>{verdict_html(judged, tab.session.reviewer)}"
        rows = "".join(
            f"<dt>{escape(what)}</dt><dd>{escape(much)}</dd>"
            for what, much in why(self._reason(drive, tab.selected), drive.header.imperial)
        )
        head = "When it began" if event.kind != NEAR_MISS else "At its worst; nothing was shown"
        return (
            f'{title}<p class="dim">{head}</p><dl class="fcw-why">{rows}</dl>'
            f"{verdict_html(judged, tab.session.reviewer)}"
        )

    def _reason(self, drive: Drive, number: int) -> FrameResult:
        """The frame that says why it came: the first one of its level, or of a near miss the worst."""
        key = drive.name, number
        if key not in self._reasons:
            event = drive.events[number]
            row = drive.row_at(event.peak_s)
            levels = {level.name.lower(): level for level in WarningLevel}
            if event.kind in levels:
                first, last = drive.row_at(event.start_s), drive.row_at(event.end_s)
                reached = drive.series.level[first : last + 1] >= levels[event.kind]
                row = first + int(reached.argmax())
            self._reasons[key] = drive.log.result_at(drive.frame_index(row))
        return self._reasons[key]


def _words_field(text: str) -> str:
    return (
        f'<input type="text" {enters("fcw-explain", "explain", keeps=True)} value="{escape(text)}" '
        'placeholder="In your own words, Enter keeps them" autocomplete="off">'
    )
