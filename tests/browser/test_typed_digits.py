"""Digits typed right after a click on the picture wait for the field that it asks for, and for no other."""

from collections.abc import Generator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from fcw_viz.page import script

FIELDS = Path(script.__file__).with_name("fields.js").read_text()
HEARD = "window.heard"


@pytest.fixture
def page(chromium: Browser) -> Generator[Page]:
    """A picture beside a panel, of which a click on the picture asks for a number."""
    page = chromium.new_page()
    page.set_content(
        "<div><canvas width=300 height=200></canvas></div>"
        "<div><label for='distance'>A, metres</label><input></div>"
    )
    page.evaluate(
        "window.__viserMutable = { canvas: document.querySelector('canvas') }; window.heard = [];"
        "document.documentElement.addEventListener('keydown', ({ key }) => window.heard.push(key));"
    )
    page.evaluate(FIELDS)
    page.evaluate("window.fcwExpectsTyping = { click: true, key: '' }")
    yield page
    page.context.close()


def test_what_is_typed_after_a_click_goes_into_the_field_that_comes(page: Page):
    page.mouse.click(100, 100)
    page.keyboard.type("15")
    assert page.evaluate(HEARD) == []
    page.evaluate("window.fcwFocus('distance')")
    assert page.locator("input").input_value() == "15"


def test_where_no_field_comes_the_digits_are_keys_at_once(page: Page):
    page.mouse.click(100, 100)
    page.keyboard.type("2")
    page.evaluate("window.fcwNoField()")
    page.keyboard.type("3")
    assert page.evaluate(HEARD) == ["2", "3"]


def test_a_picture_that_was_slid_asks_for_nothing(page: Page):
    page.mouse.move(100, 100)
    page.mouse.down()
    page.mouse.move(160, 120)
    page.mouse.up()
    page.keyboard.type("2")
    assert page.evaluate(HEARD) == ["2"]
