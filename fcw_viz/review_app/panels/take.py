"""Taking along: the clip around an event, the table of the events, and the same moment in rerun."""

import threading
from collections.abc import Callable
from functools import partial
from html import escape

import viser

from fcw.errors import UserError
from fcw_viz.page.controls import on_button
from fcw_viz.page.style import set_html, text_block
from fcw_viz.page.tab import PageTab
from fcw_viz.rerun.viewer import FOREIGN_WORDS
from fcw_viz.review_app.drive import Drive, time_text
from fcw_viz.review_app.place import LEAD_IN_S, Place
from fcw_viz.review_app.taking import clip_around, event_table, exported_file, held_range

SHORTEST_PLAYED_S = 0.5
WAIT_WORDS = "Please wait: the previous export is not finished."


class TakePanel:
    """The fourth of a drive's tabs; what takes long is done in a thread of its own."""

    def __init__(self, tab: PageTab, place: Place) -> None:
        self._tab, self._place = tab, place
        gui = tab.client.gui
        self._busy = ""
        self._result = ""
        self._clip = gui.add_html("")
        buttons = (
            ("Clip as MP4", viser.Icon.MOVIE, partial(self._take_clip, "mp4")),
            ("Clip as MCAP", viser.Icon.FILE_EXPORT, partial(self._take_clip, "mcap")),
            ("Clip in rerun", viser.Icon.EXTERNAL_LINK, self._open_rerun),
            ("Table of all events (CSV)", viser.Icon.TABLE, self._take_table),
        )
        for label, icon, action in buttons:
            on_button(gui.add_button(label, icon=icon, color="gray"), tab.run, action)
        self._state = gui.add_html("")

    def show(self) -> None:
        """Say which part of the drive is taken."""
        start_s, end_s = self._between()
        about = (
            "The clip around the event" if self._place.selected is not None else "The clip around this moment"
        )
        about = "The marked clip" if self._place.marked is not None else about
        html = f"<p>{about}: <b>{time_text(start_s)} to {time_text(end_s)}</b></p>"
        set_html(self._clip, text_block(html))
        set_html(self._state, text_block(self._busy or self._result))

    def _between(self) -> tuple[float, float]:
        place = self._place
        if place.marked is not None:
            return place.marked
        if place.selected is None:
            return clip_around(place.time_s, place.time_s, place.opened.duration_s)
        event = place.opened.events[place.selected]
        return clip_around(event.start_s, event.end_s, place.opened.duration_s)

    def _take_clip(self, export_format: str) -> None:
        drive, between = self._place.opened, self._between()
        name = f"{drive.name}-{between[0]:.0f}s.{export_format}"
        self._do(
            f"Making {name}",
            lambda: (
                self._send(name, exported_file(drive.log.path, export_format, between))
                + _held_words(drive, export_format, between)
            ),
        )

    def _take_table(self) -> None:
        drive = self._place.opened
        name = f"{drive.name}-events.csv"
        self._do(f"Making {name}", lambda: self._send(name, event_table(drive.log.path)))

    def _open_rerun(self) -> None:
        drive, between = self._place.opened, self._between()
        played = self._played(between)
        between = max(played[0] - LEAD_IN_S, 0.0), between[1]
        self._do("Starting rerun", lambda: self._rerun(drive, between, played))

    def _played(self, between: tuple[float, float]) -> tuple[float, float]:
        """What rerun plays: the marked range, the event, or from this moment on."""
        place = self._place
        if place.marked is not None:
            return place.marked
        if place.selected is None:
            return place.time_s, between[1]
        event = place.opened.events[place.selected]
        return event.start_s, max(event.end_s, event.start_s + SHORTEST_PLAYED_S)

    def _rerun(self, drive: Drive, between: tuple[float, float], played: tuple[float, float]) -> str:
        url = self._place.session.rerun.open(drive.log.path, between, played)
        words = (
            f"It covers {time_text(between[0])} to {time_text(between[1])}, opens at its start, and plays "
            f"{time_text(played[0])} to {time_text(played[1])} in a loop."
        )
        if url is None:
            return f"<p>rerun opened in its own window. {words}</p>"
        link = f'<a href="{escape(url)}" target="_blank">Open this clip in rerun</a>'
        return f'<p>{link}. {words}</p><p class="dim">{FOREIGN_WORDS}.</p>'

    def _send(self, name: str, content: bytes) -> str:
        self._tab.client.send_file_download(name, content, save_immediately=True)
        return f"<p>Saved by the browser: {escape(name)}</p>"

    def _do(self, words: str, work: Callable[[], str]) -> None:
        """Do something that takes long, and show what came of it."""
        if self._busy:
            raise UserError(WAIT_WORDS)
        self._busy = f"<p>{escape(words)} …</p>"
        self.show()

        def run() -> None:
            result = "<p>That failed; see the program's terminal for the reason.</p>"
            try:
                result = work()
            except UserError as error:
                result = f"<p>{escape(str(error))}</p>"
            finally:
                self._tab.run(partial(self._done, result))

        threading.Thread(target=run, name="take along", daemon=True).start()

    def _done(self, result: str) -> None:
        self._busy, self._result = "", result
        if self._place.drive is not None:
            self.show()


def _held_words(drive: Drive, export_format: str, between: tuple[float, float]) -> str:
    """What a clip holds; with its own packets it begins at a keyframe."""
    start_s, end_s = held_range(drive.log.path, between) if export_format == "mcap" else between
    return f'<p class="dim">It covers {time_text(start_s)} to {time_text(end_s)}.</p>'
