"""The check panel on a tab without a browser: what it says, and that nothing stale is ever drawn."""

import contextlib
import html
import queue
import re
import shutil
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.sources import open_source
from fcw_viz.calibrate_app.document.edits import MoveMark, SetHeight, SetUnits
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.check_lines import vehicle_lines, vehicle_words
from fcw_viz.calibrate_app.drawing.drawing import Measured
from fcw_viz.calibrate_app.frame_detector import RangedVehicle, range_vehicle
from fcw_viz.calibrate_app.measure import measure_length, measure_point, point_words
from fcw_viz.calibrate_app.panels import check as check_panel
from fcw_viz.calibrate_app.panels.check import CheckPanel
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.calibrate_app.tools import Tool
from fcw_viz.page.picture.label_layout import Area
from fcw_viz.page.picture.lines import LineOverlay
from fcw_viz.page.pictures import Pictures

DEMO = Path(__file__).parents[3] / "recordings" / "demo"
WAIT_S = 120.0
CROWDED = Area(590.0, 320.0, 660.0, 345.0)
GROUND, SKY = (700.0, 450.0), (640.0, 100.0)


class FakeScene:
    """Keeps what is added, as the browser would show it."""

    def __init__(self) -> None:
        self.nodes: dict[str, SimpleNamespace] = {}

    def add_line_segments(self, name: str, points: np.ndarray, colors: np.ndarray, **_: object) -> object:
        return self._add(name, points=points, colors=colors)

    def add_label(self, name: str, text: str, position: tuple[float, float, float], anchor: str) -> object:
        return self._add(name, text=text, position=position)

    def _add(self, name: str, **properties: object) -> SimpleNamespace:
        self.nodes[name] = SimpleNamespace(visible=True, **properties)
        return self.nodes[name]

    def seen(self, start: str) -> list[SimpleNamespace]:
        return [node for name, node in self.nodes.items() if name.startswith(start) and node.visible]


class FakeView:
    """A picture of 1280x720 on as many pixels of the screen."""

    def __init__(self) -> None:
        self.window_px = (-0.5, -0.5, 1279.5, 719.5)
        self.pixels_per_screen_pixel = 1.0
        self.shown: list[int | None] = []
        self.view_changes: list[Callable[[], None]] = []

    def world(self, column_px: float, row_px: float, layer: int = 0) -> tuple[float, float, float]:
        return column_px, row_px, float(layer)

    def on_view_change(self, callback: Callable[[], None]) -> None:
        self.view_changes.append(callback)

    def show(self, image_bgr: np.ndarray, quality: int | None = None) -> None:
        self.shown.append(quality)


class FakeTab:
    """A tab whose thread is the test's: what runs in it waits for `work`."""

    def __init__(self, server: viser.ViserServer, session: CalibrationSession, pictures: Pictures) -> None:
        self.scene = FakeScene()
        self.client: Any = SimpleNamespace(scene=self.scene, atomic=contextlib.nullcontext)
        self.view: Any = FakeView()
        self.measured: Measured | None = None
        self.overlay: Any = SimpleNamespace(
            measure=lambda measured: setattr(self, "measured", measured), label_areas=()
        )
        self.pictures = pictures
        self.session = session
        self.person = session.join(lambda state: None)
        self.tool, self.frame_index = Tool.POINTS, 0
        self.notifications: list[str] = []
        self.click: Callable[[float, float], None] | None = None
        self.waiting: queue.Queue[Callable[[], object]] = queue.Queue()
        self.panel = CheckPanel(server.gui, self, lambda _: self.detector)
        self.detector = HeldDetector()

    @property
    def state(self) -> SessionState:
        return self.session.state

    def use(
        self, tool: Tool, on_click: Callable[[float, float], None] | None = None, words: str = ""
    ) -> None:
        self.tool, self.click = tool, on_click
        self.refresh()

    def run(self, work: Callable[[], object]) -> None:
        self.waiting.put(work)

    def refresh(self) -> None:
        self.panel.show(self.state)

    def notify(self, title: str, text: str = "", trouble: bool = False) -> None:
        self.notifications.append(title)

    def go_to(self, frame_index: int) -> None:
        self.view.show(self.pictures.read(frame_index).image)
        self.frame_index = frame_index
        self.refresh()

    def work(self) -> None:
        """Do the next thing that waits to be done in the tab's thread."""
        self.waiting.get(timeout=WAIT_S)()

    def work_until(self, reached: Callable[[], bool]) -> None:
        """Do what waits, until something holds."""
        while not reached():
            self.work()

    def words(self, handle: viser.GuiHtmlHandle) -> list[str]:
        return [html.unescape(words) for words in re.findall(r"<p[^>]*>(.*?)</p>", handle.content)]


class HeldDetector:
    """Finds one vehicle once it is let go, its width that of the pictures seen so far."""

    name = "held"

    def __init__(self) -> None:
        self.begun: queue.Queue[None] = queue.Queue()
        self.go_on: queue.Queue[None] = queue.Queue()

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        self.begun.put(None)
        self.go_on.get(timeout=WAIT_S)
        return (Detection(Box(600, 350, 60, 50), 1.0),)


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", verbose=False)
    yield server
    server.stop()


@pytest.fixture
def tab(server: viser.ViserServer, tmp_path: Path) -> Iterator[FakeTab]:
    for name in ("drive.mp4", "drive.calibration.yaml"):
        shutil.copy(DEMO / name, tmp_path)
    save_path = tmp_path / "drive.calibration.yaml"
    session = CalibrationSession.open(tmp_path / "drive.mp4", ImageSize(1280, 720), save_path)
    tab = FakeTab(server, session, Pictures(open_source(tmp_path / "drive.mp4")))
    yield tab
    for _ in range(5):
        tab.detector.go_on.put(None)
    tab.panel.close()
    session.close()


def shown_calibration(tab: FakeTab) -> Calibration:
    assert tab.state.shown is not None
    return tab.state.shown.calibration


def test_a_click_is_measured_and_a_second_one_gives_the_length(tab: FakeTab):
    tab.panel.measure(True)
    assert tab.tool is Tool.MEASURE
    assert tab.click is not None
    tab.click(*GROUND)
    calibration, sigma_px = shown_calibration(tab), tab.state.document.row_sigma_px
    first = measure_point(calibration, *GROUND, sigma_px)
    assert tab.measured == Measured(*GROUND, point_words(first))
    assert tab.words(tab.panel.measured) == [point_words(first)]
    tab.click(500.0, 400.0)
    second = measure_point(calibration, 500.0, 400.0, sigma_px)
    assert first is not None
    assert second is not None
    length = measure_length(calibration, first, second, sigma_px)
    words = tab.words(tab.panel.measured)
    assert words[:2] == [point_words(first), point_words(second)]
    assert f"{length.along_m:.1f} ± {length.along_sigma_m:.1f} m along the road" in words[2]
    assert tab.scene.seen("/lines/length/lines")
    tab.click(*SKY)
    assert tab.words(tab.panel.measured) == ["above the horizon: sky"]
    assert not tab.scene.seen("/lines/length/lines")


def test_what_is_measured_follows_the_calibration_and_the_units(tab: FakeTab):
    tab.panel.measure(True)
    assert tab.click is not None
    tab.click(*GROUND)
    before = tab.words(tab.panel.measured)
    mark = tab.state.document.marks[0]
    tab.session.apply(tab.person, MoveMark(mark.id, mark.column_px, mark.row_px + 5))
    tab.refresh()
    moved = measure_point(shown_calibration(tab), *GROUND, tab.state.document.row_sigma_px)
    assert tab.words(tab.panel.measured) == [point_words(moved)] != before
    tab.session.apply(tab.person, SetUnits(True))
    tab.refresh()
    assert tab.words(tab.panel.measured) == [point_words(moved, imperial=True)]


def test_measured_points_go_with_their_picture_and_with_the_tool(tab: FakeTab):
    tab.panel.measure(True)
    for leave in (lambda: tab.go_to(3), lambda: tab.use(Tool.POINTS)):
        tab.panel.measure(True)
        assert tab.click is not None
        tab.click(*GROUND)
        assert tab.measured is not None
        leave()
        assert tab.measured is None
        assert tab.words(tab.panel.measured) == []
    tab.panel.measure(True)
    tab.panel.measure(False)
    assert tab.tool is Tool.POINTS


def look_for_vehicles(tab: FakeTab) -> None:
    tab.panel.vehicle_switch.value = True
    tab.refresh()
    tab.detector.begun.get(timeout=WAIT_S)


def vehicle_labels(tab: FakeTab) -> list[str]:
    return [node.text for node in tab.scene.seen("/lines/vehicles/label")]


def test_vehicles_are_drawn_with_their_distances_once_they_are_found(tab: FakeTab):
    look_for_vehicles(tab)
    assert "Preparing the detector" in tab.words(tab.panel.vehicles)[0]
    assert vehicle_labels(tab) == []
    tab.detector.go_on.put(None)
    tab.work()
    vehicle = range_vehicle(shown_calibration(tab), Detection(Box(600, 350, 60, 50), 1.0))
    assert vehicle_labels(tab) == [vehicle_words(vehicle, False)]
    assert tab.words(tab.panel.vehicles) == ["1 vehicle found."]
    tab.refresh()  # nothing has changed: it is not looked at again
    assert tab.detector.begun.empty()
    tab.panel.vehicle_switch.value = False
    tab.refresh()
    assert tab.scene.seen("/lines/vehicles") == []


@pytest.mark.parametrize("change", ["picture", "calibration", "switch"])
def test_what_was_found_is_never_drawn_over_something_else(tab: FakeTab, change: str):
    look_for_vehicles(tab)
    tab.detector.go_on.put(None)
    late = tab.waiting.get(timeout=WAIT_S)  # found, but the tab is busy with this:
    if change == "picture":
        tab.go_to(5)
    elif change == "calibration":
        tab.session.apply(tab.person, SetHeight(1.4))
        tab.refresh()
    else:
        tab.panel.vehicle_switch.value = False
        tab.refresh()
    late()
    assert tab.scene.seen("/lines/vehicles") == []
    if change != "switch":
        tab.detector.go_on.put(None)
        tab.work()
        assert len(vehicle_labels(tab)) == 1


def test_drawn_vehicles_go_when_the_picture_changes(tab: FakeTab):
    look_for_vehicles(tab)
    tab.detector.go_on.put(None)
    tab.work()
    assert vehicle_labels(tab)
    tab.go_to(1)
    assert tab.scene.seen("/lines/vehicles") == []


def test_without_a_result_there_is_nothing_to_check(server: viser.ViserServer, tmp_path: Path):
    shutil.copy(DEMO / "drive.mp4", tmp_path)
    source = tmp_path / "drive.mp4"
    session = CalibrationSession.open(source, ImageSize(1280, 720), tmp_path / "drive.calibration.yaml")
    tab = FakeTab(server, session, Pictures(open_source(source)))
    tab.refresh()
    assert tab.panel.measure_switch.disabled
    assert tab.panel.vehicle_switch.disabled
    tab.panel.measure(True)
    assert tab.click is not None
    tab.click(*GROUND)
    assert tab.measured is None
    tab.panel.close()
    session.close()


def test_playing_ends_on_a_sharp_picture_and_with_the_tab(tab: FakeTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(check_panel, "KEY_ECHO_S", 0.0)
    monkeypatch.setattr(check_panel, "SLIDER_S", float("inf"))
    tab.go_to(1190)
    tab.panel.toggle_playing()
    tab.work_until(lambda: len(tab.view.shown) > 1 and tab.view.shown[-1] is None)
    assert tab.frame_index == 1199
    assert set(tab.view.shown[1:-1]) == {check_panel.PLAYBACK_QUALITY}
    tab.panel.toggle_playing()  # from the end it begins anew
    tab.work_until(lambda: tab.frame_index < 1199)
    tab.panel.toggle_playing()
    tab.work_until(lambda: tab.view.shown[-1] is None)
    assert tab.frame_index < 1199
    tab.panel.toggle_playing()
    tab.panel.close()
    assert all(thread.name != "playback" for thread in threading.enumerate())


def test_going_to_another_picture_while_it_plays_stops_there(tab: FakeTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(check_panel, "SLIDER_S", float("inf"))
    tab.panel.toggle_playing()
    tab.work_until(lambda: tab.frame_index > 2)
    next_one = tab.waiting.get(timeout=WAIT_S)  # another picture waits to be shown, but somebody was quicker:
    tab.go_to(700)
    next_one()
    tab.work()
    assert tab.frame_index == 700
    assert tab.view.shown[-2:] == [None, None]
    assert tab.waiting.empty()


def test_boxes_go_with_the_pictures_that_play(tab: FakeTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(check_panel, "SLIDER_S", float("inf"))
    look_for_vehicles(tab)
    tab.detector.go_on.put(None)
    tab.work()
    assert vehicle_labels(tab)
    tab.panel.toggle_playing()
    assert vehicle_labels(tab) == []
    tab.detector.go_on.put(None)
    tab.work()
    assert vehicle_labels(tab)
    tab.detector.begun.get(timeout=WAIT_S)
    tab.detector.begun.get(timeout=WAIT_S)  # looks at the next picture already
    tab.session.apply(tab.person, SetHeight(1.4))
    tab.detector.go_on.put(None)
    tab.work()
    assert vehicle_labels(tab) == []  # found by another calibration


def test_one_press_of_the_space_key_that_also_presses_the_button_counts_once(
    tab: FakeTab, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(check_panel, "KEY_ECHO_S", float("inf"))
    tab.panel.toggle_playing()
    tab.panel.toggle_playing()
    assert any(thread.name == "playback" for thread in threading.enumerate())


def test_words_of_vehicles_side_by_side_do_not_cover_each_other(tab: FakeTab):
    vehicles = [RangedVehicle(Box(600 + 24 * k, 350, 22, 20), 1.0, 60.0, 50.0, 75.0) for k in range(4)]
    overlay = LineOverlay(tab.view, tab.client, "crowd", lambda: (CROWDED,))
    overlay.show(vehicle_lines(vehicles, False))
    places = [(node.position[0], node.position[1]) for node in tab.scene.seen("/lines/crowd/label")]
    assert len(places) == 4
    for i, (column_px, row_px) in enumerate(places):
        for other_column_px, other_row_px in places[:i]:
            assert abs(row_px - other_row_px) >= 15 or abs(column_px - other_column_px) >= 60
    for column_px, row_px in places:  # nor what others have written
        assert not Area(column_px, row_px - 8, column_px + 60, row_px + 8).overlaps(CROWDED)
    tab.view.pixels_per_screen_pixel = 0.25
    for callback in tab.view.view_changes:
        callback()
    zoomed = [(node.position[0], node.position[1]) for node in tab.scene.seen("/lines/crowd/label")]
    assert zoomed != places
