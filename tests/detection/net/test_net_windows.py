"""What the net is shown, and how its offsets become boxes."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.net.windows import Pyramid, boxes_of, placements_on

SIDE_PX = 48


def test_a_window_shows_its_vehicle_where_the_cascade_expects_it():
    # A vehicle 120 px wide and 120 high, its bottom edge in row 299.5: sqrt(w h) is 120, so a unit is 3 px.
    picture = np.zeros((400, 600, 3), np.uint8)
    picture[180:300, 240:360] = 255
    (window,) = Pyramid(picture).windows(np.array([[299.5, 299.5, 120.0]]), SIDE_PX)
    assert window.shape == (SIDE_PX, SIDE_PX, 3)
    rows, columns = np.nonzero(window[..., 0] > 127)
    # 40 of 64 units in the middle, the bottom 52 units below the top, at 0.75 px a unit.
    assert (columns.min(), columns.max() + 1) == (9, 39)
    assert (rows.min(), rows.max() + 1) == (9, 39)


def test_beyond_the_picture_its_edge_is_repeated():
    picture = np.zeros((100, 100, 3), np.uint8)
    picture[:, 0] = 200
    (window,) = Pyramid(picture).windows(np.array([[0.0, 60.0, 40.0]]), SIDE_PX)
    assert np.all(window[:, :20] == 200)


@given(
    st.floats(-50, 700), st.floats(-50, 500), st.floats(8, 600), st.integers(20, 300), st.integers(20, 300)
)
def test_any_window_of_any_picture_can_be_cut(middle, bottom, size, width, height):
    pyramid = Pyramid(np.full((height, width, 3), 7, np.uint8))
    (window,) = pyramid.windows(np.array([[middle, bottom, size]]), SIDE_PX)
    assert np.all(window == 7)


def test_without_offsets_a_vehicle_is_as_large_as_its_window_expects():
    (box,) = boxes_of(np.array([[100.0, 200.0, 50.0]]), np.zeros((1, 4)))
    assert box.tolist() == [75.0, 150.0, 50.0, 50.0]


def test_offsets_are_in_sizes_and_logarithms():
    offsets = np.array([[0.1, -0.2, np.log(2.0), np.log(0.5)]])
    (box,) = boxes_of(np.array([[100.0, 200.0, 50.0]]), offsets)
    assert box.tolist() == pytest.approx([105.0 - 50.0, 190.0 - 25.0, 100.0, 25.0])


@given(st.floats(0, 700), st.floats(0, 500), st.floats(50, 200), st.floats(50, 200))
def test_a_window_on_a_box_expects_a_vehicle_of_its_size_and_place(x, y, w, h):
    (placement,) = placements_on(np.array([[x, y, w, h]]))
    (box,) = boxes_of(placement[None], np.log([[1.0, 1.0, w / placement[2], h / placement[2]]]))
    assert box.tolist() == pytest.approx([x, y, w, h], abs=1e-9)


@pytest.mark.parametrize("size", [(48, 64), (90, 160), (2, 2)])
def test_far_windows_are_cut_from_halves_that_opencv_would_make(size):
    picture = np.random.default_rng(0).integers(0, 256, (*size, 3)).astype(np.uint8)
    half = cv2.resize(picture, (size[1] // 2, size[0] // 2), interpolation=cv2.INTER_AREA)
    # Twice as many pixels a window as it is large: cut from the half, without a step between its pixels.
    placements = np.array([[size[1] / 2 - 0.5, size[0] / 2 - 0.5, 2.0 * 24 * 40 / 64]])
    expected = Pyramid(np.asarray(half, np.uint8)).windows(placements / 2 - [[0.25, 0.25, 0]], 24)
    assert np.abs(Pyramid(picture).windows(placements, 24).astype(int) - expected).max() <= 1
