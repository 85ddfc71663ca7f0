"""Checking a calibration: measuring on the road, the vehicles on this picture, and playing the drive."""

import math
import threading
import time
from collections.abc import Callable
from html import escape
from typing import Protocol

import viser

from fcw.camera.calibration import Calibration
from fcw.frame import Frame
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.check_lines import length_lines, vehicle_lines
from fcw_viz.calibrate_app.drawing.drawing import Measured
from fcw_viz.calibrate_app.drawing.overlay import PictureOverlay
from fcw_viz.calibrate_app.frame_detector import Found, FrameDetector, MakeDetector, make_acf
from fcw_viz.calibrate_app.measure import (
    GroundMeasurement,
    length_words,
    measure_length,
    measure_point,
    point_words,
)
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.controls import on_button, on_choice
from fcw_viz.page.picture.lines import LineOverlay
from fcw_viz.page.picture.view import PictureView
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.playback import KEY_ECHO_S, STOP_CHECK_S, Playback
from fcw_viz.page.style import set_html, text_block

PLAYBACK_QUALITY = 80
"""Of the JPEGs of a drive that plays: a quarter of the bytes of the pictures that are clicked in."""
SLIDER_S = 0.4
"""While the drive plays, everything but the picture follows in such steps."""
REAL_TIME = "1×"
SPEEDS = {"½×": 0.5, REAL_TIME: 1.0, "2×": 2.0}
PLAY, STOP = "Play (space)", "Pause (space)"
MEASURE_WORDS = "Click on the road to read the distance. A second click measures between the two points."
PREPARING_WORDS = "Preparing the detector; the first time takes a few seconds."
LOOKING_WORDS = "Looking for vehicles."


class CheckDesk(Protocol):
    """What the panel needs of its desk."""

    client: viser.ClientHandle
    view: PictureView
    overlay: PictureOverlay
    pictures: Pictures
    tool: Tool
    frame_index: int

    @property
    def state(self) -> SessionState:
        """The moment that is shown."""
        ...

    def use(
        self, tool: Tool, on_click: Callable[[float, float], None] | None = None, words: str = ""
    ) -> None:
        """Take a tool; clicks on the picture go to `on_click`, and the page says `words`."""
        ...

    def run(self, work: Callable[[], object]) -> None:
        """Do something in the desk's thread."""
        ...

    def refresh(self) -> None:
        """Show the newest moment."""
        ...

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        """Tell the person something."""
        ...


class CheckPanel:
    """The three tools. All but decoding and detection happens in the desk's thread.

    Attributes:
        measure_switch: takes the measuring tool.
        measured: what was measured, in words.
        vehicle_switch: shows vehicles.
        vehicles: what was found, in words.
    """

    def __init__(self, gui: viser.GuiApi, desk: CheckDesk, make_detector: MakeDetector = make_acf) -> None:
        self._desk = desk
        self._clicked: list[tuple[float, float]] = []
        self._measured_frame = -1
        self._asked: tuple[int, Calibration] | None = None
        self._refreshed_s = self._toggled_s = -math.inf
        self._played_index = -1
        self._closed = False
        self._boxes = LineOverlay(desk.view, desk.client, "vehicles", lambda: desk.overlay.label_areas)
        self._length = LineOverlay(desk.view, desk.client, "length", lambda: desk.overlay.label_areas)
        self._detector = FrameDetector(lambda found: desk.run(lambda: self._show_found(found)), make_detector)
        self._playback = Playback(
            desk.pictures, self._show_played, lambda message: desk.run(lambda: self._ended(message))
        )

        self.measure_switch = gui.add_checkbox(
            "Measure", False, hint="Click any point on the road to read its distance"
        )
        self.measured = gui.add_html("")
        self.vehicle_switch = gui.add_checkbox(
            "Vehicles", False, hint="Vehicles that the detector finds in this picture, with their distances"
        )
        self.vehicles = gui.add_html("")
        several = desk.pictures.count > 1
        self._play_button = gui.add_button(
            PLAY,
            color="gray",
            icon=viser.Icon.PLAYER_PLAY,
            hint="Play the drive with the distance rows over it",
            visible=several,
        )
        self._speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value=REAL_TIME, visible=several)
        play_command = gui.add_command("Play or pause the drive", hotkey="space")

        on_choice(self.measure_switch, desk.run, self.measure)
        on_choice(self.vehicle_switch, desk.run, self._switch_vehicles)
        on_choice(self._speed, desk.run, self._change_speed)
        on_button(self._play_button, desk.run, self.toggle_playing)

        @play_command.on_trigger
        async def _(_: viser.CommandEvent) -> None:
            desk.run(self.toggle_playing)

    def show(self, state: SessionState) -> None:
        """Bring the tools to a moment of the session, and to the desk's tool and picture."""
        result = state.shown
        self.measure_switch.disabled = self.vehicle_switch.disabled = result is None
        self._show_measured(state)
        if result is None or not self.vehicle_switch.value:
            self._forget_vehicles("")
        elif not self._playback.playing:
            self._ask(result.calibration)

    def close(self) -> None:
        """The tab is gone: end what runs."""
        self._closed = True
        self._playback.stop()
        self._detector.close()

    def measure(self, measuring: bool) -> None:
        """Take the measuring tool, or put it away."""
        self._clicked = []
        if measuring:
            self._desk.use(Tool.MEASURE, self._click, MEASURE_WORDS)
        elif self._desk.tool is Tool.MEASURE:
            self._desk.use(Tool.POINTS)

    def toggle_playing(self) -> None:
        """Play from the present picture on, or stop; from the last picture on it begins anew."""
        now_s = time.monotonic()
        if now_s - self._toggled_s < KEY_ECHO_S or self._desk.pictures.count < 2:
            return
        self._toggled_s = now_s
        if self._playback.playing:
            self._playback.stop()
            return
        last = self._desk.frame_index >= self._desk.pictures.count - 1
        self._play(0 if last else self._desk.frame_index)

    # Measuring

    def _click(self, column_px: float, row_px: float) -> None:
        """A click with the measuring tool; the third one begins anew."""
        self._clicked = [*(self._clicked if len(self._clicked) < 2 else []), (column_px, row_px)]
        self._measured_frame = self._desk.frame_index
        self._show_measured(self._desk.state)

    def _show_measured(self, state: SessionState) -> None:
        measuring = self._desk.tool is Tool.MEASURE
        if self.measure_switch.value != measuring:
            self.measure_switch.value = measuring
        if not measuring or self._measured_frame != self._desk.frame_index:
            self._clicked = []
        if state.shown is None or not self._clicked:
            self._desk.overlay.measure(None)
            self._length.show(())
            set_html(self.measured, "")
            return
        calibration, imperial = state.shown.calibration, state.document.imperial
        row_sigma_px = state.document.row_sigma_px
        points = [measure_point(calibration, *click, row_sigma_px) for click in self._clicked]
        words = [point_words(point, imperial) for point in points]
        self._desk.overlay.measure(Measured(*self._clicked[-1], words[-1]))
        length = _length(points)
        if length is not None:
            measured = measure_length(calibration, *length, row_sigma_px)
            words.append(f"Between the two: {length_words(measured, imperial)}")
        self._length.show(length_lines(*length, imperial) if length is not None else ())
        set_html(self.measured, text_block("".join(f"<p>{escape(line)}</p>" for line in words)))

    # Vehicles

    def _switch_vehicles(self, _: bool) -> None:
        self._forget_vehicles("")
        self.show(self._desk.state)

    def _ask(self, calibration: Calibration) -> None:
        """Look at the present picture, unless that is under way or done."""
        frame = self._desk.pictures.read(self._desk.frame_index)
        if (frame.index, calibration) == self._asked:
            return
        self._forget_vehicles(LOOKING_WORDS if self._detector.ready else PREPARING_WORDS)
        self._asked = frame.index, calibration
        self._detector.ask(frame, calibration)

    def _show_found(self, found: Found) -> None:
        """What the detector found, unless picture, calibration or switch have changed since."""
        if (found.frame_index, found.calibration) == self._asked and not self._playback.playing:
            self._draw_vehicles(found)

    def _draw_vehicles(self, found: Found) -> None:
        self._boxes.show(vehicle_lines(found.vehicles, self._desk.state.document.imperial))
        count = len(found.vehicles)
        words = found.trouble or (
            f"{count} vehicle{'s' * (count != 1)} found." if count else "No vehicle found."
        )
        set_html(self.vehicles, _dim(words))

    def _forget_vehicles(self, words: str) -> None:
        self._asked = None
        self._detector.forget()
        self._boxes.show(())
        set_html(self.vehicles, _dim(words))

    # Playing

    def _change_speed(self, _: str) -> None:
        if self._playback.playing:
            self._play(self._desk.frame_index)

    def _play(self, start_index: int) -> None:
        self._forget_vehicles("")
        self._played_index = self._desk.frame_index
        self._play_button.label, self._play_button.icon = STOP, viser.Icon.PLAYER_STOP
        self._playback.play(start_index, SPEEDS[self._speed.value])

    def _show_played(self, frame: Frame) -> None:
        """Have a picture of the drive that plays shown; in the playback's thread, which waits for it."""
        result, found = self._desk.state.shown, None
        if self.vehicle_switch.value and result is not None and self._detector.ready:
            found = self._detector.detect_now(frame, result.calibration)
        shown = threading.Event()

        def show() -> None:
            self._turn_to(frame, found)
            shown.set()

        self._desk.run(show)
        while self._playback.playing and not shown.wait(STOP_CHECK_S):
            pass

    def _turn_to(self, frame: Frame, found: Found | None) -> None:
        """Show a played picture, unless playing was stopped or somebody went to another one."""
        desk = self._desk
        if not self._playback.playing:
            return
        if desk.frame_index != self._played_index:
            self._playback.stop()
            return
        with desk.client.atomic():
            desk.view.show(frame.image, quality=PLAYBACK_QUALITY)
            if found is not None and desk.state.shown and found.calibration == desk.state.shown.calibration:
                self._draw_vehicles(found)
            else:
                self._boxes.show(())
        desk.frame_index = self._played_index = frame.index
        now_s = time.monotonic()
        if now_s - self._refreshed_s > SLIDER_S:
            self._refreshed_s = now_s
            desk.refresh()

    def _ended(self, message: str) -> None:
        """Playing has ended: the present picture again, with every pixel as it is."""
        desk = self._desk
        if self._closed or self._playback.playing:  # it has begun again
            return
        self._play_button.label, self._play_button.icon = PLAY, viser.Icon.PLAYER_PLAY
        if message:
            desk.notify(message, trouble=True)
        desk.view.show(desk.pictures.read(desk.frame_index).image)
        self._forget_vehicles("")
        desk.refresh()


def _length(
    points: list[GroundMeasurement | None],
) -> tuple[GroundMeasurement, GroundMeasurement] | None:
    """Both ends, where both are on the road."""
    ends = [point for point in points if point is not None]
    return (ends[0], ends[1]) if len(ends) == 2 else None


def _dim(words: str) -> str:
    return text_block(f'<p class="dim">{escape(words)}</p>') if words else ""
