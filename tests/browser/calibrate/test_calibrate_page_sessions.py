"""Several tabs at once, and a server that is killed: nothing is lost, nothing is mixed up."""

import os
import random
import signal
import subprocess
from pathlib import Path

from browser_page import PATIENCE_S
from calibrate_helpers import (
    DEMO_MARKS_PX,
    FIRST_PORT,
    OpenPage,
    Person,
    Serve,
    WaitFor,
    copy_of_demo_drive,
)
from running.programs import serve_page

from fcw.camera.file import default_path
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.document.resume import begin
from fcw_viz.calibrate_app.session import Person as Somebody

ACTIONS = 50
SEED = 20_261_120
ELSEWHERE = Somebody("tab 9")


def test_fifty_clicks_drags_and_undos_from_two_tabs_are_what_the_journal_replays(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    source = copy_of_demo_drive(tmp_path)
    page = serve(source)
    people = [Person(open_page(page.url)) for _ in range(2)]
    wait_for(
        lambda: all("2 tabs are open: tab 1" in person.words(".fcw:has-text('tabs')") for person in people)
    )
    chance = random.Random(SEED)

    def place() -> tuple[float, float]:
        """On the road; the sky's left half is under a panel."""
        return chance.uniform(520, 1200), chance.uniform(330, 700)

    for number in range(ACTIONS):
        person = people[number % 2]
        marks = page.session.state.document.marks
        match chance.choice(("click", "click", "drag", "drag", "undo", "redo", "delete")):
            case "drag" if marks:
                mark = chance.choice(marks)
                person.browser.drag((mark.column_px, mark.row_px), place(), steps=3)
            case "undo":
                person.press("Escape", "Control+z")
            case "redo":
                person.press("Escape", "Control+y")
            case "delete":
                person.press("Escape", "Delete")
            case _:
                person.browser.click(*place())
                person.type(f"{chance.uniform(4, 40):.1f}")
    settled = [page.session.state]

    def is_settled() -> bool:
        people[0].browser.page.wait_for_timeout(1500)
        settled.append(page.session.state)
        return settled[-1].revision == settled[-2].revision

    def both_show_all_points() -> bool:
        first, second = ([row[:4] for row in person.table] for person in people)
        names = [row[0].removeprefix("⚠ ") for row in first]
        return first == second and names == [mark.name for mark in page.session.state.document.marks]

    wait_for(is_settled)
    wait_for(both_show_all_points)
    assert page.session.state.can_undo
    people[1].browser.page.close()
    wait_for(lambda: page.session.state.people == ("tab 1",))
    page.stop()
    final = page.session.state.document
    replayed = begin(source, page.pictures.image_size, default_path(source))
    assert replayed.history.document == final
    replayed.journal.close()


def test_a_button_that_is_drawn_anew_while_it_is_pressed_is_pressed(
    tmp_path: Path, serve: Serve, open_page: OpenPage, wait_for: WaitFor
):
    page = serve(copy_of_demo_drive(tmp_path))
    session = page.session
    for (column_px, row_px), distance_m in zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True):
        session.apply(ELSEWHERE, AddMark(column_px, row_px, distance_m=distance_m))
    session.apply(ELSEWHERE, SetHeight(1.3, 0.05))
    person = Person(open_page(page.url))
    wait_for(lambda: "A reading of 40 m means" in person.banner)
    before = person.banner
    mouse = person.browser.page.mouse
    person.browser.page.locator(".fcw-banner button").hover()
    mouse.down()
    session.apply(ELSEWHERE, AddMark(640.0, 362.2, distance_m=41.6))
    wait_for(lambda: person.banner != before)
    assert not session.state.saved
    mouse.up()
    wait_for(lambda: "Saved" in person.banner)


def start(source: Path, *options: str) -> tuple["subprocess.Popen[str]", str]:
    """The program by itself; its process and the page's address."""
    return serve_page("calibrate", source, "--no-open", "--port", FIRST_PORT + 50, *options)


def test_a_killed_server_comes_back_with_every_point(tmp_path: Path, open_page: OpenPage, wait_for: WaitFor):
    source = copy_of_demo_drive(tmp_path)
    process, url = start(source, "--height", "1.3", "--reference-offset", "1.6")
    person = Person(open_page(url))
    for count, (place, distance) in enumerate(zip(DEMO_MARKS_PX, ("6", "15", "30"), strict=True)):
        person.browser.click(*place)
        label = f"{'ABC'[count]}, metres"
        wait_for(lambda label=label: person.field(label).count() > 0 and person.cursor_is_in(label))
        person.type(distance)
    wait_for(lambda: "A reading of 40 m means" in person.banner)
    before = person.table
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()

    process, url = start(source)
    person = Person(open_page(url))
    wait_for(lambda: person.table == before)
    assert person.field("Camera height").input_value() == "1.3"
    assert person.field("Bumper ahead").input_value() == "1.6"
    assert "Your earlier work was restored" in person.words(".fcw:has-text('Your earlier work')")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "not saved; your points are kept" in out
    assert err == "fcw: interrupted\n"
