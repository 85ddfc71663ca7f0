"""What the scripts that take pictures of the pages have in common."""

import argparse
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Page, ViewportSize, sync_playwright

IMAGES = Path(__file__).parent / "images"

BROWSER_ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
)
READY_MS = 60_000
STEADY_MS, STEADY_LOOKS = 1_500, 20
"""The page counts as drawn once it has stayed the same this long: software rendering is slow."""
WITHOUT_WARNING = """
  const ask = WebGL2RenderingContext.prototype.getParameter;
  WebGL2RenderingContext.prototype.getParameter = function (name) {
    return name === 37446 ? "hardware" : ask.call(this, name);
  };
"""
"""viser warns of software rendering over the picture; 37446 is UNMASKED_RENDERER_WEBGL."""


def option_parser(description: str | None) -> argparse.ArgumentParser:
    """The options that all of the scripts have; the description is what a script says of itself first."""
    parser = argparse.ArgumentParser(description=description.split("\n\n")[0] if description else None)
    parser.add_argument("--out", type=Path, default=IMAGES, help="folder of the pictures")
    found = shutil.which("chromium") or shutil.which("chromium-headless-shell")
    parser.add_argument("--browser", default=found, help="the Chromium to use")
    parser.add_argument("--size", default="1400x900", help="of the window, WIDTHxHEIGHT")
    return parser


@contextmanager
def chromium(options: argparse.Namespace) -> Iterator[Browser]:
    """The browser that the options name, until the context ends."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.browser, args=list(BROWSER_ARGUMENTS))
        yield browser
        browser.close()


def window(browser: Browser, options: argparse.Namespace) -> BrowserContext:
    """A window of the size that the options ask for."""
    width, height = (int(length) for length in options.size.split("x"))
    context = browser.new_context(viewport=ViewportSize(width=width, height=height))
    context.add_init_script(WITHOUT_WARNING)
    return context


def steady_screenshot(page: Page) -> bytes:
    """The page as a PNG, once two looks at it are the same."""
    before = b""
    for _ in range(STEADY_LOOKS):
        page.wait_for_timeout(STEADY_MS)
        seen = page.screenshot()
        if seen == before:
            return seen
        before = seen
    raise SystemExit("the page does not come to rest")
