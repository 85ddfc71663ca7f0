"""What came with the page is used before the page's own panels are there, and nothing done there is lost."""

from playwright.sync_api import Browser

from fcw_viz.page.first import first_html

LIST = (
    '<input id="find" data-fcw-typed="search" value=""><select data-fcw-choice="kind">'
    "<option value='' selected>all</option><option value='b'>b</option></select>"
    '<div class="list" style="height: 50px; overflow-y: auto">'
    '<p data-fcw="open:a" style="height: 40px">a</p><p data-fcw="open:b" style="height: 40px">b</p></div>'
)
CHANNEL = "window.told = []; window.fcwChannel = { tell: (words) => window.told.push(words) };"


def test_what_is_typed_chosen_scrolled_and_pressed_early_is_taken_over(chromium: Browser):
    page = chromium.new_page()
    html = first_html(LIST, ".list", False)
    page.set_content(f"<body>{html}<div id='root'></div></body>")
    page.evaluate(
        "for (const kind of ['input', 'change']) document.addEventListener(kind, ({ target }) => "
        "target.closest('.fcw-first') || window.told.push(`${kind}:${target.value}`))"
    )
    page.evaluate(CHANNEL.replace("window.fcwChannel", "window.later"))
    page.locator("select").select_option("b")
    page.locator("p").first.click()
    page.locator("p").last.click()
    page.locator(".list").evaluate("one => { one.scrollTop = 17; }")
    page.locator("#find").press_sequentially("ab")
    page.evaluate(CHANNEL)
    page.evaluate("html => { document.querySelector('#root').innerHTML = html; }", LIST)
    page.wait_for_function("!document.querySelector('.fcw-first')")
    assert page.evaluate("window.told") == ["input:ab", "change:b", "open:b"]
    assert page.locator("#find").input_value() == "ab"
    assert page.locator("select").input_value() == "b"
    assert page.evaluate("document.activeElement.id") == "find"
    assert page.locator(".list").evaluate("one => one.scrollTop") == 17
    page.context.close()
