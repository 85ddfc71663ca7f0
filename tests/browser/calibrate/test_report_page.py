"""The report, and the widths that labels are given, in a real browser."""

from collections.abc import Sequence
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page

from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.document.state import SessionState
from fcw_viz.calibrate_app.drawing.drawing import STALE_WORDS, draw
from fcw_viz.calibrate_app.report import report_html
from fcw_viz.calibrate_app.session import CalibrationSession
from fcw_viz.page.picture.label_layout import (
    FONT_CSS_PX,
    LABEL_HEIGHT_CSS_PX,
    Window,
    text_width_css_px,
)

SIZE = ImageSize(1280, 720)
VISER_FONTS = '-apple-system, BlinkMacSystemFont, "Segoe UI", "Roboto", "Helvetica Neue", Arial, sans-serif'
VISER_MARGIN = 0.2
"""Of a label's ground around its words, in heights of a line."""
MEASURE = """([fonts, texts]) => {
  const context = document.createElement("canvas").getContext("2d");
  context.font = fonts;
  const line = context.measureText("Mgj");
  const height = line.fontBoundingBoxAscent + line.fontBoundingBoxDescent;
  return [height, texts.map((text) => context.measureText(text).width)];
}"""


@pytest.fixture
def state(tmp_path: Path) -> SessionState:
    session = CalibrationSession.open(tmp_path / "drive.mp4", SIZE, tmp_path / "drive.calibration.yaml")
    person = session.join(lambda state: None)
    points = ((5.0, 594.0), (10.0, 461.0), (15.0, 417.0), (20.0, 394.0))
    marks = [AddMark(640.0, row_px, 0, distance_m) for distance_m, row_px in points]
    session.apply(person, SetHeight(1.225), *marks)
    return session.state


@pytest.fixture
def page(chromium: Browser) -> Page:
    return chromium.new_page()


def line_height_and_widths(page: Page, texts: Sequence[str]) -> tuple[float, list[float]]:
    return page.evaluate(MEASURE, [f"{FONT_CSS_PX}px {VISER_FONTS}", list(texts)])


@pytest.mark.parametrize("color_scheme", ["light", "dark"])
def test_the_report_opens_without_a_network_and_without_complaint(
    chromium: Browser, state: SessionState, tmp_path: Path, color_scheme: str
) -> None:
    path = tmp_path / "report.html"
    picture = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    path.write_text(report_html(state, picture, 0, "drive.mp4", date(2026, 11, 20), {"fcw": "0.1.0"}))
    page = chromium.new_page(color_scheme="dark" if color_scheme == "dark" else "light")
    complaints: list[str] = []
    requests: list[str] = []

    def listen(message: ConsoleMessage) -> None:
        complaints.append(message.text)

    page.on("console", listen)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    assert not complaints
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == []
    assert page.evaluate("document.querySelector('svg image').getBoundingClientRect().width") > 500
    # Nothing is wider than the page, on the screen or on paper.
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    page.close()


def test_labels_are_given_the_width_that_their_words_take(page: Page, state: SessionState) -> None:
    texts = {
        "one more point here, at about 131 ft, would cut the error by 21%",
        "AA  distance?, off",
        STALE_WORDS,
    }
    for scale in (0.02, 0.1, 0.3, 1.0):
        window = Window(300.0, 330.0, 300.0 + 1000 * scale, 330.0 + 800 * scale, scale)
        texts |= {label.text for label in draw(state, None, 0, window).labels}
    words = sorted(texts)
    assert len(words) > 5
    height, widths = line_height_and_widths(page, words)
    assert height * (1 + VISER_MARGIN) <= LABEL_HEIGHT_CSS_PX
    for text, width in zip(words, widths, strict=True):
        assert width + VISER_MARGIN * height <= text_width_css_px(text), text
