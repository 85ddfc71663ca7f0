"""Levels made of an octave's channels: OpenCV's arithmetic, in the rows that are wanted."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from fcw.detection.channels.resizing import Resizing, plan_resizings, resize_all

OCTAVE = 10, 41, 70
"""Channels, rows and columns that the levels are made of."""


def resized(
    octave: NDArray[np.uint8], sizes: list[tuple[int, int, int, int]], margin: int
) -> list[NDArray[np.uint8]]:
    """Levels from (first row, rows) of the octave to a size (rows, columns), but for rows at either end."""
    channels, octave_rows, octave_columns = octave.shape
    starts = octave.size + channels * np.cumsum([0, *(rows * columns for _, _, rows, columns in sizes)])
    cells = np.zeros(int(starts[-1]), np.uint8)
    cells[: octave.size] = octave.ravel()
    plans = [
        Resizing(
            source=first * octave_columns,
            source_channel_pitch=octave_rows * octave_columns,
            source_rows=cut_rows,
            source_columns=octave_columns,
            target=int(start),
            rows=rows,
            columns=columns,
            wanted=range(margin, rows - margin),
        )
        for start, (first, cut_rows, rows, columns) in zip(starts, sizes, strict=False)
    ]
    resize_all(cells, plan_resizings(plans))
    assert (cells[: octave.size] == octave.ravel()).all()
    return [
        cells[plan.target : plan.target + channels * plan.rows * plan.columns].reshape(
            channels, plan.rows, plan.columns
        )
        for plan in plans
    ]


SIZES = [(3, 32, 38, 83), (0, 41, 41, 59), (1, 40, 34, 50), (8, 33, 24, 49), (2, 5, 4, 99)]
"""Enlarged and reduced, one with rows that fill no group of four, as a detector's levels are."""


def test_levels_are_what_opencv_makes_of_all_channels_one_above_the_other():
    octave = np.random.default_rng(0).integers(0, 256, OCTAVE, np.uint8)
    for (first, cut_rows, rows, columns), level in zip(SIZES, resized(octave, SIZES, 1), strict=True):
        stacked = octave[:, first : first + cut_rows].reshape(-1, OCTAVE[2])
        expected = cv2.resize(stacked, (columns, 10 * rows), interpolation=cv2.INTER_LINEAR)
        expected = np.asarray(expected).reshape(10, rows, columns)[:, 1:-1]
        # OpenCV rounds otherwise on some processors.
        assert np.abs(level[:, 1:-1].astype(int) - expected).max() <= 1
        assert (level[:, 1:-1] != expected).mean() < 0.01
        assert not level[:, [0, -1]].any()


@pytest.mark.parametrize("size", SIZES)
def test_levels_are_bilinear_interpolation(size: tuple[int, int, int, int]):
    first, cut_rows, rows, columns = size
    octave = np.random.default_rng(1).integers(0, 256, OCTAVE, np.uint8)
    (level,) = resized(octave, [size], 1)
    y = (np.arange(rows) + 0.5) * cut_rows / rows - 0.5
    x = (np.arange(columns) + 0.5) * OCTAVE[2] / columns - 0.5
    for channel in range(10):
        cut = octave[channel, first : first + cut_rows].astype(float)
        expected = ndimage.map_coordinates(cut, np.meshgrid(y, x, indexing="ij"), order=1, mode="nearest")
        assert np.abs(level[channel, 1:-1] - expected[1:-1]).max() <= 1.2  # rounding, and parts of 1/2048


def test_no_levels_are_no_work():
    cells = np.arange(7, dtype=np.uint8)
    resize_all(cells, plan_resizings([]))
    assert cells.tolist() == list(range(7))
