"""Somebody with a picture of an empty parking bay, from the first screen to a saved calibration."""

from pathlib import Path

import cv2
import numpy as np
from calibrate_helpers import OpenPage, Person, Serve, WaitFor

from fcw.camera.file import default_path, read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw_viz.calibrate_app.server import CalibrationPage

CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
BAY_M = ((7.0, 1.5), (7.9, -0.83), (12.57, 0.96), (11.67, 3.29))
"""Ahead and to the left: 2.5 x 5 m, turned by 21 degrees."""


def corners_px() -> list[tuple[float, float]]:
    return [(CAMERA.column_at(left_m, ahead_m), CAMERA.row_at(ahead_m)) for ahead_m, left_m in BAY_M]


def picture_of_a_bay(folder: Path) -> Path:
    picture = np.full((720, 1280, 3), (95, 92, 90), np.uint8)
    picture[: round(CAMERA.horizon_row_px)] = (225, 205, 180)
    cv2.polylines(picture, [np.array(corners_px(), np.int32)], True, (240, 240, 240), 3, cv2.LINE_AA)
    path = folder / "bay.png"
    cv2.imwrite(str(path), picture)
    return path


def corner_count(page: CalibrationPage) -> int:
    return sum(len(rectangle.corners_px) for rectangle in page.session.state.document.rectangles)


def test_a_parking_bay_is_calibrated_in_seven_actions_dragged_and_undone(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = picture_of_a_bay(tmp_path)
    page = serve(source)
    browser = open_page(page.url)
    person = Person(browser)
    person.button("A rectangle of known size").click()
    wait_for(lambda: "Click a corner of a rectangle" in person.banner)
    for count, corner in enumerate(corners_px(), 1):
        browser.click(*corner)
        wait_for(lambda count=count: corner_count(page) == count)
    wait_for(lambda: "type one of its sides" in person.banner)
    person.field("Size from").click()
    browser.page.get_by_role("option", name="Parking bay, Germany: 2.50 x 5.00 m").click()
    wait_for(lambda: "A reading of 40 m means" in person.banner)

    # The rule's sides are the right way round, whichever corner was the first.
    state = page.session.state
    first_m, second_m = state.document.rectangles[0].sides_m
    assert first_m is not None
    assert second_m is not None
    assert (first_m.value, second_m.value) == (2.5, 5.0)
    assert not state.solution.troubles
    assert browser.page.get_by_text("Result: ").is_visible()

    before = state.document.rectangles[0].corners_px[2]
    browser.drag(before, (before[0] + 40, before[1] + 12))
    wait_for(lambda: page.session.state.document.rectangles[0].corners_px[2][0] > before[0] + 20)
    person.press("Control+z")
    wait_for(lambda: page.session.state.document.rectangles[0].corners_px[2] == before)

    wait_for(lambda: "A reading of 40 m means" in person.banner)
    browser.page.locator(".fcw-banner button", has_text="Save").click()
    wait_for(lambda: "Saved" in person.banner)
    saved = read_calibration(default_path(source))
    low_m, high_m = saved.distance_interval(CAMERA.row_at(20.0))
    assert low_m < 20 < high_m
    assert len(saved.rectangles) == 1


def test_a_typed_side_after_the_corners_is_enough(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(picture_of_a_bay(tmp_path))
    browser = open_page(page.url, window_px=(390, 844))
    person = Person(browser)
    person.button("A rectangle of known size").click()
    wait_for(lambda: "Click a corner of a rectangle" in person.banner)
    for count, corner in enumerate(corners_px(), 1):
        browser.click(*corner)
        wait_for(lambda count=count: corner_count(page) == count)
    person.field("Side 1–2").fill("2,5 m")
    wait_for(lambda: page.session.state.solution.can_save)
    rectangle = page.session.state.document.rectangles[0]
    assert rectangle.first_side_m is not None
    assert rectangle.first_side_m.value == 2.5
    assert rectangle.second_side_m is None
    person.button("Remove rectangle").click()
    wait_for(lambda: page.session.state.document.rectangles == ())
