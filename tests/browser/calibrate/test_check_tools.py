"""Measuring, vehicles and playback as a person uses them, on the shipped drive with its calibration."""

import re
import shutil
import threading
from collections.abc import Generator
from pathlib import Path

import pytest
from browser_page import BrowserPage

from fcw.camera.file import read_calibration
from fcw_viz.calibrate_app.server import CalibrationPage

DEMO = Path(__file__).parents[3] / "recordings" / "demo"
DEMO_FRAMES = 1200
CALIBRATION = read_calibration(DEMO / "drive.calibration.yaml")


@pytest.fixture
def drive_page(tmp_path: Path) -> Generator[CalibrationPage]:
    for name in ("drive.mp4", "drive.calibration.yaml"):
        shutil.copy(DEMO / name, tmp_path)
    page = CalibrationPage(tmp_path / "drive.mp4", tmp_path / "drive.calibration.yaml")
    yield page
    page.stop()


def check_tools(opened: BrowserPage) -> BrowserPage:
    opened.page.get_by_role("tab", name="Check").click()
    return opened


NUMBER = "input[inputmode=decimal], input[inputmode=numeric]"
"""The slider over the pictures says their number, counted from 1; it is the first of the page's numbers."""


def picture_number(opened: BrowserPage) -> int:
    return int(opened.page.locator(NUMBER).first.input_value())


def wait_until_picture(opened: BrowserPage, condition: str) -> None:
    """Wait until the number, n, is as a JavaScript expression says."""
    script = (
        f"(selector) => {{ const n = Number(document.querySelector(selector).value); return {condition}; }}"
    )
    opened.page.wait_for_function(script, arg=NUMBER)


def test_a_click_on_the_road_is_measured(drive_page, open_page):
    tab = check_tools(open_page(drive_page.url))
    tab.page.get_by_role("checkbox", name="Measure").click()
    tab.page.get_by_text("Click on the road to read the distance.").wait_for()

    def measure(distance_m: float, lateral_m: float) -> None:
        column_px = CALIBRATION.column_at(lateral_m, distance_m)
        row_px = CALIBRATION.row_at(distance_m)
        tab.click(column_px, row_px)

    def distances_m() -> list[float]:
        texts = tab.page.get_by_text(re.compile(r"^[0-9.]+ m \(")).all_inner_texts()
        return [float(text.split(" ")[0]) for text in texts]

    measure(8.0, -1.2)
    tab.page.get_by_text("1.2 m to the right").wait_for()
    # A mouse points at whole pixels of the screen, here 1.3 rows of the picture apart.
    near_m = CALIBRATION.distance_at(CALIBRATION.row_at(8.0) + 1.3)
    assert distances_m()[0] == pytest.approx(8.0, abs=8.0 - near_m)
    measure(16.0, 1.5)
    tab.page.get_by_text("Between the two: 8.").wait_for()
    assert len(distances_m()) == 2
    tab.click(900.0, 100.0)
    tab.page.get_by_text("above the horizon: sky").wait_for()
    assert distances_m() == []
    tab.page.keyboard.press("Escape")
    tab.page.get_by_text("above the horizon: sky").wait_for(state="detached")
    assert not tab.page.get_by_role("checkbox", name="Measure").is_checked()
    assert len(drive_page.session.state.document.marks) == 3  # no click of the tool became a point


def test_vehicles_of_the_picture_shown_are_found(drive_page, open_page):
    tab = check_tools(open_page(drive_page.url))
    tab.page.get_by_role("checkbox", name="Vehicles").click()
    tab.page.get_by_text(re.compile("^[1-9] vehicles? found")).wait_for()
    tab.page.get_by_role("checkbox", name="Vehicles").click()
    tab.page.get_by_text(re.compile("vehicles? found")).wait_for(state="detached")


def test_the_drive_plays_in_one_tab_and_stops_by_the_space_key(drive_page, open_page, wait_for):
    still, tab = open_page(drive_page.url), check_tools(open_page(drive_page.url))
    tab.page.get_by_role("button", name="Play").click()
    tab.page.get_by_role("button", name="Pause").wait_for()
    wait_until_picture(tab, "n > 15")
    tab.page.keyboard.press("Space")
    tab.page.get_by_role("button", name="Play").wait_for()
    wait_for(lambda: all(thread.name != "playback" for thread in threading.enumerate()))
    _, served = drive_page._tabs.values()
    wait_for(lambda: picture_number(tab) == served.desk.frame_index + 1)
    stopped_at = picture_number(tab)
    assert 15 < stopped_at < DEMO_FRAMES
    assert picture_number(still) == 1  # the other tab's picture
    # From there the keys go on.
    tab.page.keyboard.press("n")
    wait_until_picture(tab, f"n === {stopped_at + 1}")


def test_a_server_that_ends_while_a_tab_plays_leaves_nothing_running(drive_page, open_page):
    tab = check_tools(open_page(drive_page.url))
    tab.page.get_by_role("button", name="Play").click()
    tab.page.get_by_role("button", name="Pause").wait_for()
    drive_page.stop()
    assert all(thread.name not in ("playback", "detect") for thread in threading.enumerate())


def test_a_tab_closed_while_it_plays_ends_its_playback_without_a_word(
    recwarn: pytest.WarningsRecorder, drive_page, open_page, wait_for
):
    tab = check_tools(open_page(drive_page.url))
    tab.page.get_by_role("button", name="Play").click()
    wait_until_picture(tab, "n > 5")
    (served,) = drive_page.tabs
    tab.page.close()
    wait_for(lambda: drive_page.session.state.people == ())
    wait_for(lambda: all(thread.name != "playback" for thread in threading.enumerate()))
    served.desk.view.pan(1.0, 0.0)  # as a picture that was on its way
    assert [str(warning.message) for warning in recwarn] == []
