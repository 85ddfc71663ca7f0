"""The selected event: why it came, in words, and what people say of it; and the list of all events."""

from html import escape

import viser

from fcw.logs.events import DriveEvent
from fcw.logs.records import FrameResult
from fcw.warning.types import WarningLevel
from fcw_viz.page.channel import enters, says
from fcw_viz.page.style import set_html, text_block
from fcw_viz.review_app.annotating import Annotating
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.panels.event_list import list_html, verdict_html
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.time.timeline import kind_color
from fcw_viz.review_app.words import (
    CUT,
    MOUNT_MOVED,
    NEAR_MISS,
    NOTHING_SEEN,
    POOR_SIGHT,
    kind_title,
    why,
)


class EventPanel:
    """The first of a drive's tabs."""

    def __init__(self, gui: viser.GuiApi, place: Place, annotating: Annotating) -> None:
        self._place, self._annotating = place, annotating
        self._reasons: dict[tuple[object, DriveEvent], FrameResult] = {}
        self._event = gui.add_html("")
        self._words = gui.add_html("")
        self._list = gui.add_html("")

    def show(self) -> None:
        """Bring it to the place's drive, event and verdicts."""
        place = self._place
        drive = place.opened
        imperial = drive.header.imperial
        events, told = place.review.events, drive.notes
        listed = list_html(drive.name, events, place.by_time, place.selected, imperial, told)
        set_html(self._list, text_block(listed))
        own = self._annotating.own_verdict
        # On its own: half typed words stay when the rest is drawn anew.
        field = "" if own is None else _words_field(f"{drive.name} {own.said.event}", own.said.text)
        set_html(self._words, text_block(field) if field else "")
        set_html(self._event, text_block(self._event_html(drive)))

    def _event_html(self, drive: Drive) -> str:
        place, judged = self._place, self._place.judged
        if judged is None or place.selected is None:
            # Where there are none, the list says so.
            return '<p class="dim">No event selected. Press N for the next one.</p>' if drive.events else ""
        event = judged.event
        title = (
            f'<div class="fcw-title" style="--kind: {kind_color(event.kind)}"><i></i>'
            f"<b>{kind_title(event.kind)}</b>"
            f"<button {says('playevent:')} title='Shift space'>play</button>"
            f"<span>{time_text(event.start_s)} to {time_text(event.end_s)}</span></div>"
        )
        if event.kind in (MOUNT_MOVED, NOTHING_SEEN, CUT, POOR_SIGHT):
            return f"{title}<p>{escape(event.note)}</p>{verdict_html(judged, place.session.reviewer)}"
        rows = "".join(
            f"<dt>{escape(what)}</dt><dd>{escape(much)}</dd>"
            for what, much in why(self._reason(drive, place.selected), drive.header.imperial)
        )
        head = "When it began" if event.kind != NEAR_MISS else "At its worst moment; no warning was shown"
        return (
            f'{title}<p class="dim">{head}</p><dl class="fcw-why">{rows}</dl>'
            f"{verdict_html(judged, place.session.reviewer)}"
        )

    def _reason(self, drive: Drive, number: int) -> FrameResult:
        """The frame that says why it came: the first one of its level, or of a near miss the worst."""
        event = drive.events[number]
        key = drive.origin, event  # of a drive that grows or is run again another event may have the number
        if key not in self._reasons:
            row = drive.row_at(event.peak_s)
            levels = {level.name.lower(): level for level in WarningLevel}
            if event.kind in levels:
                first, last = drive.row_at(event.start_s), drive.row_at(event.end_s)
                reached = drive.series.level[first : last + 1] >= levels[event.kind]
                row = first + int(reached.argmax())
            self._reasons[key] = drive.log.result_at(drive.frame_index(row))
        return self._reasons[key]


def _words_field(event: str, text: str) -> str:
    """A field of each event's own: what is half typed about one is not said of another."""
    return (
        f'<input type="text" {enters(f"fcw-explain {event}", "explain")} value="{escape(text)}" '
        'placeholder="Comment; Enter saves it" autocomplete="off">'
    )
