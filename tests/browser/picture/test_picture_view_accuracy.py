"""A click lands where the mouse points, measured on what the browser has drawn."""

import math
import time
from collections.abc import Generator, Iterable

import cv2
import numpy as np
import pytest
from browser_page import PATIENCE_S, BrowserPage
from numpy.typing import NDArray
from picture_server import SIZE, PictureServer

TOLERANCE_PX = 0.1
ZOOM = 6.0
PANEL_PX = (340, 320)
"""Width and height of viser's panel at the top right, which lies over the picture."""
DOTS = {
    (255, 0, 0): (640, 360),
    (0, 255, 0): (3, 430),
    (0, 0, 255): (30, 702),
    (255, 255, 0): (1276, 712),
    (0, 255, 255): (411, 203),
    (255, 0, 255): (901, 588),
}
"""Colour (RGB) and middle (column, row) of squares of three by three pixels on black."""
Color = tuple[int, int, int]
INNER, CORNER = (255, 0, 255), (0, 0, 255)
LIGHT = (np.arange(256) / 255) ** 2.2
"""Of a grey level. Pixels are blended in it: only there is the middle of a blurred dot its middle."""
ZOOMED_TO = (INNER, CORNER)
"""The one in the corner is well inside the window only after panning."""


@pytest.fixture
def dots() -> Generator[PictureServer]:
    picture = np.zeros((SIZE.height, SIZE.width, 3), np.uint8)
    for color, (column, row) in DOTS.items():
        picture[row - 1 : row + 2, column - 1 : column + 2] = color[::-1]
    server = PictureServer(picture)
    yield server
    server.stop()


@pytest.mark.parametrize("window_px", [(1400, 900), (1000, 900), (1600, 700)])
def test_click_lands_on_the_dot_at_fit_zoomed_and_panned(dots, open_page, wait_for, window_px):
    tab = open_page(dots.url, window_px, drawn_at=1.0, always_drawn=False)

    def click_error_px(color, seen: tuple[float, float]) -> tuple[float, float]:
        """Error of the position reported, and of the position of the mouse itself."""
        seen_x, seen_y = seen
        x, y = round(seen_x - 0.5), round(seen_y - 0.5)
        count = len(dots.clicks)
        tab.page.mouse.click(x, y)
        wait_for(lambda: len(dots.clicks) == count + 1)
        column, row = DOTS[color]
        off_px = np.array([x + 0.5 - seen_x, y + 0.5 - seen_y]) * pixels_per_screen_pixel(tab)
        reported_px = np.array(dots.clicks[-1]) - (column, row)
        return float(np.abs(reported_px - off_px).max()), float(np.abs(reported_px).max())

    for color, seen in seen_at(tab, *DOTS).items():
        error_px, from_dot_px = click_error_px(color, seen)
        assert error_px <= TOLERANCE_PX
        assert from_dot_px <= TOLERANCE_PX + 0.5 * pixels_per_screen_pixel(tab)

    for color in ZOOMED_TO:
        dots.view.fit()
        tab.wait_until_still()
        tab.wheel(*DOTS[color], notches=7)
        assert pixels_per_screen_pixel(tab) <= 1 / ZOOM
        if color == INNER:
            assert click_error_px(color, seen_at(tab, color)[color])[1] <= TOLERANCE_PX
        tab.page.mouse.move(*tab.mouse_position(*DOTS[color]))
        tab.page.mouse.down()
        carried_to = (window_px[0] / 2 - 100, window_px[1] / 2 + 50)
        tab.page.mouse.move(*carried_to, steps=4)
        tab.page.mouse.up()
        tab.wait_until_still()
        assert tab.screen_position(*DOTS[color]) == pytest.approx(carried_to, abs=2)
        assert click_error_px(color, seen_at(tab, color)[color])[1] <= TOLERANCE_PX


def test_the_harness_finds_pixels_where_the_browser_draws_them(dots, open_page):
    tab = open_page(dots.url, drawn_at=1.0, always_drawn=False)
    for color, seen in seen_at(tab, *DOTS).items():
        assert tab.screen_position(*DOTS[color]) == pytest.approx(seen, abs=0.2)


def pixels_per_screen_pixel(tab: BrowserPage) -> float:
    left, right = tab.screen_position(0, 0), tab.screen_position(1000, 0)
    return 1000 / math.dist(left, right)


def seen_at(tab: BrowserPage, *colors: Color) -> dict[Color, tuple[float, float]]:
    """Where the dots' middles are in one screenshot: CSS pixels, a pixel's middle at one half."""
    end_s = time.monotonic() + PATIENCE_S
    dots = dots_of(screenshot(tab), colors)
    while not all(map(len, dots.values())) and time.monotonic() < end_s:
        tab.wait_until_still()  # a slow browser draws the picture some time after the page is ready
        dots = dots_of(screenshot(tab), colors)
    found = {}
    for color, seen in dots.items():
        assert len(seen) > 0, f"the dot {color} is not to be seen"
        column, row = np.average(seen[:, :2], axis=0, weights=seen[:, 2])
        found[color] = float(column) + 0.5, float(row) + 0.5
    return found


def screenshot(tab: BrowserPage) -> NDArray[np.float64]:
    """(rows, columns, 3) RGB, in light; black where the panel is."""
    png = cv2.imdecode(np.frombuffer(tab.seen(), np.uint8), cv2.IMREAD_COLOR)
    assert png is not None
    shot = LIGHT[np.asarray(cv2.cvtColor(png, cv2.COLOR_BGR2RGB), np.uint8)]
    shot[: PANEL_PX[1], -PANEL_PX[0] :] = 0
    return shot


def dots_of(shot: NDArray[np.float64], colors: Iterable[Color]) -> dict[Color, NDArray[np.float64]]:
    """Of each colour (N, 3): column, row and brightness of its pixels."""
    dots = {}
    for color in colors:
        lit = np.array(color) > 0
        is_color = shot[..., ~lit].max(axis=2) < 0.002
        rows, columns = np.nonzero(is_color & (shot[..., lit].min(axis=2) > 0.002))
        dots[color] = np.column_stack((columns, rows, shot[rows, columns].max(axis=1))).astype(np.float64)
    return dots
