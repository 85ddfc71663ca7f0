"""The Chromium in which benchmarks of the pages look: without a graphics card, all of one size."""

import argparse
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, ViewportSize, sync_playwright

ARGUMENTS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WINDOW = ViewportSize(width=1400, height=900)
SEES_LIST = """
  const look = () => requestAnimationFrame(() => {
    if (!document.querySelector(".fcw-row")) return look();
    window.listWords = document.querySelector(".fcw-folder > p").innerText;
    setTimeout(() => (window.listSeenAt = performance.now()));
  });
  look();
"""
"""Run with a page, notes when its list of drives is drawn, in ms from the request, and the words over it."""
READY = "!!window.fcwChannel && !document.querySelector('.fcw-first')"
"""The page's own panels are there: until then what came with the page is seen, and what is done waits."""


def option_parser(description: str | None) -> argparse.ArgumentParser:
    """Which browser; the description is what a script says of itself first."""
    parser = argparse.ArgumentParser(description=description.split("\n\n")[0] if description else None)
    found = shutil.which("chromium") or shutil.which("chromium-headless-shell")
    parser.add_argument("--browser", default=found, help="the Chromium to use")
    return parser


@contextmanager
def chromium(options: argparse.Namespace) -> Iterator[Browser]:
    """The browser that the options name, until the context ends."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.browser, args=list(ARGUMENTS))
        yield browser
        browser.close()
