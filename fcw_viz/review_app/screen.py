"""What a tab shows of its drive: the picture, and under it the strip with the time line and the plots."""

from typing import TYPE_CHECKING

from fcw.logs.records import FrameResult
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.picture.drawn import FramePictures
from fcw_viz.review_app.time.axis import window_around
from fcw_viz.review_app.time.strip import DEFAULT_WINDOW, WINDOWS_S, Strip, StripLayout

if TYPE_CHECKING:
    from fcw_viz.review_app.tab import Tab

FIRST_LAYOUT = StripLayout(1040.0, 300.0)
"""Of the strip before the browser has told its size."""
STILL_QUALITY, PLAYED_QUALITY = 95, 80
"""Of the JPEGs; a played picture has half the bytes of one that is looked at."""
PAGE_AT, PAGE_TO = 0.95, 0.08
"""Parts of the plots' width: played to the first, they go on with the moment at the second."""


class Screen:
    """Picture and strip of one tab, in its thread.

    Attributes:
        result: what the log says of the frame that is shown.
        overlay_shown: whether anything is drawn over the picture.
        window_name: how much of the drive the plots show, one of `WINDOWS_S`.
    """

    def __init__(self, tab: "Tab") -> None:
        self._tab = tab
        self._strip = Strip(tab.client.gui)
        self._frames: FramePictures | None = None
        self._layout = FIRST_LAYOUT
        self._window = (0.0, 1.0)
        self.result: FrameResult | None = None
        self.overlay_shown = True
        self.window_name = DEFAULT_WINDOW
        self._outlined: int | None = None

    def open(self, drive: Drive) -> None:
        """Begin with a drive, at the tab's row."""
        self._frames = FramePictures(drive)
        self._tab.view.set_size(drive.header.image_size)
        self._tab.birds_eye.load(drive.header)
        self._center_window()
        self.show_picture()
        self._strip.show_frame()

    def close(self) -> None:
        """Let go of the drive, and show nothing."""
        self._tab.birds_eye.come_back()
        if self._frames is not None:
            self._frames.close()
        self._frames, self.result = None, None
        self._strip.hide()

    def set_window(self, name: str) -> None:
        """How much of the drive the plots show."""
        if name in WINDOWS_S:
            self.window_name = name
            self._center_window()
            self.show_strip()
            self.show_bar()

    def next_window(self, wider: bool) -> None:
        """A wider or a narrower window."""
        names = list(WINDOWS_S)
        place = names.index(self.window_name) + (1 if wider else -1)
        self.set_window(names[min(max(place, 0), len(names) - 1)])

    def switch_overlay(self) -> None:
        """The picture with all that is drawn over it, or bare."""
        self.overlay_shown = not self.overlay_shown
        self.show_picture()

    def switch_birds_eye(self) -> None:
        """The drive from above, or its picture again."""
        self._tab.opened  # noqa: B018 - raises where no drive is open
        self._tab.boxes.stop()
        self._tab.birds_eye.toggle()
        self.show_picture()
        self.show_bar()

    def resized(self, about: str) -> None:
        """The browser has told an element's size."""
        layout = StripLayout.parse(about)
        if layout is not None and layout != self._layout:
            self._layout = layout
            if self._tab.drive is not None:
                self.show_strip()

    def turn(self, quality: int) -> None:
        """Show the tab's row: the picture with its cursors."""
        tab = self._tab
        with tab.client.atomic():
            self.show_picture(quality)
            self._show_now()
        tab.client.flush()

    def follow(self) -> None:
        """Bring time line and plots to where the tab's row is, where they do not hold it yet."""
        tab = self._tab
        if self._page(tab.time_s, tab.playing.now):
            self.show_strip()
        elif self._outlined != tab.selected:
            self.show_timeline()

    def show_picture(self, quality: int = STILL_QUALITY) -> None:
        """The picture of the tab's row."""
        tab = self._tab
        if self._frames is None:
            return
        self.result = self._frames.result(tab.row)
        # Boxes that are corrected stand over a bare picture.
        drawn = self.result if self.overlay_shown and not tab.boxes.active else None
        image, trouble = self._frames.image(tab.row, drawn)
        if trouble:
            tab.notify("This picture is missing", trouble, trouble=True)
        tab.playing.sent()
        tab.view.show(image, quality)
        tab.birds_eye.show(self.result)
        tab.boxes.redraw()

    def show_strip(self) -> None:
        """Time line, plots and cursors."""
        tab = self._tab
        self._strip.show_plots(tab.opened, self._window, self._layout)
        self.show_timeline()
        self._show_now()

    def show_timeline(self) -> None:
        """The time line with what is said of the events."""
        tab = self._tab
        self._outlined = tab.selected
        self._strip.show_timeline(tab.opened, tab.review, self._window, tab.selected, self._layout)

    def show_bar(self) -> None:
        """The buttons of playback."""
        tab = self._tab
        several = bool(tab.opened.events)
        self._strip.show_bar(
            tab.playing.now, tab.playing.speed, self.window_name, several, tab.birds_eye.active
        )

    def _show_now(self) -> None:
        self._strip.show_now(self._tab.opened, self._tab.row, self._window, self._layout)

    def _center_window(self) -> None:
        tab = self._tab
        self._window = window_around(tab.time_s, WINDOWS_S[self.window_name], tab.opened.duration_s)

    def _page(self, time_s: float, plays: bool) -> bool:
        """Move the plots' window where the moment has left it; whether it did."""
        window_s, duration_s = WINDOWS_S[self.window_name], self._tab.opened.duration_s
        start_s, end_s = self._window
        if window_s is None or window_s >= duration_s:
            return False
        at_edge = time_s > start_s + PAGE_AT * (end_s - start_s) and end_s < duration_s
        if plays and at_edge:
            self._window = window_around(time_s + (0.5 - PAGE_TO) * window_s, window_s, duration_s)
            return True
        if start_s <= time_s <= end_s:
            return False
        self._window = window_around(time_s, window_s, duration_s)
        return True
