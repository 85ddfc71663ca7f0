"""A list is gone through by keys, and fields are typed in, also while they are drawn anew."""

from collections.abc import Generator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from fcw_viz.page import channel
from fcw_viz.page.channel import enters, is_item, says, tells_typed

CHANNEL = Path(channel.__file__).with_suffix(".js").read_text()
ROWS = "".join(
    f'<div style="height: 60px" {is_item(name, opens)} {says(f"open:{name}") if opens else ""}>{name}</div>'
    for name, opens in (("a", True), ("no log", False), ("b", True), ("c", True))
)
LIST = f'<input id="find"><button>filter</button><div style="height: 100px; overflow-y: auto">{ROWS}</div>'
DRAW = "html => { document.querySelector('#root').innerHTML = html; }"
FOCUSED = "document.activeElement.innerText"


@pytest.fixture
def page(chromium: Browser) -> Generator[Page]:
    """A page with the list, and no more of the program than its channel."""
    page = chromium.new_page()
    page.set_content("<body><div id='root'></div></body>")
    page.evaluate(
        "window.told = []; window.heard = [];"
        "window.__viserMutable = { sendMessage: ({ updates }) => window.told.push(updates.value) };"
        "document.documentElement.addEventListener('keydown', ({ key }) => window.heard.push(key));"
    )
    page.evaluate(f"() => {{ const uuid = 'field'; {CHANNEL} }}")
    page.evaluate(DRAW, LIST)
    yield page
    page.context.close()


def press(page: Page, *keys: str) -> str:
    """Press keys; what has the focus then."""
    for key in keys:
        page.keyboard.press(key)
    return page.evaluate(FOCUSED)


def test_arrows_lead_from_row_to_row_and_enter_opens_one(page: Page):
    assert press(page, "ArrowDown") == "a"
    assert press(page, "ArrowDown") == "no log"
    assert press(page, "ArrowDown", "ArrowDown", "ArrowDown") == "c"
    in_sight = "document.activeElement.getBoundingClientRect().bottom <= "
    assert page.evaluate(f"{in_sight} document.activeElement.parentElement.getBoundingClientRect().bottom")
    assert press(page, "Home") == "a"
    assert press(page, "ArrowUp") == "a"
    assert press(page, "End", "ArrowUp") == "b"
    press(page, "Enter")
    assert page.evaluate("window.told.at(-1)").endswith("open:b")
    assert page.evaluate("window.heard") == []  # none of them means anything else there


def test_the_list_drawn_anew_has_the_focus_where_it_was(page: Page):
    press(page, "ArrowDown", "ArrowDown", "ArrowDown")
    page.evaluate(DRAW, LIST)
    page.wait_for_function(f"{FOCUSED} === 'b'")
    page.evaluate(DRAW, "")  # a drive is open, and another one when it is left
    page.evaluate("window.fcwChannel.row = 'c'")
    assert press(page, "ArrowDown") == page.evaluate("document.body.innerText")
    assert page.evaluate("window.heard") == ["ArrowDown"]
    page.evaluate(DRAW, LIST)
    page.wait_for_function(f"{FOCUSED} === 'c'")
    assert press(page, "ArrowUp") == "b"


def test_tab_stops_at_rows_and_a_field_keeps_its_keys(page: Page):
    assert press(page, "Tab", "Tab", "Tab") == "a"
    page.locator("#find").focus()
    press(page, "End", "ArrowDown", "Enter")
    assert page.evaluate("document.activeElement.id") == "find"
    assert page.evaluate("window.heard") == ["Tab"] * 3 + ["End", "ArrowDown", "Enter"]
    page.locator("button").focus()
    press(page, "Enter")
    assert not any("open:" in words for words in page.evaluate("window.told"))


@pytest.mark.parametrize("manner", [enters("note", "note"), tells_typed("search", "search")])
def test_what_is_half_typed_stays_when_its_field_is_drawn_anew(page: Page, manner: str):
    field = f"<input {manner}>"
    page.evaluate(DRAW, field)
    page.locator("input").focus()
    press(page, "a", "c", "ArrowLeft")
    page.evaluate(DRAW, f"<p>somebody else has said something</p>{field}")
    press(page, "b")  # no key of the page
    assert page.locator("input").input_value() == "abc"
    page.locator("input").evaluate("field => field.blur()")
    page.evaluate("() => new Promise(setTimeout)")
    page.evaluate(DRAW, field)
    page.evaluate("() => Promise.resolve()")
    assert page.evaluate("document.activeElement.tagName") == "BODY"
    assert page.locator("input").input_value() == "abc"
    page.evaluate(DRAW, f"<input {manner} value='abc'>")  # it is kept
    page.evaluate(DRAW, f"<input {manner} value='abc, and more of another tab'>")
    assert page.locator("input").input_value() == "abc, and more of another tab"


def test_a_mark_that_is_drawn_anew_while_it_is_pressed_is_pressed(page: Page):
    # It is SVG, which has no `click()`.
    mark = f'<svg width="60" height="60"><g {says("event:1")}><rect width="60" height="60"/></g></svg>'
    page.evaluate(DRAW, mark)
    page.locator("rect").hover()
    page.mouse.down()
    page.evaluate(DRAW, mark)
    page.mouse.up()
    assert page.evaluate("window.told.at(-1)").endswith("event:1")
