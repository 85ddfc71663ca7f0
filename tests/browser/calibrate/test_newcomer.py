"""Somebody with a recorded clip and no tape measure, on any window, and what they type on the way."""

import math
import shutil
from pathlib import Path
from typing import Any

import pytest
from browser_page import NOTIFICATION
from calibrate_helpers import (
    DEMO_MARKS_PX,
    OpenPage,
    Person,
    Serve,
    WaitFor,
    copy_of_demo_drive,
    pictures_of_demo_drive,
)
from running.demo_cut import cut_demo

from fcw.camera.calibration import Gaussian
from fcw.camera.file import default_path, read_calibration
from fcw.self_calibration.turning.by_turns import LensByTurns
from fcw_viz.calibrate_app.document.besides.rectangles import AddCorner
from fcw_viz.calibrate_app.document.edits import AddMark, ChooseWay, SetHeight
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.document.ways.presets import DASH_PRESETS
from fcw_viz.calibrate_app.document.ways.ways import DASHES, RECTANGLE, TAPE
from fcw_viz.calibrate_app.session import Person as SessionPerson
from fcw_viz.cli import main

SOMEBODY = SessionPerson("somebody")
MOST_ACTIONS = 10
TRUE_HORIZON_ROW_PX, TRUE_HEIGHT = 329.8, "130 cm"
WINDOWS_PX = ((1400, 900), (1000, 700), (768, 1024), (390, 844))
_PLACES = """() => {
  const box = (node) => {
    const { left, top, right, bottom } = node.getBoundingClientRect();
    return [left, top, right, bottom];
  };
  return {
    canvas: box(window.__viserMutable.canvas),
    banner: box(document.querySelector('.fcw-banner')),
    tabs: box(document.querySelector('[role=tab]')),
    heading: box(document.querySelector('.fcw-step')),
    beyond: document.documentElement.scrollWidth - window.innerWidth,
  };
}"""


def test_a_clip_without_a_tape_measure_is_calibrated_in_ten_actions(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = copy_of_demo_drive(tmp_path)
    page = serve(source)
    person = Person(open_page(page.url))
    assert "Choose what you have" in person.banner
    actions = 0

    def done(count: int = 1) -> None:
        nonlocal actions
        actions += count

    person.button("A recorded clip, no tape measure").click()
    done()
    wait_for(lambda: "the camera's height above the road" in person.banner)
    person.field("Camera height").fill(TRUE_HEIGHT)
    done()
    wait_for(lambda: "Type the field of view" in person.banner)
    person.field("Kind of camera").click()
    person.browser.page.get_by_role("option", name="Phone, main camera").click()
    done(2)
    wait_for(lambda: "Use the horizon that the drive shows" in person.banner)
    person.button("Use this horizon").click()
    done()
    wait_for(lambda: "A reading of 40 m means" in person.banner)
    person.browser.page.locator(".fcw-banner button", has_text="Save").click()
    done()
    wait_for(lambda: "Saved" in person.banner)
    assert actions <= MOST_ACTIONS

    # What it says of itself is true of the drive.
    saved, true = read_calibration(default_path(source)), page.session.state
    assert true.saved
    assert abs(saved.horizon_row_px - TRUE_HORIZON_ROW_PX) < 4
    assert abs(saved.orientation.yaw_rad) < saved.orientation.yaw_sigma_rad < math.radians(0.6)
    for (_, row_px), true_m in zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True):
        low_m, high_m = saved.distance_interval(row_px)
        assert low_m < true_m < high_m
        assert abs(saved.distance_at(row_px) / true_m - 1) < 0.1
    page.stop()
    again = serve(source)
    assert again.session.state.saved
    assert again.session.state.document.way == "clip"
    # And it is what a run of that camera's drives looks for: one second of them is enough.
    short = cut_demo(tmp_path / "short", 0, 1)
    shutil.copy(default_path(source), default_path(short))
    assert main(["run", str(short), "--out", str(tmp_path / "out"), "--detector", "acf"]) == 0


def test_the_field_of_view_that_turns_show_is_taken_in_two_presses(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor, monkeypatch: pytest.MonkeyPatch
):
    told = LensByTurns(Gaussian(1000.0, 80.0))
    monkeypatch.setattr("fcw_viz.calibrate_app.proposals.drive_look.lens_by_turns", lambda _: told)
    page = serve(pictures_of_demo_drive(tmp_path))
    page.session.apply(SOMEBODY, ChooseWay("clip"), SetHeight(1.3))
    person = Person(open_page(page.url))
    person.button("Find the field of view from turns").click()
    person.button("Use this field of view").click()
    wait_for(lambda: page.session.state.document.field_of_view is not None)
    said = page.session.state.document.field_of_view
    assert said is not None
    assert said.prior.value == pytest.approx(2 * math.atan(0.64))
    # As much as 8 % of the focal length make of it.
    assert said.prior.sigma == pytest.approx(2 * math.atan(0.64) - 2 * math.atan(0.64 / 1.08), rel=0.1)
    wait_for(lambda: person.button("Use this field of view").count() == 0)
    assert person.browser.page.get_by_text("By the drive's turns, the field of view is 65 ± 4°.").count() == 1


def test_a_speed_is_refused_where_the_drive_does_not_show_how_fast_the_road_goes_by(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(pictures_of_demo_drive(tmp_path))
    page.session.apply(SOMEBODY, ChooseWay("speed"), SetHeight(1.3))
    person = Person(open_page(page.url))
    page.looks.horizon.wait()
    person.field("Mean speed").fill("50")
    wait_for(lambda: person.browser.page.locator(".fcw-wrong").count() == 1)
    assert "the road is too plain or too dark, or the car stands still" in person.words(".fcw-wrong")
    assert page.session.state.document.speed is None


def test_what_is_typed_is_understood_or_stays_with_what_was_expected(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    person = Person(open_page(page.url))

    def distances() -> list[float | None]:
        return [mark.distance_m for mark in page.session.state.document.marks]

    # Typed at once after the click, before there is a field: nothing is lost and nothing is selected.
    person.browser.click(*DEMO_MARKS_PX[0])
    person.type("7,6")
    wait_for(lambda: distances() == [7.6])
    person.browser.click(*DEMO_MARKS_PX[1])
    wait_for(lambda: person.cursor_is_in("B, metres"))
    person.type("54.46 ft")
    wait_for(lambda: distances()[1:] == [pytest.approx(54.46 * 0.3048)])
    person.browser.click(*DEMO_MARKS_PX[2])
    wait_for(lambda: person.cursor_is_in("C, metres"))
    person.type("1e9")
    wait_for(lambda: person.browser.page.locator(".fcw-wrong").count() == 1)
    assert "'1e9' is not a distance along the road: expected 0.3 to 500 m" in person.words(".fcw-wrong")
    assert person.field("C, metres").input_value() == "1e9"
    wait_for(lambda: person.field("C, metres").get_attribute("aria-invalid") == "true")
    assert person.field("C, metres").get_attribute("aria-label") == "C, metres"
    person.field("C, metres").fill("31.6 m")
    wait_for(lambda: person.browser.page.locator(".fcw-wrong").count() == 0)
    wait_for(lambda: distances()[2] == 31.6)

    # Saved by its key while the cursor is in a field, with what was just typed in it.
    person.field("Camera height").click()
    person.type("4 ft 3 in")
    person.press("Control+s")
    wait_for(lambda: page.session.state.saved)
    assert page.session.state.document.height_m == pytest.approx(4.25 * 0.3048)
    wait_for(lambda: "Saved drive.calibration.yaml" in person.words(NOTIFICATION))

    def note_is_below_the_banner() -> bool:
        note, banner = (  # each is away for a moment while it is drawn anew
            person.browser.page.locator(selector).first.bounding_box()
            for selector in (NOTIFICATION, ".fcw-banner")
        )
        return note is not None and banner is not None and note["y"] > banner["y"] + banner["height"]

    wait_for(note_is_below_the_banner)
    person.put_away_notifications()

    # A deleted letter is used again.
    person.press("2", "Delete")
    wait_for(lambda: len(distances()) == 2)
    wait_for(lambda: person.field("B, metres").count() == 0)  # what is still drawn takes the click
    person.browser.wait_until_still()
    person.browser.click(*DEMO_MARKS_PX[1])
    wait_for(lambda: person.cursor_is_in("B, metres"))


def test_the_banner_leads_to_what_it_names_from_any_tab(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    marks = zip(DEMO_MARKS_PX, (7.6, 16.6, 25.0), strict=True)
    sky = AddMark(640.0, 90.0, 0, 60.0)
    page.session.apply(
        SOMEBODY, *(AddMark(*place, 0, distance_m) for place, distance_m in marks), sky, SetHeight(1.3)
    )
    assert page.session.state.solution.status is not Status.GOOD
    person = Person(open_page(page.url, window_px=(1000, 700)))
    person.browser.page.get_by_role("tab", name="Keys").click()
    person.browser.page.locator(".fcw-banner button", has_text="Show it").click()
    trouble = person.browser.page.locator("[data-fcw-place=trouble]").first

    def seen() -> bool:
        box = trouble.bounding_box() if trouble.count() else None
        return box is not None and box["y"] >= 0 and box["y"] + box["height"] <= 700

    wait_for(seen)


@pytest.mark.parametrize("window_px", WINDOWS_PX, ids=lambda size: f"{size[0]}x{size[1]}")
def test_on_every_window_the_picture_is_whole_and_the_panel_beside_or_below_it(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor, window_px: tuple[int, int]
):
    page = serve(copy_of_demo_drive(tmp_path))
    marks = zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True)
    page.session.apply(
        SOMEBODY, *(AddMark(*place, 0, distance_m) for place, distance_m in marks), SetHeight(1.3)
    )
    person = Person(open_page(page.url, window_px=window_px))
    width_px, height_px = window_px

    def seen() -> dict[str, Any]:
        return person.browser.page.evaluate(_PLACES)

    def fitted() -> bool:
        places = seen()
        left, top, right, bottom = places["canvas"]
        (x0, y0), (x1, y1) = (person.browser.screen_position(*corner) for corner in ((0, 0), (1279, 719)))
        inside = left <= x0 < x1 <= right and top <= y0 < y1 <= bottom
        # Not over the picture: beside it or below it.
        apart = all(
            places[part][0] >= right - 1 or places[part][1] >= bottom - 1 for part in ("tabs", "heading")
        )
        return apart and inside and (x1 - x0 > 0.85 * (right - left) or y1 - y0 > 0.85 * (bottom - top))

    wait_for(fitted)
    places = seen()
    canvas, banner = places["canvas"], places["banner"]
    assert places["beyond"] <= 0
    assert 0 <= banner[0] < banner[2] <= canvas[2]
    for part in (places["tabs"], places["heading"]):
        assert 0 <= part[0] < part[2] <= width_px
        assert 0 <= part[1] < part[3] <= height_px
    if height_px > width_px:
        assert canvas[3] <= 0.5 * height_px
        assert canvas[2] - canvas[0] == width_px


@pytest.mark.parametrize("way", [TAPE, RECTANGLE])
def test_a_page_with_what_was_done_before_opens_at_its_top(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor, way: str
):
    page = serve(copy_of_demo_drive(tmp_path))
    corners = ((500.0, 600.0), (780.0, 600.0), (700.0, 480.0), (580.0, 480.0))
    clicked = corners if way == RECTANGLE else ()
    page.session.apply(SOMEBODY, ChooseWay(way), SetHeight(1.3), *(AddCorner(*corner) for corner in clicked))
    # So low that of the panel only the tabs and its first lines are in sight.
    person = Person(open_page(page.url, window_px=(390, 300)))
    wait_for(lambda: person.browser.page.locator("[data-fcw='way:']").count() == 1)
    person.browser.wait_until_still()
    scrolled_px = person.browser.page.locator("[role=tab]").first.evaluate(
        "tab => tab.closest('.mantine-ScrollArea-viewport').scrollTop"
    )
    assert scrolled_px == 0


def test_on_a_phone_a_list_opens_within_the_window(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    page.session.apply(SOMEBODY, ChooseWay("clip"), SetHeight(1.3))
    person = Person(open_page(page.url, window_px=(390, 844), phone=True))
    person.field("Kind of camera").tap()
    person.browser.page.get_by_role("option", name="Phone, main camera").tap()
    wait_for(lambda: person.field("Kind of camera").input_value() == "Phone, main camera")
    assert person.browser.page.evaluate("innerWidth") == 390


def test_on_a_phone_a_tap_on_the_picture_adds_a_point_and_sliding_it_none(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(pictures_of_demo_drive(tmp_path))
    page.session.apply(SOMEBODY, ChooseWay(TAPE))
    person = Person(open_page(page.url, window_px=(390, 844), phone=True))
    (column_px, row_px), tapped_px = DEMO_MARKS_PX[:2]
    before = person.browser.screen_position(*tapped_px)
    person.browser.touch([(column_px, row_px), (column_px, row_px - 60), (column_px, row_px - 120)])
    person.browser.wait_until_still()
    assert person.browser.screen_position(*tapped_px)[1] < before[1] - 20
    person.browser.touch([tapped_px])
    wait_for(lambda: person.cursor_is_in("A, metres"))
    (mark,) = page.session.state.document.marks
    # A CSS pixel is this many of the picture's, whose whole width the phone has.
    assert (mark.column_px, mark.row_px) == pytest.approx(tapped_px, abs=1280 / 390)


def test_every_choice_of_dashes_is_read_whole(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    page.session.apply(SOMEBODY, ChooseWay(DASHES))
    person = Person(open_page(page.url, window_px=(1000, 700)))
    for preset in DASH_PRESETS:
        person.field("Distances").click()
        person.browser.page.get_by_role("option", name=preset.name, exact=True).click()
        wait_for(lambda name=preset.name: person.field("Distances").input_value() == name)
        cut_px = person.field("Distances").evaluate("input => input.scrollWidth - input.clientWidth")
        assert cut_px <= 0, preset.name
