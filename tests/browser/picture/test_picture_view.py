"""What a person can do on the picture, with a real mouse and keyboard."""

from collections.abc import Generator

import cv2
import numpy as np
import pytest
from browser_page import BrowserPage
from picture_server import SIZE, PictureServer

from fcw_viz.page.picture.magnifier import MAGNIFICATION, magnified

CENTRE = ((SIZE.width - 1) / 2, (SIZE.height - 1) / 2)
CORNERS = ((0, 0), (SIZE.width - 1, 0), (0, SIZE.height - 1), (SIZE.width - 1, SIZE.height - 1))
HANDLE = (400.0, 450.0)
PATCH_RGB = (200, 30, 90)
PATCH = (300, 560)
"""Middle of the only coloured square of a grey picture."""


@pytest.fixture
def server() -> Generator[PictureServer]:
    picture = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    column, row = PATCH
    picture[row - 8 : row + 9, column - 8 : column + 9] = PATCH_RGB[::-1]
    server = PictureServer(picture, handle_at_px=HANDLE)
    yield server
    server.stop()


def test_nothing_tilts_or_rolls_the_view(server, open_page, wait_for):
    tab = open_page(server.url)
    level = tab.camera()
    for key in ("ArrowUp", "ArrowLeft", "w", "s", "a", "d", "q", "e"):
        tab.page.keyboard.down(key)
        tab.page.wait_for_timeout(150)
        tab.page.keyboard.up(key)
    tab.wait_until_still()
    assert tab.camera() == pytest.approx(level, abs=1e-9)

    for button, modifier in (("left", None), ("right", None), ("left", "Control"), ("left", "Alt")):
        tab.page.mouse.move(600, 500)
        if modifier is not None:
            tab.page.keyboard.down(modifier)
        tab.page.mouse.down(button=button)
        tab.page.mouse.move(640, 560, steps=3)
        tab.page.mouse.up(button=button)
        if modifier is not None:
            tab.page.keyboard.up(modifier)
        tab.wait_until_still()
        assert tab.camera()[3:] == pytest.approx(level[3:], abs=1e-9)
    assert server.clicks == []

    tab.page.get_by_role("button", name="Reset View").click()  # viser's own, which looks from a corner
    wait_for(lambda: tab.camera() == pytest.approx(level, abs=1e-6))


def test_a_touch_slides_the_picture_and_adds_no_point(server, open_page):
    tab = open_page(server.url)
    level = tab.camera()
    x, y = tab.screen_position(*CENTRE)
    there_px = (CENTRE[0] + 60, CENTRE[1])
    there_x, _ = tab.screen_position(*there_px)
    tab.touch([CENTRE, (CENTRE[0] + 30, CENTRE[1]), there_px])
    tab.wait_until_still()
    assert tab.camera()[3:] == pytest.approx(level[3:], abs=1e-9)
    assert tab.screen_position(*CENTRE) == pytest.approx((there_x, y), abs=1)
    assert there_x - x > 30
    assert server.clicks == []


def test_a_tap_is_a_click_and_two_fingers_only_zoom(server, open_page, wait_for):
    tab = open_page(server.url)
    tab.touch([PATCH])
    wait_for(lambda: len(server.clicks) == 1)
    assert server.clicks[0] == pytest.approx(PATCH, abs=0.6)

    tab.touch([HANDLE])
    wait_for(lambda: len(server.handle_clicks) == 1)
    end_px = (523.0, 381.0)
    tab.touch([HANDLE, (460.0, 420.0), end_px])
    wait_for(lambda: bool(server.drags) and server.drags[-1][0] == "end")
    assert server.drags[-1][1:] == pytest.approx(end_px, abs=0.6)

    # One finger rests while the other one moves away from it.
    scale = server.view.pixels_per_screen_pixel
    tab.touch([CENTRE] * 4, [(CENTRE[0] + 100 * step, CENTRE[1]) for step in range(1, 5)])
    tab.wait_until_still()
    assert server.view.pixels_per_screen_pixel < 0.7 * scale
    assert len(server.clicks) == 1
    tab.touch([CENTRE])
    wait_for(lambda: len(server.clicks) == 2)
    assert server.clicks[1] == pytest.approx(CENTRE, abs=0.6)


def test_ten_clicks_are_ten_points_in_order_and_a_click_outside_is_none(server, open_page, wait_for):
    tab = open_page(server.url)
    pixels = [(100 + 50 * index, 600 - 7 * index) for index in range(10)]
    for count, pixel in enumerate(pixels, start=1):
        tab.click(*pixel)
        wait_for(lambda count=count: len(server.clicks) == count)
    assert np.abs(np.array(server.clicks) - pixels).max() <= 0.6
    assert len(server.callback_threads) == 1

    tab.click(200, -5)
    tab.click(200, SIZE.height + 5)
    tab.click(*pixels[0])
    wait_for(lambda: len(server.clicks) == 11)
    assert server.clicks[10] == server.clicks[0]


def test_a_handle_is_clicked_or_dragged_and_neither_adds_a_point(server, open_page, wait_for):
    tab = open_page(server.url)
    x, y = tab.mouse_position(*HANDLE)
    for count, (dx, dy) in enumerate(((0, 0), (11, 0), (-8, 8)), start=1):
        tab.page.mouse.click(x + dx, y + dy)
        wait_for(lambda count=count: len(server.handle_clicks) == count)
    assert server.clicks == []
    assert server.drags == []

    end_px = (523.0, 381.0)
    tab.drag(HANDLE, end_px)
    wait_for(lambda: bool(server.drags) and server.drags[-1][0] == "end")
    phases = [phase for phase, _, _ in server.drags]
    assert phases[0] == "start"
    assert set(phases[1:-1]) <= {"update"}
    x, y = tab.mouse_position(*end_px)
    left, top = tab.screen_position(*end_px)
    mouse_px = np.array(end_px) + (np.array([x, y]) + 0.5 - (left, top)) * server.view.pixels_per_screen_pixel
    assert server.drags[-1][1:] == pytest.approx(tuple(mouse_px), abs=0.01)
    assert server.handle is not None
    assert server.handle.position_px == server.drags[-1][1:]
    assert server.clicks == []
    assert len(server.handle_clicks) == 3


def test_the_wheel_zooms_to_the_mouse_and_the_picture_is_never_lost(server, open_page):
    tab = open_page(server.url, few_frames=False)
    here = (200.0, 600.0)
    before = tab.screen_position(*here)
    tab.wheel(*here, notches=5)
    zoom = 2**2.5  # of five notches; the middle of a mouse's pixel is half of one beside what stays in place
    assert tab.screen_position(*here) == pytest.approx(before, abs=zoom)

    for _ in range(8):  # far beyond the corner
        tab.page.mouse.move(300, 300)
        tab.page.mouse.down()
        tab.page.mouse.move(1350, 850, steps=3)
        tab.page.mouse.up()
    tab.wait_until_still()
    assert is_in_window(tab, CORNERS[0])

    tab.wheel(*CORNERS[0], notches=-30)
    assert all(is_in_window(tab, corner) for corner in CORNERS)
    tab.wheel(*CENTRE, notches=40)
    left, right = tab.screen_position(*CENTRE), tab.screen_position(CENTRE[0] + 1, CENTRE[1])
    assert right[0] - left[0] == pytest.approx(64, rel=0.01)


def test_a_fitted_picture_stays_fitted_when_the_window_changes(server, open_page, wait_for):
    tab = open_page(server.url)
    for width, height in ((900, 800), (1500, 600)):
        tab.page.set_viewport_size({"width": width, "height": height})
        wait_for(lambda width=width: tab.page.evaluate("window.innerWidth") == width)
        wait_for(lambda: fills_window(tab))
    assert len(server.view_changes) > 0

    server.view.zoom_to(*PATCH, pixels_across=100)
    tab.wait_until_still()
    scale = server.view.pixels_per_screen_pixel
    assert scale == pytest.approx(100 / 1500)
    tab.page.set_viewport_size({"width": 1300, "height": 600})
    tab.wait_until_still()
    assert server.view.pixels_per_screen_pixel == pytest.approx(scale)


def test_the_view_is_zoomed_panned_and_boxed(server, open_page):
    tab = open_page(server.url)
    here = tab.screen_position(*PATCH)
    scale = server.view.pixels_per_screen_pixel
    server.view.zoom(3, PATCH)
    tab.wait_until_still()
    assert tab.screen_position(*PATCH) == pytest.approx(here, abs=0.1)
    assert server.view.pixels_per_screen_pixel == pytest.approx(scale / 3)
    server.view.pan(30, -10)
    tab.wait_until_still()
    moved = np.subtract(tab.screen_position(*PATCH), here)
    assert moved == pytest.approx(np.array([-30, 10]) / (scale / 3), abs=0.1)

    server.view.fit()
    tab.wait_until_still()
    assert fills_window(tab)
    tab.page.keyboard.down("Shift")
    tab.drag((PATCH[0] - 60, PATCH[1] - 30), (PATCH[0] + 60, PATCH[1] + 30))
    tab.page.keyboard.up("Shift")
    tab.wait_until_still()
    left_px, _, right_px, _ = server.view.window_px
    assert (left_px, right_px) == pytest.approx((PATCH[0] - 60, PATCH[0] + 60), abs=1.5)
    assert server.clicks == []


def test_the_magnifier_shows_what_is_under_the_handle_that_is_dragged_or_clicked(server, open_page, wait_for):
    tab = open_page(server.url, drawn_at=0.25)
    tab.page.mouse.move(*tab.mouse_position(*HANDLE))
    tab.page.mouse.down()
    tab.page.mouse.move(*tab.mouse_position(*PATCH), steps=4)
    wait_for(lambda: count_of_patch_color(tab) > (8 * MAGNIFICATION) ** 2)
    tab.page.mouse.up()
    wait_for(lambda: count_of_patch_color(tab) < 20**2)

    tab.click(*PATCH)
    wait_for(lambda: count_of_patch_color(tab) > (8 * MAGNIFICATION) ** 2)
    x, y = tab.mouse_position(*PATCH)
    tab.page.mouse.click(x + 150, y + 30)  # on the glass
    wait_for(lambda: count_of_patch_color(tab) < 20**2)
    assert server.clicks == []


def test_the_glass_has_the_position_itself_under_its_cross():
    picture = np.zeros((100, 200, 3), np.uint8)
    picture[:, 80:] = 255  # an edge at column 79.5
    glass = magnified(picture, 79.5, 50)
    middle = glass.shape[0] // 2
    row = glass[middle + 5, :, 0].astype(float)
    assert row[middle - 5] == 0
    assert row[middle + 5] == 255
    assert row[middle] == pytest.approx(127.5, abs=8)
    assert glass[middle, middle, 3] == 255
    assert glass[0, 0, 3] == 0


def is_in_window(tab: BrowserPage, pixel: tuple[float, float]) -> bool:
    size = tab.page.viewport_size
    assert size is not None
    x, y = tab.screen_position(*pixel)
    return 0 <= x <= size["width"] and 0 <= y <= size["height"]


def fills_window(tab: BrowserPage) -> bool:
    size = tab.page.viewport_size
    assert size is not None
    (left, top), (right, bottom) = tab.screen_position(*CORNERS[0]), tab.screen_position(*CORNERS[3])
    filled = max((right - left) / size["width"], (bottom - top) / size["height"])
    return (
        0.95 < filled < 1 and abs(left + right - size["width"]) < 2 and abs(top + bottom - size["height"]) < 2
    )


def count_of_patch_color(tab: BrowserPage) -> int:
    tab.draw()  # during a drag the glass may be decoded after the last frame
    shot = cv2.imdecode(np.frombuffer(tab.page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    assert shot is not None
    return int((np.abs(shot.astype(int) - PATCH_RGB[::-1]).max(axis=2) < 12).sum())
