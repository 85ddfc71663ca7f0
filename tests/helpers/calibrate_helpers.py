"""The calibration page as a person uses it: its fields, buttons and words."""

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
from browser_page import NOTIFICATION, BrowserPage
from playwright.sync_api import Locator

from fcw.sources import VideoSource
from fcw_viz.calibrate_app.server import CalibrationPage

DEMO_DRIVE = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
DEMO_MARKS_PX = ((640.0, 502.0), (640.0, 409.0), (640.0, 372.0))
"""The white marks 6, 15 and 30 m ahead of the bumper, about."""
FIRST_PORT = 8400
Serve = Callable[[Path], CalibrationPage]
OpenPage = Callable[..., BrowserPage]
WaitFor = Callable[[Callable[[], bool]], None]


def copy_of_demo_drive(folder: Path) -> Path:
    """The shipped drive alone, without its calibration."""
    return Path(shutil.copy(DEMO_DRIVE, folder))


def pictures_of_demo_drive(folder: Path, count: int = 2) -> Path:
    """A folder with the first pictures of the shipped drive: a source that runs in a moment."""
    pictures = folder / "drive"
    pictures.mkdir()
    for frame, _ in zip(VideoSource(DEMO_DRIVE).frames(), range(count), strict=False):
        cv2.imwrite(str(pictures / f"{frame.index}.png"), frame.image)
    return pictures


@dataclass
class Person:
    """Somebody in front of a tab."""

    browser: BrowserPage

    def field(self, label: str) -> Locator:
        """The field whose label begins so."""
        path = f"//label[starts-with(normalize-space(.), {label!r})]/ancestor::div[.//input][1]//input"
        return self.browser.page.locator(f"xpath={path}").first

    def button(self, words: str) -> Locator:
        """The button that says this somewhere."""
        return self.browser.page.get_by_role("button", name=words)

    def press(self, *keys: str) -> None:
        """Press keys one after the other."""
        for key in keys:
            self.browser.page.keyboard.press(key)

    def type(self, text: str) -> None:
        """Type where the cursor is."""
        self.browser.page.keyboard.type(text)

    def put_away_notifications(self) -> None:
        """Close what lies over the picture."""
        for close in self.browser.page.locator(f"{NOTIFICATION} .mantine-Notification-closeButton").all():
            close.click()

    def words(self, selector: str) -> str:
        """What is read there; the first one."""
        return self.browser.page.locator(selector).first.inner_text()

    def heading_y(self, words: str) -> float:
        """Where the heading of a step begins, in pixels of the window."""
        box = self.browser.page.locator(".fcw-step", has_text=words).first.bounding_box()
        return -math.inf if box is None else box["y"]

    @property
    def banner(self) -> str:
        """The line over the picture."""
        return self.words(".fcw-banner")

    @property
    def table(self) -> list[list[str]]:
        """The points' table without its head."""
        # In one step: rows may be drawn anew between two.
        rows = self.browser.page.locator(".fcw table tr").evaluate_all(
            "(rows) => rows.map((row) => [...row.querySelectorAll('td')].map((cell) => cell.innerText))"
        )
        return [row for row in rows if len(row) > 4]

    def cursor_is_in(self, label: str) -> bool:
        """Whether the cursor is in the field whose label begins so."""
        return self.field(label).evaluate("field => field === document.activeElement")
