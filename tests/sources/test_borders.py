"""A frame around a picture is found to the pixel, whatever is in it; what a camera sees by itself is none."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from searching import examples

from fcw.sources.borders import Borders

Image = NDArray[np.uint8]
WIDTH, HEIGHT = 320, 180
BLOTCHES = np.random.default_rng(1).integers(0, 256, (2 * HEIGHT, 3 * WIDTH, 3), dtype=np.uint8)
SCENE = np.clip(5.0 * cv2.GaussianBlur(BLOTCHES, (0, 0), 2.0).astype(float) - 510, 0, 255).astype(np.uint8)


def views() -> list[Image]:
    """Of a camera that turns to the right."""
    return [SCENE[40 : 40 + HEIGHT, 90 * n : 90 * n + WIDTH].copy() for n in range(4)]


def of_one_colour(view: Image, beside: int, above: int, colour: int) -> Image:
    sides = ((above, above), (beside, beside), (0, 0))
    return np.pad(view, sides, constant_values=colour)


def blurred(view: Image, beside: int, above: int) -> Image:
    """The picture on a blurred copy of it that fills the frame, as editors for telephones do it."""
    behind = cv2.resize(view, (WIDTH + 2 * beside, HEIGHT + 2 * above))
    behind = cv2.GaussianBlur(behind, (0, 0), 25.0).astype(np.uint8) // 2
    behind[above : above + HEIGHT, beside : beside + WIDTH] = view
    return behind


def in_a_window(view: Image, beside: int, above: int) -> Image:
    """With buttons, which do not change."""
    shape = (HEIGHT + 2 * above, WIDTH + 2 * beside, 3)
    window = np.full(shape, 235, np.uint8)
    cv2.putText(window, "Play " * 20, (5, above // 2 + 5), cv2.FONT_HERSHEY_PLAIN, 1.0, (40, 40, 40), 1)
    for row in range(15, shape[0], 30):
        cv2.putText(window, "II", (2, row), cv2.FONT_HERSHEY_PLAIN, 1.0, (40, 40, 40), 1)
    window[above : above + HEIGHT, beside : beside + WIDTH] = view
    return window


def margins(images: list[Image]) -> list[int]:
    borders = Borders()
    for image in images:
        borders.see(image)
    return borders.margins.tolist()


@pytest.mark.parametrize("colour", [0, 255])
@pytest.mark.parametrize(("beside", "above"), [(60, 0), (0, 90), (40, 30), (0, 160)])
def test_a_frame_of_one_colour_is_found_to_the_pixel(beside: int, above: int, colour: int):
    images = [of_one_colour(view, beside, above, colour) for view in views()]
    assert margins(images) == [beside, beside, above, above]


@given(beside=st.integers(20, 150), above=st.integers(20, 150))
@examples(20)
def test_a_blurred_frame_is_found_to_the_pixel(beside: int, above: int):
    assert margins([blurred(view, beside, 0) for view in views()]) == [beside, beside, 0, 0]
    assert margins([blurred(view, 0, above) for view in views()]) == [0, 0, above, above]


def test_a_window_is_found_although_it_has_text():
    assert margins([in_a_window(view, 40, 40) for view in views()]) == [40, 40, 40, 40]


def test_what_is_full_of_detail_is_a_frame_only_if_the_picture_alone_changes():
    wall = np.random.default_rng(2).integers(0, 256, (HEIGHT + 80, WIDTH, 3), dtype=np.uint8)

    def on_the_wall(view: Image) -> Image:
        image = cv2.GaussianBlur(wall, (0, 0), 1.0).astype(np.uint8) // 4
        image[40 : 40 + HEIGHT] = view // 2 + 127
        return image

    assert margins([on_the_wall(view) for view in views()]) == [0, 0, 40, 40]
    assert margins([on_the_wall(views()[0])] * 4) == [0, 0, 0, 0]


def test_no_camera_sees_a_frame():
    assert margins(views()) == [0, 0, 0, 0]
    uneven = [np.pad(view, ((20, 50), (0, 0), (0, 0))) for view in views()]  # a visor, and a bonnet
    assert margins(uneven) == [0, 0, 0, 0]
    tilted = []
    for view in views():
        for corners in (
            [(0, 0), (WIDTH, 0), (WIDTH, 25), (0, 35)],
            [(0, 150), (WIDTH, 160), (WIDTH, 180), (0, 180)],
        ):
            cv2.fillPoly(view, [np.array(corners)], (10, 10, 10))
        tilted.append(view)
    assert margins(tilted) == [0, 0, 0, 0]


def test_what_is_there_for_a_while_is_no_frame():
    plain = views()
    framed = [of_one_colour(view[30:150, 40:280], 40, 30, 255) for view in plain]
    assert margins(framed) == [40, 40, 30, 30]
    assert margins([*framed[:3], plain[3]]) == [0, 0, 0, 0]


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (50, 1), (2, 300), (15, 16), (16, 16)])
def test_tiny_pictures_have_none(shape: tuple[int, int]):
    borders = Borders()
    for seed in range(3):
        borders.see(np.random.default_rng(seed).integers(0, 256, (*shape, 3), dtype=np.uint8))
    assert not borders.may_be
    assert not borders.margins.any()
