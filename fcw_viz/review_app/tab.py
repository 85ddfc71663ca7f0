"""One browser tab of the review page: its desk, panels, keys and messages."""

from pathlib import Path

import viser

from fcw.annotation.records import Judgement
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.page.channel import PageChannel
from fcw_viz.page.keys import add_keys
from fcw_viz.page.script import run_script
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.desk import Desk
from fcw_viz.review_app.keys import all_keys
from fcw_viz.review_app.panels.layout import PANEL_WIDTH_PX, Panels
from fcw_viz.review_app.place import place_text
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.triage.drive_filter import parse_filter
from fcw_viz.review_app.triage.filter_bar import filter_messages

FIRST_SIZE = ImageSize(1280, 720)
"""Size of the picture before a drive is opened."""
STRIP_MANNERS = Path(__file__).with_name("plots").joinpath("strip.js").read_text(encoding="utf-8")


class Tab(PageTab):
    """One tab on a session."""

    def __init__(self, client: viser.ClientHandle, session: ReviewSession, folder: str, dark: bool) -> None:
        """Make the tab; nothing is shown before the page says that it is ready.

        Args:
            client: the side of the browser.
            session: what all tabs share.
            folder: name of the folder of all drives.
            dark: whether the page starts in dark colours.
        """
        super().__init__(client, f"{folder} · fcw review", FIRST_SIZE)
        self._session = session
        self._refresh_waits = False
        self._desk = Desk(self, session, self._show_panels)
        self._panels = Panels(self, self._desk, folder, dark)
        add_keys(client.gui, self.run, all_keys(self._desk, self._switch_goes_on))
        session.join(self._desk.place, self._hear)
        self._open_channel()
        self.view.tell_drawn()

    def close(self) -> None:
        """Stop, and leave the session, after the browser tab was closed."""
        super().close()
        self._desk.playing.stop()
        self._desk.screen.stop_reading()
        self._desk.ahead.close()
        self._session.leave(self._desk.runs)
        self._session.leave(self._desk.place)

    def _open_channel(self) -> None:
        desk, channel = self._desk, PageChannel(self.client, self.run)
        for name, callback in {
            "asked": self._ask_again,
            "ready": self._arrive,
            "size": self._resized,
            "docked": lambda _: self.client.gui.main_panel.set_width(PANEL_WIDTH_PX),
            "drawn": lambda _: desk.screen.drawn(),
            "open": desk.open_at,
            "list": lambda _: desk.show_list(),
            "seek": lambda about: desk.go_to_time(float(about)),
            "goto": lambda about: desk.go_to_time(float(about)),
            "step": lambda about: desk.step(int(about)),
            "play": lambda _: desk.playing.toggle(),
            "speed": lambda about: desk.playing.set_speed(float(about)),
            "window": desk.screen.set_window,
            "event": self._event_clicked,
            "sort": lambda about: desk.sort(about == "time"),
            "markstart": lambda about: desk.mark_start(float(about)),
            "markend": lambda about: desk.mark_end(float(about)),
            "playevent": lambda _: desk.playing.play_event(),
            "hover": self._hovered,
            "birdseye": lambda _: desk.screen.switch_birds_eye(),
            **desk.annotating.messages,
            **desk.box_commands.messages,
            **desk.runs.messages,
            **desk.place.plots.messages(desk.screen.choose_plots),
            "verdict": lambda about: desk.judge(Judgement[about]),
            "note": desk.keep_note,
            "unjudged": lambda _: desk.next_unjudged(),
            "goeson": self._switch_goes_on,
            "undo": lambda _: desk.undo(),
            "more": lambda _: self._panels.show_more(),
            **filter_messages(lambda: desk.place.asked, desk.ask),
        }.items():
            channel.on(name, callback)
        channel.open()
        desk.screen.hover.start()
        run_script(self.client, STRIP_MANNERS)

    def _ask_again(self, text: str) -> None:
        """Apply the filter in the address of the page when the page is ready."""
        self._desk.place.asked = parse_filter(text)

    def _arrive(self, text: str) -> None:
        """Go to the place in the address of the page when the page is ready."""
        desk, drives = self._desk, self._session.drives
        if desk.place.drive is not None:
            return
        if text:
            try:
                desk.open_at(text)
            except UserError as error:
                self.refuse(error)
                self._arrive("")
        elif not self._session.folder.several:
            desk.open_at(place_text(next(iter(drives))))
        else:
            self._panels.show_filter()  # somebody else's words may have had it drawn before it was asked
            desk.refresh()

    def _resized(self, about: str) -> None:
        self._desk.screen.resized(about)
        self._panels.resized(about)

    def _event_clicked(self, about: str) -> None:
        if about in ("next", "previous"):
            self._desk.next_event(about == "next")
        elif about.isdigit() and int(about) < len(self._desk.place.opened.events):
            self._desk.select_event(int(about))

    def _hovered(self, about: str) -> None:
        hover = self._desk.screen.hover
        hover.move(about)
        self._desk.boxes.hover(hover.mouse_px)

    def _switch_goes_on(self, _: str = "") -> None:
        self._desk.switch_goes_on()
        self._panels.show_filter()

    def _show_panels(self) -> None:
        self._panels.show()

    def _hear(self) -> None:
        """The listener of the session; of several changes at once, only the last one is drawn."""
        if not self._refresh_waits:
            self._refresh_waits = True
            self.run(self._heard)

    def _heard(self) -> None:
        self._refresh_waits = False
        self._desk.follow()
        self._desk.refresh()
        self._desk.boxes.review_changed()
