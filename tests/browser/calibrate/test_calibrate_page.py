"""Somebody who has never seen it calibrates their camera on the page."""

from pathlib import Path
from urllib.request import urlopen

import pytest
import yaml
from browser_page import NOTIFICATION
from calibrate_helpers import (
    DEMO_MARKS_PX,
    FIRST_PORT,
    OpenPage,
    Person,
    Serve,
    WaitFor,
    copy_of_demo_drive,
    pictures_of_demo_drive,
)

from fcw.camera.file import default_path
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.document.state import Status
from fcw_viz.calibrate_app.session import Person as SessionPerson
from fcw_viz.cli import main

SOMEBODY = SessionPerson("somebody")
PAPER_POINTS = ((461.0, 4.0), (428.0, 5.0), (383.0, 7.0))


def numbers_of(file: Path) -> dict[str, object]:
    """Every number of a calibration file by its place in it."""

    def walk(value: object, place: str) -> dict[str, object]:
        if isinstance(value, dict):
            return {k: v for key, item in value.items() for k, v in walk(item, f"{place}.{key}").items()}
        if isinstance(value, list):
            return {k: v for i, item in enumerate(value) for k, v in walk(item, f"{place}.{i}").items()}
        return {place: value}

    return walk(yaml.safe_load(file.read_text()), "")


def test_a_newcomer_calibrates_in_three_clicks_three_numbers_one_height_and_one_save(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = pictures_of_demo_drive(tmp_path)
    page = serve(source)
    person = Person(open_page(page.url, drawn_at=0.25))
    assert "Choose what you have" in person.banner
    assert person.button("Save drive.calibration.yaml").is_disabled()
    for name, place, distance in zip("ABC", DEMO_MARKS_PX, ("7.6", "16,6", "31.6"), strict=True):
        person.browser.click(*place)
        wait_for(lambda name=name: person.field(f"{name}, metres").count() > 0)
        wait_for(lambda name=name: person.cursor_is_in(f"{name}, metres"))
        person.type(distance)
    wait_for(lambda: "camera's height" in person.banner)
    person.field("Camera height").fill("1.3")
    save = person.button("Save drive.calibration.yaml")
    wait_for(save.is_enabled)
    assert "A reading of 40 m means" in person.banner
    save.click()
    wait_for(lambda: "fcw run" in person.words("text=Next, type"))

    saved = default_path(source)
    marks = page.session.state.document.marks
    assert [mark.distance_m for mark in marks] == [7.6, 16.6, 31.6]
    for mark, (column_px, row_px) in zip(marks, DEMO_MARKS_PX, strict=True):
        assert (mark.column_px, mark.row_px) == pytest.approx((column_px, row_px), abs=0.8)
    page.stop()
    headless = tmp_path / "headless.yaml"
    points = [f"{mark.distance_m!r}:{mark.row_px!r}:{mark.column_px!r}" for mark in marks]
    arguments = ["--image-size", "1280x720", "--height", "1.3", "--save", str(headless)]
    assert main(["calibrate", "--points", *points, *arguments]) == 0
    clicked, typed = numbers_of(saved), numbers_of(headless)
    assert clicked.keys() == typed.keys()
    for place, value in clicked.items():
        assert value == (pytest.approx(typed[place], rel=0, abs=1e-9) if value is not None else None), place
    assert main(["run", str(source), "--out", str(tmp_path / "out")]) == 0


def test_a_drag_moves_rows_and_table_and_one_undo_takes_it_back(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    marks = zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True)
    edits = [AddMark(*place, 0, distance_m) for place, distance_m in marks]
    page.session.apply(SOMEBODY, *edits, SetHeight(1.3))
    before = page.session.state
    person = Person(open_page(page.url))
    wait_for(lambda: len(person.table) == 3)
    rows_before = overlay_rows(person)
    mouse = person.browser.page.mouse
    mouse.move(*person.browser.mouse_position(640, 409))
    mouse.down()
    mouse.move(*person.browser.mouse_position(640, 420), steps=4)
    wait_for(lambda: abs(float(person.table[1][1]) - 420) < 1)
    wait_for(lambda: overlay_rows(person) != rows_before)
    assert page.session.state.document != before.document
    mouse.up()
    wait_for(lambda: page.session.state.can_undo)
    person.press("Control+z")
    wait_for(lambda: page.session.state.document == before.document)
    wait_for(lambda: overlay_rows(person) == rows_before)
    person.press("Control+y")
    wait_for(lambda: abs(page.session.state.document.marks[1].row_px - 420) < 1)


def overlay_rows(person: Person) -> str:
    """What the lines over the picture are made of, as the browser draws them."""
    return person.browser.page.evaluate(
        """() => {
          const nodes = window.__viserMutable.nodeRefFromName, seen = [];
          for (const name of Object.keys(nodes).filter(name => name.startsWith('/overlay/lines')).sort())
            nodes[name]?.traverse(node => {
              const points = node.geometry?.attributes?.instanceStart?.data?.array;
              if (points) seen.push([...points].map(x => x.toFixed(4)).join());
            });
          return seen.join(';');
        }"""
    )


def test_the_papers_points_become_plausible_with_the_proposed_mend(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    edits = [AddMark(640.0, row_px, 0, distance_m) for row_px, distance_m in PAPER_POINTS]
    page.session.apply(SOMEBODY, *edits, SetHeight(1.225))
    person = Person(open_page(page.url))
    wait_for(lambda: person.button("Distances were measured from the bumper").count() == 1)
    assert page.session.state.solution.status is Status.DOUBTFUL
    assert person.button("Save drive.calibration.yaml").is_enabled()
    person.button("Distances were measured from the bumper").click()
    wait_for(lambda: page.session.state.solution.status is Status.GOOD)
    assert page.session.state.document.bumper_offset_m == pytest.approx(2.29, abs=0.005)
    wait_for(lambda: person.field("Bumper ahead").input_value() == "2.29")
    assert person.button("Distances were measured from the bumper").count() == 0
    person.press("Control+z")
    wait_for(lambda: page.session.state.solution.status is Status.DOUBTFUL)


def test_a_degenerate_state_keeps_the_last_good_result_marked_and_cannot_be_saved(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = copy_of_demo_drive(tmp_path)
    page = serve(source)
    marks = zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True)
    edits = [AddMark(*place, 0, distance_m) for place, distance_m in marks]
    page.session.apply(SOMEBODY, *edits, SetHeight(1.3))
    person = Person(open_page(page.url))
    wait_for(lambda: person.button("Save drive.calibration.yaml").is_enabled())
    person.field("B, metres").fill("31.6")
    wait_for(lambda: page.session.state.solution.status is Status.DEGENERATE)
    wait_for(lambda: person.button("Save drive.calibration.yaml").is_disabled())
    assert "Out of date" in person.words(".fcw-card.stale")
    assert "Cannot be saved" in person.words("text=Cannot be saved")
    assert [row[0] for row in person.table] == ["A", "⚠ B", "⚠ C"]
    person.press("Escape", "Control+s")
    wait_for(lambda: person.browser.page.locator(NOTIFICATION).count() > 0)
    assert "not saved" in person.words(NOTIFICATION)
    assert not default_path(source).exists()


def test_keys(tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor):
    page = serve(copy_of_demo_drive(tmp_path))
    edits = [AddMark(*place, 0, 5.0 + 3 * i) for i, place in enumerate(DEMO_MARKS_PX)]
    page.session.apply(SOMEBODY, *edits)
    person = Person(open_page(page.url))
    wait_for(lambda: len(person.table) == 3)

    def marks() -> list[tuple[float, float, bool]]:
        return [(m.column_px, m.row_px, m.enabled) for m in page.session.state.document.marks]

    def reach(key: str, expected: list[tuple[float, float, bool]]) -> None:
        person.press(key)
        wait_for(lambda: marks() == [pytest.approx(mark) for mark in expected])

    first, _, third = marks()
    person.press("2")
    reach("ArrowUp", [first, (640.0, 408.9, True), third])
    reach("Shift+ArrowRight", [first, (641.0, 408.9, True), third])
    reach("Control+z", [first, (640.0, 408.9, True), third])
    reach("o", [first, (640.0, 408.9, False), third])
    reach("Delete", [first, third])
    reach("Control+z", [first, (640.0, 408.9, False), third])
    reach("Control+Shift+z", [first, third])

    person.press("n", ".")
    wait_for(lambda: person.words(".fcw-step").endswith("0.1 s"))
    person.press("1")
    wait_for(lambda: person.browser.page.locator(".fcw tr.selected").count() == 1)
    person.button("Go to picture").click()
    wait_for(lambda: person.words(".fcw-step").endswith("0.0 s"))
    camera = person.browser.camera()
    person.press("=")
    wait_for(lambda: person.browser.camera() != camera)
    person.press("f")
    wait_for(lambda: person.browser.camera() == pytest.approx(camera, abs=1e-3))

    # Typed in a field, none of them is a command, and what is typed before the cursor is there waits for it.
    person.press("1")
    wait_for(lambda: person.browser.page.locator(".fcw tr.selected").count() == 1)
    person.press("d", "2")
    wait_for(lambda: person.cursor_is_in("A, metres"))
    person.type("on.5p1")
    person.press("Delete", "ArrowUp")
    # A slow page may refuse a part of it first.
    refused = "'2on.5p1' is not a distance along the road: type 15, 4.5 m or 50 ft"
    wait_for(
        lambda: any(refused in text for text in person.browser.page.locator(".fcw-wrong").all_inner_texts())
    )
    wait_for(lambda: person.field("A, metres").get_attribute("aria-invalid") == "true")
    assert person.field("A, metres").input_value() == "2on.5p1"
    assert marks() == [first, third]
    assert person.browser.camera() == pytest.approx(camera, abs=1e-3)
    person.press("Escape", "Escape")
    wait_for(lambda: person.browser.page.locator(".fcw tr.selected").count() == 0)


def test_a_taken_port_is_left_alone(tmp_path: Path, serve: Serve):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    first = serve(copy_of_demo_drive(tmp_path / "one"))
    second = serve(copy_of_demo_drive(tmp_path / "two"))
    # Other programs take ports and let them go: which is free for the second says nothing.
    assert min(first.port, second.port) >= FIRST_PORT
    assert first.port != second.port
    for page in (first, second):
        assert page.url.startswith(f"http://127.0.0.1:{page.port}/")
        with urlopen(page.url) as answer:
            assert answer.status == 200
