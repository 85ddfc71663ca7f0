"""The road from above in a real Chromium: there, while it plays, and back to the very same picture."""

from pathlib import Path

import pytest
from review_drives import BOX, CAUTION_S, write_drive
from review_helpers import OpenPage, Review, Reviewer, WaitFor, row_of

WORST_ROW = row_of(CAUTION_S)
# Boxes of vehicles that are seen: what viser calls its nodes, and where three.js has them.
SEEN = """() => {
  const found = [];
  for (let number = 0; number < 16; number++) {
    const node = window.__viserMutable.nodeRefFromName?.[`/birds_eye/vehicle ${number}`];
    if (!node) continue;
    let visible = true;
    for (let one = node; one; one = one.parent) visible &&= one.visible;
    if (visible) found.push(node.position.toArray());
  }
  return found;
}"""


@pytest.fixture
def drive_log(tmp_path: Path) -> Path:
    return write_drive(tmp_path / "drive.mcap", 14.0)


def test_there_and_back_the_picture_is_exactly_as_before(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url, drawn_at=0.25))
    wait_for(lambda: person.sees(WORST_ROW))
    browser = person.browser
    browser.wait_until_still()
    browser.wheel(300.0, 150.0, 2)  # zoomed in somewhere
    before, place = browser.camera(), browser.screen_position(300.0, 200.0)

    person.press("b")
    wait_for(lambda: len(browser.page.evaluate(SEEN)) == 2)
    wait_for(lambda: browser.page.get_by_role("img").count() > 0)
    assert person.words(".fcw-bar > .on") == "From above"
    x, y = browser.page.viewport_size["width"] / 3, 200  # pyright: ignore[reportOptionalSubscript]
    browser.page.mouse.move(x, y)
    browser.page.mouse.down()
    browser.page.mouse.move(x + 150, y + 40, steps=4)
    browser.page.mouse.up()
    browser.wait_until_still()
    turned = browser.camera()
    assert turned[3:] != pytest.approx(before[3:], abs=0.05)
    person.press("f", "=")  # neither fits nor zooms the picture from here
    person.press("ArrowRight")
    wait_for(lambda: person.row == WORST_ROW + 1)
    browser.wait_until_still()
    assert browser.camera() == turned

    person.press("b")
    wait_for(lambda: browser.page.evaluate(SEEN) == [])
    wait_for(lambda: person.sees(WORST_ROW + 1))
    browser.wait_until_still()
    assert browser.camera() == pytest.approx(before, abs=1e-6)
    assert browser.screen_position(300.0, 200.0) == pytest.approx(place, abs=1e-6)


def test_clicks_on_the_picture_are_exact_after_coming_back(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    page = review({"made": drive_log})
    person = Reviewer(open_page(page.url))
    wait_for(lambda: person.sees(WORST_ROW))
    (tab,) = page.tabs
    clicks: list[tuple[float, float]] = []
    tab.view.on_click(lambda column_px, row_px: clicks.append((column_px, row_px)))
    person.browser.wait_until_still()
    before = person.browser.camera()
    mouse = person.browser.mouse_position(BOX.x + 20.0, BOX.y + 30.0)
    person.browser.page.mouse.click(*mouse)
    wait_for(lambda: len(clicks) == 1)
    assert clicks[0] == pytest.approx((BOX.x + 20.0, BOX.y + 30.0), abs=0.5)
    person.press("b")
    wait_for(lambda: len(person.browser.page.evaluate(SEEN)) == 2)
    person.browser.page.mouse.click(*mouse)  # on the road from above: no click on the picture
    person.press("b")
    wait_for(lambda: person.sees(WORST_ROW))
    # Where the machine is busy the canvas may change its size once more, and the picture is fitted once more.
    wait_for(lambda: person.browser.camera() == pytest.approx(before, abs=1e-6))
    person.browser.page.mouse.click(*mouse)
    wait_for(lambda: len(clicks) == 2)
    assert clicks[1] == pytest.approx(clicks[0], abs=1e-6)


def test_it_follows_while_the_drive_plays(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(f"{review({'made': drive_log}).url}?at=made@8"))
    wait_for(lambda: person.sees(row_of(8.0)))
    person.press("b")

    def nearest_m() -> float:
        return min((position[0] for position in person.browser.page.evaluate(SEEN)), default=0.0)

    # 4.5 m long boxes: the lead's middle is 2.25 m behind its rear, 40 m away now and 22.5 m when it warns.
    wait_for(lambda: nearest_m() == pytest.approx(42.25))
    person.browser.wait_until_still()  # without a graphics card the first drawing takes seconds
    person.press("Space")
    wait_for(lambda: nearest_m() == pytest.approx(24.75))
    person.press("Escape")
    wait_for(lambda: person.words(".fcw-bar .play") == "Play")
