"""Somebody with a picture of vehicles ahead and their number plates, from the first screen to the file."""

import math
from pathlib import Path

import cv2
import numpy as np
from calibrate_helpers import OpenPage, Person, Serve, WaitFor

from fcw.camera.file import default_path, read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera

CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
PLATE_M, OVERHANG_M = 0.52, 0.75
HANDLE_PX = 28.0
"""Across, with its ticks."""
REARS_M = ((6.0, -0.6), (16.0, -6.0))


def clicks() -> list[tuple[float, float]]:
    """Two ends and a tyre of each."""
    found = []
    for rear_m, left_m in REARS_M:
        plate = CAMERA.ground_box(rear_m, left_m, PLATE_M, 0.8)
        found += [(plate.x, plate.y), (plate.x + plate.w, plate.y)]
        tyre_m = rear_m + OVERHANG_M
        found.append((CAMERA.column_at(left_m + 0.7, tyre_m), CAMERA.row_at(tyre_m)))
    return found


def picture_of_cars(folder: Path) -> Path:
    picture = np.full((720, 1280, 3), (95, 92, 90), np.uint8)
    picture[: round(CAMERA.horizon_row_px)] = (225, 205, 180)
    for (rear_m, left_m), plate in zip(reversed(REARS_M), reversed(clicks()[::3]), strict=True):
        body = CAMERA.ground_box(rear_m, left_m, 1.8, 1.5)
        box = [round(v) for v in (body.x, body.y, body.x + body.w, body.y + 0.85 * body.h)]
        cv2.rectangle(picture, (box[0], box[1]), (box[2], box[3]), (120, 60, 40), -1)
        width_px = CAMERA.ground_box(rear_m, left_m, PLATE_M, 0.8).w
        ends = [
            (round(plate[0]), round(plate[1])),
            (round(plate[0] + width_px), round(plate[1] + width_px / 5)),
        ]
        cv2.rectangle(picture, ends[0], ends[1], (240, 240, 240), -1)
    path = folder / "cars.png"
    cv2.imwrite(str(path), picture)
    return path


def test_two_plates_and_the_kind_of_camera_are_enough_on_a_phone(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = picture_of_cars(tmp_path)
    page = serve(source)
    browser = open_page(page.url, window_px=(390, 844))
    person = Person(browser)
    person.button("Number plates ahead").click()
    wait_for(lambda: "one end of a number plate" in person.banner)
    # What to do with them is in sight, though the way stands at the end of a long list.
    wait_for(lambda: 390 < person.heading_y("Number plates") < 844)

    def apart_px(ends: list[tuple[float, float]]) -> float:
        return math.dist(*(browser.screen_position(*end) for end in ends))

    places = clicks()
    for plate in (places[:3], places[3:]):
        fitted_px = apart_px(plate[:2])
        browser.click(*plate[0])  # zooms in, and no more
        wait_for(lambda ends=plate[:2], least_px=2 * fitted_px: apart_px(ends) > least_px)
        browser.wait_until_still()
        assert apart_px(plate[:2]) > HANDLE_PX
        for count, place in enumerate(plate, 1 + places.index(plate[0])):
            browser.click(*place)
            wait_for(lambda count=count: sum(map(len, page.session.state.document.plates)) == count)
        wait_for(lambda ends=plate[:2], most_px=1.01 * fitted_px: apart_px(ends) < most_px)
        browser.wait_until_still()
    wait_for(lambda: "choose your kind of camera" in person.banner)
    person.field("Kind of camera").click()
    browser.page.get_by_role("option", name="Phone, main camera").click()
    wait_for(lambda: "A reading of 40 m means" in person.banner)
    person.press("Control+s")
    wait_for(lambda: page.session.state.saved)
    saved = read_calibration(default_path(source))
    low_m, high_m = saved.distance_interval(CAMERA.row_at(20.0))
    assert low_m < 20 < high_m
    assert len(saved.plates) == 2
    person.button("Remove the last").click()
    wait_for(lambda: len(page.session.state.document.plates) == 1)
