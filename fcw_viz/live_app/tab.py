"""One browser tab on a running drive, which shows the latest frame as fast as its browser draws."""

import threading
import time
from collections.abc import Callable
from functools import partial
from html import escape

import viser

from fcw.frame import ImageSize
from fcw.units import NS_PER_S
from fcw_viz.live_app.age import PictureAge
from fcw_viz.live_app.alarm import Alarm
from fcw_viz.live_app.feed import LiveFeed, Moment
from fcw_viz.live_app.latency import LatencyMeter
from fcw_viz.live_app.panels import History, LivePanels
from fcw_viz.overlay import OverlayPainter
from fcw_viz.page.channel import PageChannel, says
from fcw_viz.page.keys import Key, add_keys
from fcw_viz.page.picture.hover import HoverHints
from fcw_viz.page.script import run_script
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.panels.layout import PANEL_WIDTH_PX
from fcw_viz.review_app.picture.birds_eye_view import BirdsEye

FIRST_SIZE = ImageSize(1280, 720)
"""Size of the picture before the drive begins."""
QUALITY = 80
"""JPEG quality of the pictures."""
LOST_S = 10.0
"""If a browser does not confirm a picture for so long, it gets another one; the message may be lost."""
LOOK_S = 0.01
PLOTS_S, WORDS_S = 0.4, 0.2
"""Intervals at which plots and words are updated; they need not be as fast as the picture."""
REVIEW = f"<button {says('review:')}>Review the drive</button>"


class LiveTab(PageTab):
    """One tab on a feed.

    Attributes:
        birds_eye: the view from above.
        hover: details of the vehicle under the mouse.
        age: age of the picture on the screen.
        latency: latencies of what it shows.
    """

    def __init__(self, client: viser.ClientHandle, feed: LiveFeed, title: str, waiting: str) -> None:
        super().__init__(client, f"{title} · live · fcw", FIRST_SIZE)
        self._feed = feed
        self._moment: Moment | None = None
        self._painter: OverlayPainter | None = None
        self._overlay_shown = True
        self._end_words: str | None = None
        self._lost = ""
        self._plots_s = self._words_s = float("-inf")
        self._drawn, self._anew = threading.Event(), threading.Event()
        self._drawn.set()
        self.birds_eye = BirdsEye(client, self.view)
        self.hover = HoverHints(self.view, client)
        self.latency = LatencyMeter()
        self._panels = LivePanels(client.gui, title)
        self._panels.show_head(waiting, False)
        self.age = PictureAge(client)
        self._alarm = Alarm(client)
        add_keys(client.gui, self.run, self._keys())
        # Handled at once, because a picture is drawn at the time of this message.
        channel = PageChannel(client, _at_once)
        channel.on("drawn", self._was_drawn)
        channel.on("clock", lambda about: self.age.clock.heard(float(about) / 1000, feed.now_s()))
        channel.on("size", self._resized, self.run)
        channel.on("docked", lambda _: client.gui.main_panel.set_width(PANEL_WIDTH_PX))
        channel.on("mute", lambda _: self.run(self._mute))
        channel.on("birdseye", lambda _: self.run(self._switch_birds_eye))
        channel.on("hover", self.hover.move, self.run)
        channel.on("review", lambda _: run_script(client, "location.reload();"))
        channel.open()
        self.age.start()
        self.view.tell_drawn()
        self.hover.start()
        threading.Thread(target=self._follow, name="live tab", daemon=True).start()

    def show_waiting(self, words: str) -> None:
        """Show what is waited for before the first picture."""
        self.run(partial(self._panels.show_head, words, False))

    def show_end(self, words: str) -> None:
        """Show that the drive has ended, and what comes next."""
        self.run(partial(self._end, words))

    def _end(self, words: str) -> None:
        self._end_words = words
        self._alarm.end(bool(self._lost))
        self.age.end(self._lost)
        self._panels.show_head(words, True)

    def _show_trouble(self, trouble: str, ended: bool) -> None:
        """Show why no picture comes; the words stay if that has ended the drive."""
        if trouble and ended:
            self._lost = f"No more warnings: {trouble}"
            self._end(f"The drive has ended: {escape(trouble)}. {REVIEW}")
        elif not ended:
            self.age.says(trouble[:1].upper() + trouble[1:])
            if trouble:
                self._panels.show_head(escape(trouble), False)
        self.client.flush()

    def _follow(self) -> None:
        """Show the latest moment when the browser is ready, and a new level at once; runs in a thread.

        A new level appears everywhere except in the picture, which may be a little behind.

        Only one picture is on its way, so that it is known which one the browser has drawn, and its age.
        """
        seen, told, sent_s = -1, None, float("-inf")
        waiting: Moment | None = None
        known = "", False
        while not self._closed.is_set():
            if (source := (self._feed.trouble, self._feed.ended)) != known:
                known = source
                self.run(partial(self._show_trouble, *source))
            newer = self._feed.newer_than(seen, LOOK_S)
            if newer is not None:
                seen, waiting = newer.result.index, newer
                level = newer.result.warning.level
                if level is not told:
                    told = level
                    self.run(partial(self._tell, newer))
            elif self._feed.ended:
                self._closed.wait(LOOK_S)  # the feed waits no longer
            if self._anew.is_set():
                waiting = waiting or self._moment
            lost = time.monotonic() - sent_s > LOST_S
            if waiting is None or not (lost or self._drawn.is_set()):
                continue
            self._drawn.clear()
            self._anew.clear()
            shown = threading.Event()
            self.run(partial(self._show, waiting, shown))
            while not shown.wait(LOOK_S) and not self._closed.is_set():
                pass
            waiting, sent_s = None, time.monotonic()

    def _show(self, moment: Moment, shown: threading.Event) -> None:
        try:
            self._show_picture(moment)
            self._sound(moment)
            self.client.flush()  # the eye is on the picture: it does not wait for the rest
            self._show_rest(moment)
            if self._end_words is not None:  # the picture was on its way when the drive ended
                self._end(self._end_words)
        finally:
            shown.set()

    def _show_picture(self, moment: Moment) -> None:
        header = self._feed.header
        assert header is not None  # it comes before the first result
        if self._painter is None:
            self._painter = OverlayPainter(header, self._feed.first_ns, banner=False)  # the alarm is sooner
            self.view.set_size(header.image_size)
            self._panels.show_aspect(header.image_size.width, header.image_size.height)
            self.birds_eye.load(header)
        self._moment = moment
        image = moment.image.copy()
        if self._overlay_shown:
            self._painter.paint(image, moment.result)
        with self.client.atomic():
            self.latency.sent(moment.captured_s, moment.found_s)
            if self._end_words is None:  # a drive's last picture, drawn once more, is not late
                self.age.comes(moment.captured_s)
            self.view.show(image, QUALITY)
            self.birds_eye.show(moment.result)
            self.hover.show(moment.result if self._overlay_shown else None, header.imperial)

    def _tell(self, moment: Moment) -> None:
        """Show the warning, its sound and the words of the panel, all of one result so that they agree."""
        self._sound(moment)
        if self._end_words is None:
            self._show_words(moment)
            self.client.flush()

    def _sound(self, moment: Moment) -> None:
        header = self._feed.header
        if header is not None and self._end_words is None:
            self._alarm.show(moment.result, self.age.in_browser(moment.captured_s), header.imperial)

    def _show_rest(self, moment: Moment) -> None:
        now_s = time.monotonic()
        if now_s - self._words_s > WORDS_S:
            self._show_words(moment)
        if now_s - self._plots_s > PLOTS_S:
            self._plots_s = now_s
            self._show_plots(moment)

    def _show_words(self, moment: Moment) -> None:
        header, feed = self._feed.header, self._feed
        if header is not None:
            self._words_s = time.monotonic()
            time_s = (moment.result.time_ns - feed.first_ns) / NS_PER_S
            self._panels.show_result(moment.result, header, time_s, feed.dropped, self.latency.figures)

    def _was_drawn(self, about: str) -> None:
        browser_s = float(about) / 1000
        self.age.clock.heard(browser_s, self._feed.now_s())
        self.latency.drawn(self.age.clock.of_ours(browser_s))
        self._drawn.set()

    def _resized(self, about: str) -> None:
        self._panels.resized(about)
        if self._moment is not None:
            self._show_plots(self._moment)

    def _show_plots(self, moment: Moment) -> None:
        """Show the last seconds up to the frame in the picture, which may be behind the latest result."""
        header, feed = self._feed.header, self._feed
        series = feed.history(moment.result.index)
        if header is not None and len(series) > 0:
            self._panels.show_plots(History(header, series, feed.first_ns))

    def _mute(self) -> None:
        self._alarm.mute(not self._alarm.muted)

    def _switch_birds_eye(self) -> None:
        self.birds_eye.toggle()
        self._anew.set()

    def _switch_overlay(self) -> None:
        self._overlay_shown = not self._overlay_shown
        self._anew.set()

    def _keys(self) -> tuple[Key, ...]:
        return (
            Key("Picture or view from above", "B", None, self._switch_birds_eye),
            Key("Sound on, off", "M", None, self._mute),
            Key("Overlay on or off", "O", None, self._switch_overlay),
            Key("Whole picture", "F", None, self.view.fit),
        )


def _at_once(work: Callable[[], object]) -> None:
    work()
