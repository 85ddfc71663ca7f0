"""In a window of any size nothing covers or cuts off another part of the page."""

import shutil
from pathlib import Path

import pytest
from review_helpers import OpenPage, Review, Reviewer, WaitFor

WINDOWS_PX = ((1400, 900), (1220, 700), (900, 700), (768, 1024), (700, 700), (600, 960), (390, 844))
# Left, top, right and bottom of what is seen.
RECTANGLE = """selector => {
  const { left, top, right, bottom } = document.querySelector(selector).getBoundingClientRect();
  return [left, top, right, bottom];
}"""
# Of the buttons and lists of the strip, and of the panel's, those that are not where somebody can press them.
UNREACHED = """selector => [...document.querySelectorAll(selector)].filter((element) => {
  const { left, top, width, height } = element.getBoundingClientRect();
  const [x, y] = [left + width / 2, top + height / 2];
  if (y > window.innerHeight && element.closest(".mantine-ScrollArea-viewport")) return false;
  return !element.contains(document.elementFromPoint(x, y)) || left < 0 || left + width > window.innerWidth;
}).map((element) => element.outerHTML)"""
# Buttons of the strip that do not show all their words.
CUT = """() => [...document.querySelectorAll(".fcw-bar button")].filter(
  (button) => button.scrollWidth > button.clientWidth).map((button) => button.innerText)"""
# The upper edges of the panel's tabs.
TAB_ROWS = "() => [...document.querySelectorAll('[role=tab]')].map((tab) => tab.getBoundingClientRect().top)"
# As viser does where the browser is busy: right when the page looks, and wrong again before the next frame.
STALE_SIZE = """async () => {
  const { canvas, syncCanvasSize: set } = window.__viserMutable, place = canvas.parentElement;
  const [width, height] = [place.clientWidth, place.clientHeight], later = window.setTimeout;
  await new Promise((looked) => {
    const between = (look) => () => {
      window.setTimeout = later;
      set(width, height);
      look();
      set(width, height + 100);
      looked();
    };
    window.setTimeout = (task, wait_ms) => later(wait_ms === 250 ? between(task) : task, wait_ms);
    set(width, height + 100);
  });
}"""
CANVAS_FILLS_ITS_PLACE = """() => {
  const { canvas } = window.__viserMutable;
  return Math.abs(canvas.clientHeight - canvas.parentElement.clientHeight) <= 1;
}"""
PANEL = ".mantine-Paper-root:has(.fcw-drive)"

Rectangle = tuple[float, float, float, float]


@pytest.fixture(scope="module")
def drives(made_log: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    names = ("first", "second")
    return {name: Path(shutil.copy(made_log, tmp_path_factory.mktemp(name))) for name in names}


def overlap_px(one: Rectangle, other: Rectangle) -> float:
    """The smaller side of what two rectangles share; below one pixel edges only touch."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return min(width, height)


def test_strip_picture_panel_and_list_stand_beside_each_other(
    drives: dict[str, Path], review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(f"{review(drives).url}?at=first"))
    page = person.browser.page
    person.browser.wait_until_still()
    first_panel = page.evaluate(RECTANGLE, PANEL)
    for width_px, height_px in WINDOWS_PX:
        page.set_viewport_size({"width": width_px, "height": height_px})
        person.browser.wait_until_still()
        # The server has drawn the plots for the strip's width, and the page its canvas.
        wait_for(lambda: not page.evaluate(UNREACHED, ".fcw-bar button:not([disabled]), .fcw-bar select"))
        assert page.evaluate(CUT) == []
        parts = [
            page.evaluate(RECTANGLE, selector) for selector in ("canvas[data-engine]", ".fcw-strip", PANEL)
        ]
        plots = page.evaluate(RECTANGLE, "#fcw-plots")
        for number, one in enumerate(parts):
            left, top, right, bottom = one
            assert left >= -1
            assert top >= -1
            assert right <= width_px + 1
            assert bottom <= height_px + 1
            assert all(overlap_px(one, other) < 1 for other in parts[number + 1 :]), (width_px, parts)
        # A window that is not wider than high has the picture over all else.
        assert (parts[0][2] >= width_px - 1) == (height_px >= width_px)
        assert plots[2] <= parts[1][2]
        assert plots[3] <= parts[1][3] + 1
        assert page.evaluate(UNREACHED, ".fcw-verdicts button, .fcw-drive button") == []
        assert len(set(page.evaluate(TAB_ROWS))) == 1
        assert page.locator(".fcw-moment").is_visible() == (width_px < 700)
    # Back in the first window it is as it was.
    page.set_viewport_size({"width": WINDOWS_PX[0][0], "height": WINDOWS_PX[0][1]})
    wait_for(lambda: page.evaluate(RECTANGLE, PANEL) == first_panel)
    page.set_viewport_size({"width": 390, "height": 844})
    wait_for(lambda: person.words(".fcw-moment") == "Caution: short time to collision")
    person.press("b")
    wait_for(lambda: page.locator(f"{PANEL} img:visible").count() == 1)
    # Seen from above, what is judged stands in sight under the small picture.
    wait_for(lambda: page.evaluate(RECTANGLE, ".fcw-title")[3] <= 844)
    person.press("l")
    wait_for(lambda: page.locator(".fcw-row .fcw-whole svg").count() == 2)
    wait_for(lambda: not page.evaluate(UNREACHED, ".fcw-row header, .fcw-row svg"))
    assert overlap_px(page.evaluate(RECTANGLE, ".fcw-folder"), page.evaluate(RECTANGLE, PANEL)) < 1
    for width_px in (390, 1000, 1200):
        page.set_viewport_size({"width": width_px, "height": 844})
        wait_for(lambda: not page.evaluate(UNREACHED, ".fcw-filter > *"))


def test_a_picture_made_lower_for_taller_plots_keeps_its_share_of_any_window(
    drives: dict[str, Path], review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(f"{review(drives).url}?at=first"))
    page = person.browser.page

    def picture_px() -> float:
        _, top, _, bottom = page.evaluate(RECTANGLE, "canvas[data-engine]")
        return min(bottom - top, page.evaluate(RECTANGLE, ".fcw-strip")[1])

    def in_every_window() -> list[float]:
        heights = []
        for width_px, height_px in ((390, 844), (820, 560), (1400, 500), WINDOWS_PX[0]):
            page.set_viewport_size({"width": width_px, "height": height_px})
            person.browser.wait_until_still()
            heights.append(picture_px())
        return heights

    usual = in_every_window()
    person.press("h")
    wait_for(lambda: picture_px() < 0.9 * usual[-1])
    shares = [lower / own for lower, own in zip(in_every_window(), usual, strict=True)]
    assert shares == pytest.approx([shares[0]] * len(shares), abs=0.02)
    person.press("h")
    wait_for(lambda: picture_px() == pytest.approx(usual[-1], abs=1))


def test_the_list_shows_long_names_whole(
    drives: dict[str, Path], review: Review, open_page: OpenPage, wait_for: WaitFor
):
    name = "drive_named_as_cameras_do_20261121_130000_front"
    url = review({name: drives["first"], "second": drives["second"]}).url
    page = open_page(url, window_px=(768, 1024), picture=False).page
    wait_for(lambda: page.locator(".fcw-row header b").count() == 2)
    names = page.locator(".fcw-row header b")
    assert names.evaluate_all("names => names.every((name) => name.scrollWidth <= name.clientWidth)")


def test_visers_note_on_software_rendering_does_not_lie_over_the_page(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    note = open_page(review({"made": drive_log}).url).page.locator("#webgl-software-rendering")
    wait_for(lambda: note.count() == 1)  # no machine that tests renders in hardware
    assert not note.is_visible()


def test_the_canvas_fills_its_place_also_when_it_was_only_right_between_two_frames(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    page = open_page(review({"made": drive_log}).url).page
    page.evaluate(STALE_SIZE)
    wait_for(lambda: page.evaluate(CANVAS_FILLS_ITS_PLACE))


def test_in_a_narrow_window_the_reason_why_a_drive_is_not_shown_is_as_wide_as_its_row(
    drives: dict[str, Path], review: Review, open_page: OpenPage, wait_for: WaitFor, tmp_path: Path
):
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(b"no log")
    page = open_page(review(drives | {"torn": torn}).url, window_px=(390, 844), picture=False).page
    wait_for(lambda: page.locator(".fcw-row.still .fcw-told").count() == 1)
    row = page.evaluate(RECTANGLE, ".fcw-row.still")
    reason = page.evaluate(RECTANGLE, ".fcw-row.still .fcw-told")
    assert reason[2] - reason[0] > 0.9 * (row[2] - row[0])
