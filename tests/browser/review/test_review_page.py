"""The review page in a real Chromium: somebody finds a moment, looks at it and judges it."""

import os
import shutil
import signal
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from browser_page import PATIENCE_S
from calibrate_helpers import FIRST_PORT
from review_drives import (
    ADVISORY_S,
    BOX,
    CAUTION_S,
    FRAMES,
    MOVED_S,
    NEAR_MISS_S,
    QUIET_S,
    RATE_HZ,
    WARNING_END_S,
    write_drive,
)
from review_helpers import OpenPage, Review, Reviewer, WaitFor, node_is_there, row_of, said_of
from running.programs import serve_page

from fcw.annotation.records import Judgement, LabelledBox, Note, Reason, VehicleKind
from fcw.box import Box

WORST_ROW = row_of(CAUTION_S)
"""Where the made drive's warning needs most braking, which is all the same while it lasts."""


def test_the_worst_moment_of_five_drives_is_two_clicks_away(
    tmp_path: Path, drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    drives = {
        "empty": tmp_path / "empty.mcap",
        "quiet": write_drive(tmp_path / "quiet" / "drive.mcap", QUIET_S),
        "torn": write_drive(tmp_path / "torn" / "drive.mcap", QUIET_S, finished=False),
        "made": drive_log,
        "quiet too": Path(shutil.copytree(tmp_path / "quiet", tmp_path / "too")) / "drive.mcap",
    }
    drives["empty"].write_bytes(b"no log")
    person = Reviewer(open_page(review(drives).url, picture=False))
    wait_for(lambda: person.browser.page.locator(".fcw-row").count() == 5)
    wait_for(lambda: "reading" not in person.words(".fcw-folder > p"))
    assert person.words(".fcw-row").startswith("made")
    assert "Warning at 9.0 s" in person.words(".fcw-row .fcw-worst")
    last = person.browser.page.locator(".fcw-row").last.inner_text()
    assert last.startswith("?")
    assert "not a drive log" in last
    person.at(".fcw-row").click()
    wait_for(lambda: person.sees(WORST_ROW))
    wait_for(lambda: "Warning" in person.words(".fcw-title"))
    person.press("l")
    wait_for(lambda: person.browser.page.locator(".fcw-row").count() == 5)
    person.at('.fcw-row .fcw-mark[data-event="1"]').click()
    wait_for(lambda: person.sees(row_of(NEAR_MISS_S)))


def test_keys(drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor):
    person = Reviewer(open_page(review({"made": drive_log}).url, drawn_at=0.25))
    wait_for(lambda: person.sees(WORST_ROW))
    for key, row in (
        ("ArrowRight", WORST_ROW + 1),
        (".", WORST_ROW + 2),
        ("ArrowLeft", WORST_ROW + 1),
        ("Shift+ArrowRight", WORST_ROW + 1 + RATE_HZ),
        ("End", FRAMES - 1),
        ("Home", 0),
        ("n", WORST_ROW),
        ("n", row_of(NEAR_MISS_S)),
        ("n", row_of(ADVISORY_S)),
        ("n", row_of(MOVED_S)),
        ("p", row_of(ADVISORY_S)),
        ("ArrowUp", row_of(NEAR_MISS_S)),
    ):
        person.press(key)
        wait_for(lambda row=row: person.sees(row))
    person.press("w")
    wait_for(lambda: person.words(".fcw-bar .fcw-choice:last-child .on") == "2 min")
    person.press("]")
    wait_for(lambda: person.words(".fcw-bar .fcw-choice .on") == "2×")
    person.press("o")
    person.press("Space")
    wait_for(lambda: person.row > row_of(NEAR_MISS_S) + 10)
    person.press("Escape")
    wait_for(lambda: person.words(".fcw-bar .play") == "Play" and person.picture == person.row)


def test_event_list_and_plots_lead_to_their_moments(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url))
    wait_for(lambda: person.sees(WORST_ROW))
    listed = person.browser.page.locator(".fcw-event b").all_inner_texts()
    assert listed == ["Warning", "Near miss", "Advisory", "Mount moved"]
    person.at('.fcw-event[data-event="1"]').click()
    wait_for(lambda: person.sees(row_of(NEAR_MISS_S)))
    wait_for(lambda: "Near miss" in person.words(".fcw-title"))
    wait_for(lambda: "TTC" in person.words(".fcw-event.selected"))

    x, y = person.place_on("#fcw-plots", 0.5)
    person.browser.page.mouse.click(x, y)
    # The plots reach from the first frame to the last.
    middle, later, early = (round(part * (FRAMES - 1)) for part in (0.5, 0.75, 0.25))
    wait_for(lambda: abs(person.row - middle) <= 1 and person.sees(person.row))
    wait_for(lambda: person.cursor_x("plots") == pytest.approx(x, abs=2))
    mouse = person.browser.page.mouse
    mouse.down()
    mouse.move(*person.place_on("#fcw-plots", 0.75), steps=4)
    wait_for(lambda: abs(person.row - later) <= 1 and person.sees(person.row))
    mouse.up()
    mouse.click(*person.place_on("#fcw-whole", 0.25))
    wait_for(lambda: abs(person.row - early) <= 1 and person.sees(person.row))
    at_x, _ = person.place_on("#fcw-whole", 0.25)
    wait_for(lambda: person.cursor_x("whole") == pytest.approx(at_x, abs=2))
    wait_for(lambda: person.words('[data-figure="distance"] b') == "40.0 m")
    person.at('.fcw-choice button:has-text("by time")').click()
    wait_for(lambda: person.words(".fcw-list-head .on") == "by time")


def test_a_verdict_is_kept_and_seen_in_another_tab_that_looks_elsewhere(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    url = review({"made": drive_log}).url
    one, two = Reviewer(open_page(url)), Reviewer(open_page(f"{url}?at=made@15.4"))
    wait_for(lambda: one.sees(WORST_ROW) and two.sees(row_of(15.4)))
    one.press("4")
    wait_for(lambda: two.words('.fcw-event[data-event="0"] em') == "✗")
    one.at("select[data-fcw-choice=reason]").select_option("OTHER_LANE")
    wait_for(lambda: [entry.said.reason for entry in said_of(drive_log).verdicts] == [Reason.OTHER_LANE])
    (entry,) = said_of(drive_log).verdicts
    assert (entry.person, entry.said.judgement) == ("anna", Judgement.FALSE)
    assert entry.said.event.start_s == CAUTION_S
    two.press("1")
    wait_for(lambda: len(said_of(drive_log).verdicts) == 2)
    assert one.sees(WORST_ROW)
    assert two.sees(row_of(15.4))
    two.press("Control+z")
    wait_for(lambda: len(said_of(drive_log).verdicts) == 1)
    two.press("m")
    wait_for(lambda: [entry.said.start_s for entry in said_of(drive_log).missed] == [pytest.approx(14.4)])
    one.tab("Notes")
    wait_for(lambda: "14.4 s to 16.4 s" in one.words(".fcw-remark"))


def test_a_corner_goes_where_the_mouse_takes_it(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url))
    wait_for(lambda: person.sees(WORST_ROW))
    person.press("e")
    wait_for(lambda: node_is_there(person, "/lines/boxes/lines_8"))
    person.browser.click(BOX.x + 20, BOX.y + 20)
    wait_for(lambda: node_is_there(person, "/handles/corner bottom right"))
    person.browser.wait_until_still()
    end = person.browser.mouse_position(BOX.right + 37, BOX.bottom + 21)
    person.browser.drag((BOX.right, BOX.bottom), (BOX.right + 37, BOX.bottom + 21))
    wait_for(lambda: bool(said_of(drive_log).frames))
    (label,) = said_of(drive_log).frames[WORST_ROW].labels.values()
    assert label is not None
    assert (label.box.x, label.box.y, label.track_id) == (BOX.x, BOX.y, 7)
    # The mouse points at the middle of a CSS pixel.
    left, top = person.browser.screen_position(label.box.right, label.box.bottom)
    assert (left, top) == (pytest.approx(end[0] + 0.5, abs=0.5), pytest.approx(end[1] + 0.5, abs=0.5))

    person.browser.page.keyboard.down("Shift")
    person.browser.drag((400, 60), (460, 110))
    person.browser.page.keyboard.up("Shift")
    wait_for(lambda: len(said_of(drive_log).frames[WORST_ROW].labels) == 2)
    person.press("c")
    wait_for(lambda: len(said_of(drive_log).frames[WORST_ROW].confirmed) == 1)
    person.press("Delete")
    wait_for(lambda: None in said_of(drive_log).frames[WORST_ROW].labels.values())


def label_of(log: Path, row: int, box_id: str = "track 7") -> LabelledBox | None:
    frame = said_of(log).frames.get(row)
    return frame.labels.get(box_id) if frame else None


def test_a_box_is_moved_described_copied_on_and_interpolated(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url))
    wait_for(lambda: person.sees(WORST_ROW))
    person.press("e")
    wait_for(lambda: node_is_there(person, "/lines/boxes/lines_8"))
    wait_for(lambda: open_tab(person) == "Boxes")
    person.press("v", "v")  # from left to right
    wait_for(lambda: node_is_there(person, "/handles/edge left"))
    person.browser.wait_until_still()
    camera = person.browser.camera()
    middle = BOX.x + BOX.w * 0.3, BOX.y + BOX.h * 0.3
    start = person.browser.mouse_position(*middle)
    end = person.browser.mouse_position(middle[0] + 30, middle[1] - 12)
    scale = person.browser.screen_position(1, 0)[0] - person.browser.screen_position(0, 0)[0]
    person.browser.drag(middle, (middle[0] + 30, middle[1] - 12))
    wait_for(lambda: label_of(drive_log, WORST_ROW) is not None)
    label = label_of(drive_log, WORST_ROW)
    assert label is not None
    assert (label.box.w, label.box.h) == (BOX.w, BOX.h)
    assert label.box.x - BOX.x == pytest.approx((end[0] - start[0]) / scale, abs=0.6 / scale)
    assert label.box.y - BOX.y == pytest.approx((end[1] - start[1]) / scale, abs=0.6 / scale)
    assert person.browser.camera() == camera  # the picture stays

    person.press("Control+ArrowRight", "Control+Shift+ArrowDown")
    moved = Box(label.box.x + 1, label.box.y, label.box.w, label.box.h + 1)
    wait_for(lambda: label_of(drive_log, WORST_ROW) == replace(label, box=moved))
    person.at("select[data-fcw-choice=boxkind]").select_option("VAN")
    described = replace(label, box=moved, kind=VehicleKind.VAN)
    wait_for(lambda: label_of(drive_log, WORST_ROW) == described)
    person.press("k")
    wait_for(lambda: person.sees(WORST_ROW + 1) and label_of(drive_log, WORST_ROW + 1) == described)

    for row in range(WORST_ROW + 2, WORST_ROW + 5):
        person.press("ArrowRight")
        wait_for(lambda row=row: person.sees(row))
    person.press("Control+ArrowLeft")
    wait_for(lambda: label_of(drive_log, WORST_ROW + 4) is not None)
    person.press("i")
    wait_for(lambda: label_of(drive_log, WORST_ROW + 3) is not None)
    last = Box(BOX.x - 1, BOX.y, BOX.w, BOX.h)
    for row in range(1, 4):
        between = label_of(drive_log, WORST_ROW + row)
        assert between is not None
        assert between.kind is VehicleKind.VAN
        assert between.box.x == pytest.approx(moved.x + (last.x - moved.x) * row / 4)
    person.press("Control+z")
    wait_for(lambda: label_of(drive_log, WORST_ROW + 2) is None)
    assert label_of(drive_log, WORST_ROW + 1) == described
    # Seen on the time line, and on the picture without the tool.
    wait_for(lambda: person.browser.page.locator("#fcw-whole + .fcw-marks [data-name=labelled]").count() == 2)
    person.press("e")
    wait_for(lambda: not node_is_there(person, "/handles/edge left"))
    assert node_is_there(person, "/lines/boxes/lines_8")
    for keys, tab in (((), "Events"), (("e",), "Boxes"), (("Space",), "Events")):
        person.press(*keys)  # playing puts the tool away, too
        wait_for(lambda tab=tab: open_tab(person) == tab)


def open_tab(person: Reviewer) -> str:
    """The panel's tab that is seen."""
    return person.words("[role=tablist]:has-text('Boxes') [role=tab][aria-selected=true]")


def test_a_range_is_marked_dragged_taken_and_missed(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(f"{review({'made': drive_log}).url}?at=made@2.0"))
    wait_for(lambda: person.sees(row_of(2.0)))
    person.press("a")
    wait_for(lambda: person.browser.page.locator(".fcw-end").count() == 2)
    mouse = person.browser.page.mouse
    mouse.move(*person.place_on("#fcw-markend", 0.5))
    mouse.down()
    mouse.move(*person.place_on("#fcw-whole", 0.5), steps=3)
    mouse.move(*person.place_on("#fcw-whole", 0.25), steps=3)
    mouse.up()
    end_s = 0.25 * (FRAMES - 1) / RATE_HZ
    person.tab("Export")
    wait_for(
        lambda: f"The marked clip: 2.0 s to {end_s:.1f} s" in person.browser.page.content().replace("<b>", "")
    )
    assert person.sees(row_of(2.0))
    person.press("m")
    wait_for(lambda: len(said_of(drive_log).missed) == 1)
    (entry,) = said_of(drive_log).missed
    assert (entry.said.start_s, entry.said.end_s) == (2.0, pytest.approx(end_s, abs=0.05))
    person.press("Escape")
    wait_for(lambda: person.browser.page.locator(".fcw-end:not(.missed)").count() == 0)
    # Its own ends are dragged, too; what is kept is where they are let go of, once.
    mouse.move(*person.place_on(".fcw-end.missed >> nth=1", 0.5))
    mouse.down()
    mouse.move(*person.place_on("#fcw-whole", 0.2), steps=4)
    mouse.move(*person.place_on("#fcw-whole", 0.15), steps=4)
    mouse.up()
    end_s = 0.15 * (FRAMES - 1) / RATE_HZ
    wait_for(lambda: said_of(drive_log).missed[0].said.end_s == pytest.approx(end_s, abs=0.05))
    assert [entry.said.start_s for entry in said_of(drive_log).missed] == [2.0]
    assert len(said_of(drive_log).entries) == 2
    person.press("Control+z")
    wait_for(lambda: said_of(drive_log).missed[0].said == entry.said)


def test_a_refused_note_stays_typed_and_keys_are_the_drives_after_a_click(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url))
    wait_for(lambda: person.sees(WORST_ROW))
    # Whatever was pressed last: the space key plays, and an event to its end.
    for name in ("Keys", "Export", "Boxes"):
        person.tab(name)
    person.browser.page.wait_for_function("document.activeElement === document.body")
    person.press("Shift+Space")
    wait_for(lambda: person.words(".fcw-bar .play") == "Pause")
    wait_for(lambda: person.words(".fcw-bar .play") == "Play" and person.sees(row_of(WARNING_END_S) - 1))

    field = person.at("#fcw-note")
    drive_log.rename(drive_log.with_name("away.mcap"))
    field.fill("a deer at the roadside")
    person.press("Enter")
    wait_for(lambda: "was replaced or deleted" in person.browser.page.content())
    assert field.input_value() == "a deer at the roadside"
    drive_log.with_name("away.mcap").rename(drive_log)
    field.press("Enter")
    wait_for(lambda: field.input_value() == "")
    assert [entry.said.text for entry in said_of(drive_log).notes] == ["a deer at the roadside"]


def start(log: Path) -> tuple["subprocess.Popen[str]", str]:
    """The program by itself; its process and the page's address."""
    return serve_page("review", log, "--no-open", "--reviewer", "bert", "--port", FIRST_PORT + 60)


def test_a_killed_server_comes_back_with_every_word(drive_log: Path, open_page: OpenPage, wait_for: WaitFor):
    process, url = start(drive_log)
    person = Reviewer(open_page(f"{url}?at=drive@9.4"))
    wait_for(lambda: person.sees(row_of(9.4)))
    person.press("3")
    wait_for(lambda: person.words(".fcw-event em") == "▸")
    person.press("t")
    person.browser.page.keyboard.type("brakes late")  # at once: nobody looks where the cursor is by now
    person.press("Enter")
    person.tab("Notes")
    wait_for(lambda: "brakes late" in person.words(".fcw-remark"))
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert [entry.said.judgement for entry in said_of(drive_log).verdicts] == [Judgement.TOO_LATE]
    assert [entry.said for entry in said_of(drive_log).notes] == [Note(9.4, "brakes late")]

    person.browser.page.evaluate("document.querySelector('.fcw-clock').dataset.old = 'yes'")
    process, again = start(drive_log)
    assert again == url
    # The page that was open finds the server by itself, at the moment where it was.
    person.browser.page.wait_for_function(
        "document.querySelector('.fcw-clock') && !document.querySelector('.fcw-clock').dataset.old"
    )
    wait_for(lambda: person.sees(row_of(9.4)))
    wait_for(lambda: person.words(".fcw-event em") == "▸")
    person.tab("Notes")
    wait_for(lambda: "brakes late" in person.words(".fcw-remark"))
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert err == "fcw: interrupted\n"


def test_verdict_after_verdict_through_all_drives(
    tmp_path: Path, drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    other = tmp_path / "other" / "drive.mcap"
    other.parent.mkdir()
    shutil.copy(drive_log, other)
    quiet = write_drive(tmp_path / "quiet" / "drive.mcap", QUIET_S)
    person = Reviewer(
        open_page(review({"made": drive_log, "other": other, "quiet": quiet}).url, picture=False)
    )
    rows = person.browser.page.locator(".fcw-row")
    wait_for(lambda: rows.count() == 3 and "reading" not in person.words(".fcw-folder > p"))
    search = person.at("#fcw-search")
    search.type("oth")
    wait_for(lambda: rows.count() == 1)
    assert search.input_value() == "oth"
    search.fill("")
    person.at("select[data-fcw-choice=filterkind]").select_option("near miss")
    wait_for(lambda: rows.count() == 2)
    person.at(".fcw-filter button:has-text('Auto-next')").click()
    person.at(".fcw-filter button:has-text('Next unjudged')").click()
    wait_for(lambda: person.sees(row_of(NEAR_MISS_S)) and person.words(".fcw-drive b") == "made")
    person.press("1")
    wait_for(lambda: person.words(".fcw-drive b") == "other" and person.sees(row_of(NEAR_MISS_S)))
    person.press("4")
    wait_for(lambda: "every event that matches the filter is judged" in person.browser.page.content())
    assert [entry.said.judgement for entry in said_of(drive_log).verdicts] == [Judgement.RIGHT]
    assert [entry.said.judgement for entry in said_of(other).verdicts] == [Judgement.FALSE]
    person.press("l")
    person.at("select[data-fcw-choice=filterverdict]").select_option("false")
    wait_for(lambda: rows.count() == 1 and person.words(".fcw-row").startswith("other"))
    person.browser.page.reload()
    wait_for(lambda: rows.count() == 1 and person.words(".fcw-row").startswith("other"))
    person.browser.page.wait_for_function("!document.querySelector('.fcw-first')")
    wait_for(lambda: person.at("select[data-fcw-choice=filterverdict]").input_value() == "false")
    person.press("ArrowDown", "Enter")
    wait_for(lambda: person.words(".fcw-drive b") == "other" and person.sees(row_of(NEAR_MISS_S)))
