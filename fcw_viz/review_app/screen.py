"""What a tab shows of its drive: the picture, and under it a strip with the time line and the plots."""

import json
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from fcw.logs.overlay import Rgb
from fcw.logs.records import FrameResult
from fcw.units import distance_text
from fcw_viz.page.picture.hover import HoverHints
from fcw_viz.page.picture.lines import LabelledLine, LineOverlay, box_line
from fcw_viz.page.script import run_script, turn_back, turn_to_tab
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.panels.boxes import BOXES
from fcw_viz.review_app.picture.birds_eye_view import BirdsEye
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.plots.signals import in_series
from fcw_viz.review_app.plots.values import FrameSignals, Run
from fcw_viz.review_app.runs.comparing import Comparing
from fcw_viz.review_app.time.axis import window_around
from fcw_viz.review_app.time.other_run import OtherRun
from fcw_viz.review_app.time.playing import DRAWN_PATIENCE_S, Playing
from fcw_viz.review_app.time.strip import DEFAULT_WINDOW, WINDOWS_S, Strip, StripLayout

FIRST_LAYOUT = StripLayout(1040.0, 300.0)
"""Layout of the strip before the browser has sent its size."""
STILL_QUALITY, PLAYED_QUALITY = 95, 80
"""JPEG qualities; a played picture has half the bytes of a still one."""
PAGE_AT, PAGE_TO = 0.95, 0.08
"""When playing reaches the first part of the plots' width, they move so that it is at the second part."""
OTHER_RUN_COLOR: Rgb = (255, 121, 0)
PANELS_S = 0.4
"""While the drive plays the panel at the right follows in such steps."""


class Screen:
    """Picture and strip of one tab; used only in the thread of the tab.

    Attributes:
        birds_eye: the view from above.
        hover: details of the vehicle under the mouse.
        overlay_shown: whether anything is drawn over the picture.
        result: result of the frame that is shown; None before there is one.
        window_name: how much of the drive the plots show, one of `WINDOWS_S`.
    """

    def __init__(
        self,
        tab: PageTab,
        place: Place,
        playing: Playing,
        boxes: BoxEditor,
        runs: Comparing,
        show_panels: Callable[[], None],
    ) -> None:
        self._tab, self._place = tab, place
        self._playing, self._boxes, self._runs = playing, boxes, runs
        self._other_lead = LineOverlay(tab.view, tab.client, "other")
        self._show_panels = show_panels
        self._strip = Strip(tab.client.gui)
        self._frames: FramePictures | None = None
        self._signals: FrameSignals | None = None
        self._signals_wait = False
        self._layout = FIRST_LAYOUT
        self._window = (0.0, 1.0)
        self._outlined: int | None = None
        self._rest_waits = False
        self._panels_s = float("-inf")
        self.birds_eye = BirdsEye(tab.client, tab.view)
        self.hover = HoverHints(tab.view, tab.client)
        self.overlay_shown = True
        self.result: FrameResult | None = None
        self.window_name = DEFAULT_WINDOW

    def open(self, drive: Drive, pictures: FramePictures) -> None:
        """Show a drive with its pictures, at the row of the place."""
        self._frames = pictures
        self._signals = FrameSignals(drive.log, self._signals_came)
        self._tab.view.set_size(drive.header.image_size)
        self.birds_eye.load(drive.header)
        self._center_window()
        self.show_picture()
        self._strip.show_frame()

    def turn_to_drive(self, drive: Drive, goes_on: bool) -> None:
        """Show a drive that has grown (`goes_on`) or was replaced, at the row of the place."""
        if self._frames is not None:
            self._frames.close()
        self._frames = FramePictures(drive)
        before = self._signals
        if before is not None:
            before.close()
        kept = before if goes_on else None
        self._signals = FrameSignals(drive.log, self._signals_came, kept)
        self._tab.view.set_size(drive.header.image_size)
        if not self._playing.now:
            self.show_picture()
        self._show_strip()

    def close(self) -> None:
        """Close the drive, and show nothing."""
        self.birds_eye.come_back()
        for reader in (self._frames, self._signals):
            if reader is not None:
                reader.close()
        self._frames = self._signals = self.result = None
        self.hover.show(None)
        self._strip.hide()

    def stop_reading(self) -> None:
        """End the thread that reads signals; may be called from any thread."""
        if self._signals is not None:
            self._signals.close()

    # What is chosen

    def set_window(self, name: str) -> None:
        """Choose how much of the drive the plots show."""
        if name in WINDOWS_S:
            self.window_name = name
            self._center_window()
            self._show_strip()
            self.show_bar()

    def next_window(self, wider: bool) -> None:
        """Choose the next wider or narrower window."""
        names = list(WINDOWS_S)
        index = names.index(self.window_name) + (1 if wider else -1)
        self.set_window(names[min(max(index, 0), len(names) - 1)])

    def switch_height(self) -> None:
        """Switch between higher plots under a lower picture and the usual heights."""
        run_script(self._tab.client, "window.fcwTaller();")

    def choose_plots(self) -> None:
        """Show the curves that were chosen."""
        kept = json.dumps(self._place.plots.kept_text())
        run_script(self._tab.client, f"localStorage.setItem('fcwPlots', {kept});")
        if self._place.drive is not None:
            self._show_strip()
            self._show_panels()

    def switch_overlay(self) -> None:
        """Switch everything that is drawn over the picture on or off."""
        self.overlay_shown = not self.overlay_shown
        self.show_picture()

    def switch_birds_eye(self) -> None:
        """Switch between the view from above and the picture."""
        self._place.opened  # noqa: B018 - raises where no drive is open
        self.leave_boxes()
        self.birds_eye.toggle()
        self.show_picture()
        self.show_bar()

    def leave_boxes(self) -> None:
        """Stop correcting boxes, and go back to the tab of the panel that was open before."""
        if self._boxes.active:
            self._boxes.stop()
            turn_back(self._tab.client, BOXES)

    def switch_boxes(self) -> None:
        """Start or stop correcting the boxes of the frame that is shown."""
        if self._boxes.active:
            self.leave_boxes()
        else:
            self._playing.stop()
            self._place.opened  # noqa: B018 - raises where no drive is open
            self.birds_eye.come_back()
            self._boxes.start()
            turn_to_tab(self._tab.client, BOXES)
        self.show_picture()
        self._show_panels()

    def resized(self, about: str) -> None:
        """Take the size of an element from the browser."""
        layout = StripLayout.parse(about)
        if layout is not None and layout != self._layout:
            self._layout = layout
            if self._place.drive is not None:
                self._show_strip()
                self.show_bar()

    # What is shown

    def refresh(self) -> None:
        """Update everything except the picture."""
        # Panels come first, because they set the size and colours of the ground.
        self._show_panels()
        if self._place.drive is not None:
            self._show_strip()
            self.show_bar()

    def turn_to(self, row: int, played: bool = False) -> None:
        """Show a frame, and update everything that depends on it."""
        self._place.row = row
        followed = self._place.follow_event()
        with self._tab.client.atomic():
            self.show_picture(PLAYED_QUALITY if played else STILL_QUALITY)
            self._show_now()
        self._tab.client.flush()
        now_s = time.monotonic()
        if not self._playing.now:
            # People look at the picture, so the browser draws it before anything else.
            self._rest_waits = True
            patience = threading.Timer(DRAWN_PATIENCE_S, self._tab.run, [self._show_rest])
            patience.daemon = True
            patience.start()
        elif followed or now_s - self._panels_s > PANELS_S:
            self._panels_s = now_s
            self._follow()
            self._show_panels()
        else:
            self._follow()

    def drawn(self) -> None:
        """Note that the browser has drawn a picture."""
        self._playing.drawn()
        self._show_rest()

    def show_picture(self, quality: int = STILL_QUALITY) -> None:
        """Show the picture of the present row."""
        if self._frames is None:
            return
        row = self._place.row
        result = self.result = self._frames.result(row)
        # Boxes are corrected on a picture with nothing else drawn over it.
        drawn = result if self.overlay_shown and not self._boxes.active else None
        image, trouble = self._frames.image(row, drawn)
        if trouble:
            self._tab.notify("This picture is missing", trouble, trouble=True)
        by_distance = sorted(result.tracks, key=lambda track: track.distance_m)
        self._place.plots.vehicles = tuple(track.track_id for track in by_distance)
        self._playing.sent()
        self._tab.view.show(image, quality)
        self.birds_eye.show(result)
        self.hover.show(drawn, self._place.opened.header.imperial)
        self._boxes.show(result, partial(self._frames.words, drawn))
        self._other_lead.show(self._other_line(row))

    def _other_line(self, row: int) -> list[LabelledLine]:
        """The line for the lead of the other run."""
        other, other_row = self._runs.other, self._runs.row_at(row)
        if other is None or other_row is None or self.birds_eye.active or not self.overlay_shown:
            return []
        lead = other.log.result_at(other.frame_index(other_row)).lead
        if lead is None:
            return []
        text = f"{other.name}: {distance_text(lead.distance_m, other.header.imperial)}"
        return [box_line(lead.box, OTHER_RUN_COLOR, text, above=False)]  # the shown run's words are above

    def show_bar(self) -> None:
        """Show the buttons of playback."""
        several = bool(self._place.opened.events)
        playing = self._playing
        self._strip.show_bar(
            playing.now, playing.speed, self.window_name, several, self.birds_eye.active, self._layout
        )

    def _show_rest(self) -> None:
        """Update what depends on the shown frame: the plots, and the panel on the right."""
        if self._rest_waits and self._place.drive is not None:
            self._rest_waits = False
            with self._tab.client.atomic():
                self._follow()
                self._show_panels()

    def _follow(self) -> None:
        """Move time line and plots to the present row if they do not contain it."""
        if self._page(self._place.time_s, self._playing.now):
            self._show_strip()
        elif self._outlined != self._place.selected:
            self._show_timeline()

    def _show_strip(self) -> None:
        """Show time line, plots and cursors."""
        self._show_plots()
        self._show_timeline()
        self._show_now()

    def _show_plots(self) -> None:
        drive, chosen, signals = self._place.opened, self._place.plots.chosen, self._signals
        run, other = Run.of(drive, *self._window, signals), self._runs.other
        runs = [run]
        if other is not None:
            run = replace(run, name=drive.name)
            runs = [run, Run.of(other, *self._window, name=other.name, first_ns=drive.first_ns)]
        reading = False
        if signals is not None and not all(map(in_series, chosen)):
            signals.want(run.rows)
            reading = signals.reading
        self._strip.show_plots(
            runs, chosen, self._window, self._layout, drive.header.imperial, reading, drive.zero_utc_ns
        )

    def _signals_came(self) -> None:
        """Note that more signals have been read; runs in the thread that reads them."""
        if not self._signals_wait:
            self._signals_wait = True
            self._tab.run(self._draw_signals)

    def _draw_signals(self) -> None:
        self._signals_wait = False
        if self._place.drive is not None:
            self._show_plots()
            self._show_now()

    def _show_timeline(self) -> None:
        """Show the time line with the verdicts on the events."""
        place = self._place
        self._outlined = place.selected
        other = OtherRun(self._runs.events(), self._runs.later_s, self._runs.differences or ())
        self._strip.show_timeline(
            place.opened,
            place.review,
            self._window,
            place.selected,
            self._layout,
            place.marked,
            other,
            place.session.reviewer,
        )

    def _show_now(self) -> None:
        self._strip.show_now(self._place.opened, self._place.row, self._window, self._layout)

    def _center_window(self) -> None:
        place = self._place
        self._window = window_around(place.time_s, WINDOWS_S[self.window_name], place.opened.duration_s)

    def _page(self, time_s: float, plays: bool) -> bool:
        """Move the window of the plots if the time has left it; returns whether it had."""
        window_s, duration_s = WINDOWS_S[self.window_name], self._place.opened.duration_s
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
