"""The plots of the review page in a real Chromium."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from review_drives import BOX, CAUTION_S, FRAMES, NEAR_MISS_S, RATE_HZ
from review_helpers import OpenPage, Review, Reviewer, WaitFor, row_of

from fcw_viz.review_app.drive import time_text
from fcw_viz.review_app.tab import STRIP_MANNERS

WORST_ROW = row_of(CAUTION_S)


def test_plots_are_chosen_read_at_the_mouse_and_made_higher(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    person = Reviewer(open_page(review({"made": drive_log}).url))
    wait_for(lambda: person.sees(WORST_ROW))
    page = person.browser.page
    drawn = "[...document.querySelectorAll('[data-plot]')].map((plot) => plot.dataset.plot)"
    assert page.evaluate(drawn) == ["distance", "closing", "ttc"]
    person.at(".fcw-bar button:has-text('Plot')").click()
    person.at("select[data-fcw-choice=subject]").select_option("7")
    person.at('[data-fcw="plot:box_height 7"]').click()
    wait_for(lambda: page.evaluate(drawn) == ["distance", "closing", "ttc", "box_height"])
    wait_for(lambda: person.words('[data-figure="box_height 7"] b') == f"{BOX.h:.0f} px")
    person.at('.fcw-plot-title button[data-fcw="plot:closing ahead"]').click()
    wait_for(lambda: page.evaluate(drawn) == ["distance", "ttc", "box_height"])

    page.mouse.move(*person.place_on("#fcw-plots", NEAR_MISS_S / (FRAMES - 1) * RATE_HZ + 0.01))
    wait_for(lambda: "11.0 m" in person.words(".fcw-readout"))
    told = page.locator(".fcw-readout > div span:last-child").all_inner_texts()
    assert told[1:] == ["11.0 m", "1.1 s", "–"]  # vehicle 7 is not there any more
    page.mouse.move(*person.place_on("canvas[data-engine]", 0.5))
    wait_for(lambda: not page.locator(".fcw-readout").is_visible())

    height = "document.querySelector('.fcw-area svg[role=img] g[data-plot]').getBBox().height"
    before = page.evaluate(height)
    person.press("h")
    wait_for(lambda: page.evaluate(height) > 1.3 * before)
    person.press("h")
    wait_for(lambda: page.evaluate(height) == pytest.approx(before, rel=0.1))
    # Loaded anew, the page has the plots that were chosen, but those of vehicles.
    page.reload()
    person.browser.wait_until_ready()
    wait_for(lambda: page.evaluate(drawn) == ["distance", "ttc"])


def test_moments_under_the_mouse_are_written_as_everywhere_else(chromium: Browser):
    (clock,) = re.findall(r"const clock = [\s\S]*?\n  };", STRIP_MANNERS)
    moments_s = [0.0, 7.5, 59.996, 60.0, 119.997, 3599.996, 3727.5]
    page = chromium.new_page()
    written = page.evaluate(f"moments => {{ {clock} return moments.map(clock); }}", moments_s)
    page.context.close()
    assert written == [time_text(moment_s, 2) for moment_s in moments_s]
