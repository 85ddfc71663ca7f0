"""What else the calibration page offers: presets, several pictures, units, more knowledge, downloads."""

import math
from html import unescape
from pathlib import Path

import cv2
import numpy as np
import pytest
from calibrate_helpers import OpenPage, Person, Serve, WaitFor
from playwright.sync_api import Locator

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.export import camera_info_text, kalibr_text
from fcw.camera.file import calibration_text, default_path, write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation
from fcw.camera.vanishing import vanishing_row
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.document.state import Result
from fcw_viz.calibrate_app.handles import ROLL_GRIP_PART, YAW_GRIP_PART
from fcw_viz.calibrate_app.session import Person as SessionPerson

SIZE = ImageSize(1280, 720)
HEIGHT_M = 1.3
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, HEIGHT_M, 639.5)
LANE_HALF_M = 1.5
LINE_ENDS_M = (9.0, 40.0)
SOMEBODY = SessionPerson("somebody")
MOUSE_PX = 0.7
"""A mouse points at whole pixels of the screen, at most 1.3 pixels of the picture apart here."""
CIRCLE_SEGMENTS, CROSS_SEGMENTS = 40, 4
"""Of a handle; one that does not count has no cross-hair."""
TAPE_M = (5.0, 10.0, 20.0)


def seen(distance_m: float, lateral_m: float = 0.0) -> tuple[float, float]:
    """Column and row where the camera sees a point of the road."""
    return CAMERA.column_at(lateral_m, distance_m), CAMERA.row_at(distance_m)


def lane_line(side: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """The near and the far end of a lane line, that of the left (1) or the right (-1) side."""
    near, far = (seen(distance_m, side * LANE_HALF_M) for distance_m in LINE_ENDS_M)
    return near, far


def road(folder: Path, pictures: int = 1) -> Path:
    """Pictures of a straight road with two lane lines, seen by the camera."""
    source = folder / "road"
    source.mkdir()
    image = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    for side in (-1, 1):
        near, far = (tuple(round(16 * px) for px in end) for end in lane_line(side))
        cv2.line(image, near, far, (240, 240, 240), 3, cv2.LINE_AA, shift=4)
    for number in range(pictures):
        cv2.imwrite(str(source / f"{number}.png"), image)
    return source


def ground_points(document: Document) -> list[GroundPoint]:
    return [point for mark in document.marks if (point := mark.ground_point) is not None]


def choose(person: Person, label: str, option: str) -> None:
    person.field(label).click()
    person.browser.page.get_by_role("option", name=option, exact=True).click()


def side_tab(person: Person, name: str) -> None:
    person.browser.page.get_by_role("tab", name=name).click()


def checkbox(person: Person, name: str) -> Locator:
    return person.browser.page.get_by_role("checkbox", name=name)


def handle_segments(person: Person, name: str) -> int:
    """How many lines a handle on the picture is drawn with."""
    return person.browser.page.evaluate(
        """(name) => {
          let count = 0;
          window.__viserMutable.nodeRefFromName[name]?.traverse(node => {
            count = node.geometry?.attributes?.instanceStart?.count ?? count;
          });
          return count;
        }""",
        f"/handles/{name}/lines",
    )


def test_a_tape_measure_over_two_pictures_needs_no_typing(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(road(tmp_path, pictures=2))
    person = Person(open_page(page.url))

    def marks() -> list[tuple[float | None, int | None]]:
        return [(mark.distance_m, mark.frame) for mark in page.session.state.document.marks]

    person.button("Points at measured distances").click()
    wait_for(lambda: person.field("Distances").count() > 0)
    choose(person, "Distances", "Tape measure: 5, 10, 20 m")
    wait_for(lambda: page.session.state.document.planned_m == TAPE_M)
    for clicked, distance_m in enumerate(TAPE_M[:2], 1):
        person.browser.click(*seen(distance_m))
        wait_for(lambda clicked=clicked: len(marks()) == clicked)
    person.press("n")
    wait_for(lambda: person.words(".fcw-step").endswith("0.1 s"))
    person.browser.click(*seen(TAPE_M[2]))
    wait_for(lambda: marks() == [(5.0, 0), (10.0, 0), (20.0, 1)])
    for mark, distance_m in zip(page.session.state.document.marks, TAPE_M, strict=True):
        assert (mark.column_px, mark.row_px) == pytest.approx(seen(distance_m), abs=MOUSE_PX)

    choose(person, "Units", "feet")
    wait_for(lambda: person.field("A, feet").count() > 0)
    person.field("A, feet").fill("16.5")
    person.field("Camera height, ft").fill("4.25")
    wait_for(lambda: page.session.state.document.height_m == pytest.approx(4.25 * 0.3048))
    wait_for(lambda: marks()[0][0] == pytest.approx(16.5 * 0.3048))
    wait_for(
        lambda: (
            [person.field(f"{name}, feet").input_value() for name in "ABC"] == ["16.5", "32.808", "65.617"]
        )
    )
    wait_for(lambda: person.banner.count(" ft") > 0)

    person.browser.page.locator(".fcw tr[data-key]").nth(1).click()
    wait_for(lambda: person.browser.page.locator(".fcw tr.selected td").all_inner_texts()[:1] == ["B"])
    assert handle_segments(person, "mark_2") == CIRCLE_SEGMENTS + CROSS_SEGMENTS
    person.press("o")
    wait_for(lambda: not page.session.state.document.marks[1].enabled)
    wait_for(lambda: handle_segments(person, "mark_2") == CIRCLE_SEGMENTS)
    side_tab(person, "From above")
    on_the_ground = person.browser.page.locator(".fcw-above image")
    wait_for(lambda: on_the_ground.count() == 1)
    above = person.browser.page.locator(".fcw-above circle[data-mark='2']")
    wait_for(lambda: above.count() == 0)  # two points alone give no current result
    person.press("o")
    wait_for(lambda: handle_segments(person, "mark_2") == CIRCLE_SEGMENTS + CROSS_SEGMENTS)
    wait_for(lambda: above.count() == 1)


def test_lane_lines_and_a_dragged_horizon_are_mathematics(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(road(tmp_path))
    # Rows as somebody clicks them, half a pixel or a whole one beside.
    errors_px = (0.5, -1.0, 0.5)
    edits = [
        AddMark(seen(d)[0], seen(d)[1] + error_px, 0, d)
        for d, error_px in zip(TAPE_M, errors_px, strict=True)
    ]
    page.session.apply(SOMEBODY, *edits, SetHeight(HEIGHT_M))
    points = ground_points(page.session.state.document)

    def result() -> Result:
        solved = page.session.state.solution.result
        assert solved is not None
        return solved

    def expect(horizon_row: Gaussian | None, within_px: float = 1e-6) -> None:
        expected = calibrate(points, SIZE, HEIGHT_M, horizon_row=horizon_row)
        wait_for(
            lambda: (
                result().calibration.horizon_row_px == pytest.approx(expected.horizon_row_px, abs=within_px)
            )
        )
        assert result().calibration.row_at(40.0) == pytest.approx(expected.row_at(40.0), abs=within_px)
        wait_for(lambda: result().quality in person.banner)

    def expect_lane_lines(meeting: Gaussian) -> None:
        """They also tell which way the camera looks, so that everything is fitted: all but the same here."""
        expect(meeting, within_px=0.1)
        turned = result().calibration.orientation
        assert turned.yaw_sigma_rad < math.radians(0.2)
        assert abs(turned.yaw_rad) < turned.yaw_sigma_rad

    person = Person(open_page(page.url))
    expect(None)
    checkbox(person, "More inputs").click()
    person.button("Draw lane lines").click()
    for side, name in ((1, "left"), (-1, "right")):
        for place, end in zip(lane_line(side), ("bottom", "far away"), strict=True):
            wait_for(lambda name=name, end=end: name in person.banner and end in person.banner)
            person.browser.click(*place)
    wait_for(lambda: page.session.state.solution.lane_horizon is not None)
    first, second = page.session.state.document.lane_lines
    meeting = page.session.state.solution.lane_horizon
    assert first is not None
    assert second is not None
    assert meeting is not None
    assert abs(meeting.value - CAMERA.horizon_row_px) < meeting.sigma
    drawn = vanishing_row((first.start_px, first.end_px), (second.start_px, second.end_px), 1.0)
    assert (meeting.value, meeting.sigma) == pytest.approx((drawn.value, drawn.sigma))
    expect_lane_lines(meeting)
    checkbox(person, "Use lane lines").click()
    expect(None)
    checkbox(person, "Use lane lines").click()
    expect_lane_lines(meeting)
    person.button("Remove lines").click()
    wait_for(lambda: page.session.state.document.lane_lines == (None, None))
    expect(None)
    assert len(page.session.state.document.marks) == len(TAPE_M)  # no click of the tool became a point

    def dragged() -> float | None:
        horizon = page.session.state.document.horizon
        return None if horizon is None else horizon.prior.value

    person.button("Drag the horizon").click()
    grip_row_px = result().calibration.horizon_row_px
    wait_for(lambda: handle_segments(person, "horizon") > 0)
    person.browser.wait_until_still()  # a slow browser puts it in its place a frame later
    grip = ((SIZE.width - 1) / 2, grip_row_px)
    mouse = person.browser.page.mouse
    mouse.move(*person.browser.mouse_position(*grip))
    mouse.down()
    mouse.move(*person.browser.mouse_position(grip[0], grip_row_px - 20), steps=4)
    wait_for(lambda: dragged() == pytest.approx(grip_row_px - 20, abs=MOUSE_PX))
    mouse.up()
    person.browser.wait_until_still()  # the drag's end is told after its last move
    wait_for(lambda: person.field("Horizon, row").input_value() not in ("", f"{grip_row_px:.5g}"))
    person.press("Escape")
    person.field("Horizon, row").fill("308.5")
    wait_for(lambda: dragged() == 308.5)
    expect(Gaussian(308.5, 2.0))
    checkbox(person, "Use it").click()
    expect(None)
    assert dragged() == 308.5


def test_the_end_of_the_horizon_tilts_the_camera_and_the_path_turns_it(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(road(tmp_path))
    page.session.apply(SOMEBODY, *(AddMark(*seen(d), 0, d) for d in TAPE_M), SetHeight(HEIGHT_M))
    person = Person(open_page(page.url))
    checkbox(person, "More inputs").click()
    person.button("Drag the horizon").click()
    middle_px, aside_px = (SIZE.width - 1) / 2, ROLL_GRIP_PART * (SIZE.width - 1)
    path_row_px = CAMERA.horizon_row_px + YAW_GRIP_PART * (SIZE.height - 1 - CAMERA.horizon_row_px)

    def drag(name: str, grip: tuple[float, float], right_px: float, down_px: float) -> None:
        wait_for(lambda: handle_segments(person, name) > 0)
        person.browser.wait_until_still()
        mouse = person.browser.page.mouse
        mouse.move(*person.browser.mouse_position(*grip))
        mouse.down()
        mouse.move(*person.browser.mouse_position(grip[0] + right_px, grip[1] + down_px), steps=4)
        mouse.up()
        person.browser.wait_until_still()

    def orientation() -> Orientation:
        shown = page.session.state.shown
        assert shown is not None
        return shown.calibration.orientation

    # Up at its right end: the picture's horizon falls to the left, the camera is tilted to the right.
    drag("roll", (aside_px, CAMERA.horizon_row_px), 0.0, -12.0)
    roll_rad = math.atan2(12.0, aside_px - middle_px)
    wait_for(lambda: page.session.state.document.roll is not None)
    belief = page.session.state.document.roll
    assert belief is not None
    assert belief.prior.value == pytest.approx(roll_rad, abs=MOUSE_PX / (aside_px - middle_px))
    dragged_rad = belief.prior.value
    wait_for(lambda: orientation().roll_rad == pytest.approx(dragged_rad, abs=math.radians(0.1)))
    person.press("Control+z")
    wait_for(lambda: page.session.state.document.roll is None)

    # The road leads to the right of where the camera looks: it looks to the left.
    drag("yaw", (middle_px, path_row_px), 40.0, 0.0)
    wait_for(lambda: page.session.state.document.yaw is not None)
    belief = page.session.state.document.yaw
    assert belief is not None
    expected_rad = math.atan(40.0 / CAMERA.focal_y_px)
    assert belief.prior.value == pytest.approx(expected_rad, abs=2 * MOUSE_PX / CAMERA.focal_y_px)
    turned_rad = belief.prior.value
    wait_for(lambda: orientation().yaw_rad == pytest.approx(turned_rad, abs=math.radians(0.1)))
    assert page.session.state.document.roll is None
    assert page.session.state.document.horizon is None


def test_an_old_calibration_is_shown_again_and_handed_out(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = road(tmp_path)
    old_points = [GroundPoint(distance_m, seen(distance_m)[1], 600.0) for distance_m in TAPE_M]
    old = calibrate(old_points, SIZE, HEIGHT_M)
    write_calibration(old, default_path(source))
    page = serve(source)
    person = Person(open_page(page.url))
    wait_for(lambda: person.button("Saved").count() == 1)
    assert "The points of road.calibration.yaml were loaded" in person.words(".fcw:has-text('loaded')")
    expected_rows = [[name, f"{p.row_px:.1f}", "600.0"] for name, p in zip("ABC", old_points, strict=True)]
    assert [row[:3] for row in person.table] == expected_rows
    fields = [person.field(f"{name}, metres").input_value() for name in "ABC"]
    assert fields == [f"{point.distance_m:g}" for point in old_points]
    assert person.field("Camera height").input_value() == f"{HEIGHT_M:g}"

    def download(words: str) -> tuple[str, str]:
        with person.browser.page.expect_download() as handed:
            person.button(words).click()
        return handed.value.suggested_filename, Path(handed.value.path()).read_text(encoding="utf-8")

    assert download("YAML") == ("road.calibration.yaml", calibration_text(old))
    assert download("camera_info") == ("road.camera_info.yaml", camera_info_text(old))
    assert download("Kalibr") == ("road.kalibr.yaml", kalibr_text(old))
    name, report = download("Report")
    assert name == "road.calibration.html"
    assert report.startswith("<!doctype html>")
    assert report.endswith("</body></html>\n")
    assert "data:image/jpeg;base64," in report
    assert calibration_text(old) in unescape(report)

    def colour() -> list[int]:
        """Of the words, red, green and blue."""
        return person.browser.page.evaluate(
            "getComputedStyle(document.querySelector('.fcw')).color.match(/\\d+/g).slice(0, 3).map(Number)"
        )

    assert max(colour()) < 128
    side_tab(person, "Keys")
    checkbox(person, "Dark mode").click()
    wait_for(lambda: min(colour()) > 128)
    checkbox(person, "Dark mode").click()
    wait_for(lambda: max(colour()) < 128)


def test_a_straight_edge_that_the_lens_bends_is_told_and_mended(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(road(tmp_path))
    tape = [AddMark(*seen(d), 0, d) for d in TAPE_M]
    page.session.apply(SOMEBODY, *tape, SetHeight(HEIGHT_M))
    person = Person(open_page(page.url))
    checkbox(person, "More inputs").click()
    person.button("Click along a straight edge").click()
    wait_for(lambda: "along something straight" in person.banner)
    # A pole behind a wide lens: it bows outwards, most in the middle.
    rows_px = np.linspace(20.0, SIZE.height - 20.0, 7)
    pole = [(60.0 + 30.0 * ((row_px - 359.5) / 359.5) ** 2, row_px) for row_px in rows_px]

    def clicked() -> int:
        return sum(map(len, page.session.state.document.edges))

    for number, place in enumerate(pole, 1):
        person.browser.wait_until_still()
        person.browser.click(*place)
        wait_for(lambda number=number: clicked() == number)
    person.press("Escape")
    wait_for(lambda: person.browser.page.locator("[data-fcw-place=trouble]").count() == 1)
    assert "The lens bends this picture" in person.words("[data-fcw-place=trouble]")
    person.button("Fit the lens's distortion").click()
    wait_for(lambda: page.session.state.document.bent)
    solved = page.session.state.solution.result
    assert solved is not None
    assert solved.calibration.lens is not None
    assert solved.calibration.lens.coefficients[0] < -0.1
    wait_for(lambda: person.button("Remove the lens").count() == 1)
