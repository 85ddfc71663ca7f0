"""The review page as a person uses it."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from browser_page import PATIENCE_S, BrowserPage
from playwright.sync_api import Locator
from review_drives import CODE_BITS, CODE_PX, PERIOD_NS, RATE_HZ

from fcw.annotation.review import Review as Words
from fcw.annotation.store import read_review
from fcw.logs.mcap.reader import DriveLog
from fcw_viz.review_app.server import ReviewPage

Review = Callable[[dict[str, Path]], ReviewPage]
OpenPage = Callable[..., BrowserPage]
WaitFor = Callable[[Callable[[], bool]], None]
FRAME_S = PERIOD_NS / 1e9

# The number that the made drive has written into each picture, read off what three.js draws.
FRAME_NUMBER = f"""() => {{
  let image = null;
  window.__viserMutable?.nodeRefFromName?.["/picture"]?.traverse((node) => {{
    if (node.isMesh && node.material.map) image = image ?? node.material.map.image;
  }});
  if (!(image?.width > 1)) return -1;
  const canvas = new OffscreenCanvas({CODE_BITS * CODE_PX}, {CODE_PX});
  const context = canvas.getContext("2d");
  context.drawImage(image, {CODE_BITS * CODE_PX} - image.width, {CODE_PX} - image.height);
  let number = 0;
  for (let bit = 0; bit < {CODE_BITS}; bit++) {{
    const [red] = context.getImageData(bit * {CODE_PX} + {CODE_PX // 2}, {CODE_PX // 2}, 1, 1).data;
    if (red > 128) number += 1 << bit;
  }}
  return number;
}}"""


@dataclass
class Reviewer:
    """Somebody in front of a tab."""

    browser: BrowserPage

    def press(self, *keys: str) -> None:
        """Press keys one after the other."""
        for key in keys:
            self.browser.page.keyboard.press(key)

    def at(self, selector: str) -> Locator:
        """The first element there."""
        return self.browser.page.locator(selector).first

    def words(self, selector: str) -> str:
        """What is read there; nothing where there is nothing."""
        # In one step: an element that is drawn anew may be gone in the next one.
        return self.browser.page.locator(selector).evaluate_all("(found) => found[0]?.innerText ?? ''")

    def tab(self, name: str) -> None:
        """Turn to a tab of the panel."""
        self.browser.page.get_by_role("tab", name=name).click()

    @property
    def picture(self) -> int:
        """Number of the frame whose picture is seen; -1 before there is one."""
        return self.browser.page.evaluate(FRAME_NUMBER)

    @property
    def row(self) -> int:
        """The row that the time line and the plots stand at; -1 where none is shown."""
        rows = self.browser.page.locator(".fcw-clock").evaluate_all(
            "(found) => found.map((one) => one.dataset.row)"
        )
        return int(rows[0] or -1) if rows else -1

    def cursor_x(self, name: str) -> float:
        """Where a cursor stands on the screen."""
        x, _, width, _ = self._box_of(f'.fcw-cursor[data-cursor="{name}"]')
        return x + width / 2

    def place_on(self, selector: str, part: float) -> tuple[float, float]:
        """A place on an element, so far from its left edge."""
        x, y, width, height = self._box_of(selector)
        return x + part * width, y + height / 2

    def _box_of(self, selector: str) -> tuple[float, float, float, float]:
        end_s = time.monotonic() + PATIENCE_S
        while (box := self.at(selector).bounding_box()) is None:  # while it is drawn anew
            assert time.monotonic() < end_s, f"{selector} was not seen in {PATIENCE_S} s"
        return box["x"], box["y"], box["width"], box["height"]

    def sees(self, row: int) -> bool:
        """Whether picture and cursors show a frame."""
        return self.row == row and self.picture == row


def node_is_there(person: Reviewer, name: str) -> bool:
    """Whether the scene has a node by now."""
    return person.browser.page.evaluate("name => !!window.__viserMutable.nodeRefFromName[name]", name)


def said_of(log: Path) -> Words:
    """What people said of a drive, as it is on the disk."""
    return read_review(DriveLog(log))[0]


def row_of(time_s: float) -> int:
    """The frame of a moment of the made drive."""
    return int(time_s * RATE_HZ + 1e-6)
