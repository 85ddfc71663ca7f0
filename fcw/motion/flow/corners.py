"""Corners of a grey picture: in each cell of a grid, the point that can be tracked best.

The measure is that of Shi & Tomasi (1994), "Good features to track": the smaller eigenvalue of the gradient's
second moments in a window, here of 8x8 pixels on a grid of 4. A finer grid is not needed, as points anywhere
can be tracked. A picture of 640x360 takes a fifth of a millisecond.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.jit import kernel, rows_of_bytes

BLOCK_PX = 4
WINDOW_SAMPLES = 2 * BLOCK_PX * BLOCK_PX
"""Number of gradients summed in a window of 2x2 blocks."""


@kernel()
def _moments(grey: NDArray[np.uint8], moments: NDArray[np.float32]) -> None:  # pragma: no cover - compiled
    """Sums of gx^2, gy^2 and gx gy in blocks of 4x4, over every second row; `moments` is (3, rows, cols)."""
    height, width = grey.shape
    xx, yy, xy = np.zeros(width, np.int32), np.zeros(width, np.int32), np.zeros(width, np.int32)
    for row in range(moments.shape[1]):
        y = row * BLOCK_PX + 1
        below = min(y + 3, height - 1)
        for x in range(1, width - 1):
            gx = np.int32(grey[y, x + 1]) - np.int32(grey[y, x - 1])
            gy = np.int32(grey[y + 1, x]) - np.int32(grey[y - 1, x])
            hx = np.int32(grey[y + 2, x + 1]) - np.int32(grey[y + 2, x - 1])
            hy = np.int32(grey[below, x]) - np.int32(grey[y + 1, x])
            xx[x], yy[x], xy[x] = gx * gx + hx * hx, gy * gy + hy * hy, gx * gy + hx * hy
        for column in range(moments.shape[2]):
            x = column * BLOCK_PX
            moments[0, row, column] = xx[x] + xx[x + 1] + xx[x + 2] + xx[x + 3]
            moments[1, row, column] = yy[x] + yy[x + 1] + yy[x + 2] + yy[x + 3]
            moments[2, row, column] = xy[x] + xy[x + 1] + xy[x + 2] + xy[x + 3]


@kernel()
def _best_of_cells(
    moments: NDArray[np.float32], cell_rows: int, cell_columns: int, found: NDArray[np.float32]
) -> None:  # pragma: no cover - compiled
    """(cells, 6): block column, block row, score and second moments of the best 2x2 blocks in each cell."""
    rows, columns = moments.shape[1] - 1, moments.shape[2] - 1
    across = -(-columns // cell_columns)
    found[:, 2] = -1.0
    sums, scores = np.empty((3, columns), np.float32), np.empty(columns, np.float32)
    for row in range(rows):
        for column in range(columns):
            for kind in range(3):
                sums[kind, column] = (
                    moments[kind, row, column]
                    + moments[kind, row, column + 1]
                    + moments[kind, row + 1, column]
                    + moments[kind, row + 1, column + 1]
                )
        for column in range(columns):
            xx, yy, xy = sums[0, column], sums[1, column], sums[2, column]
            apart = xx - yy
            root = np.sqrt(apart * apart + np.float32(4.0) * xy * xy)
            scores[column] = (xx + yy - root) * np.float32(0.5)
        for place in range(across):
            cell = (row // cell_rows) * across + place
            best, at = found[cell, 2], -1
            for column in range(place * cell_columns, min((place + 1) * cell_columns, columns)):
                if scores[column] > best:
                    best, at = scores[column], column
            if at >= 0:
                found[cell, 0], found[cell, 1], found[cell, 2] = at, row, best
                found[cell, 3], found[cell, 4], found[cell, 5] = sums[0, at], sums[1, at], sums[2, at]


@kernel()
def _shrink(
    rows: NDArray[np.uint8], factor: int, small: NDArray[np.uint8]
) -> None:  # pragma: no cover - compiled
    height, width = small.shape
    part = 1.0 / (factor * factor)
    # All colours are summed, as adding contiguous bytes is faster than picking every third one.
    sums, totals = np.empty(3 * width * factor, np.uint16), np.empty(width, np.uint32)
    for y in range(height):
        sums[:] = 0
        for row in range(y * factor, (y + 1) * factor):
            for place in range(len(sums)):
                sums[place] += np.uint16(rows[row, place])
        totals[:] = 0
        for column in range(factor):
            greens = sums[3 * column + 1 :: 3 * factor]
            for x in range(width):
                totals[x] += greens[x]
        for x in range(width):
            small[y, x] = np.uint8((totals[x] + 0.5) * part)  # rounded down, without a division


@kernel()
def _halve(rows: NDArray[np.uint8], small: NDArray[np.uint8]) -> None:  # pragma: no cover - compiled
    height, width = small.shape
    for y in range(height):
        for x in range(width):
            small[y, x] = (
                np.uint16(rows[2 * y, 6 * x + 1])
                + np.uint16(rows[2 * y, 6 * x + 4])
                + np.uint16(rows[2 * y + 1, 6 * x + 1])
                + np.uint16(rows[2 * y + 1, 6 * x + 4])
            ) >> 2


def small_grey(image: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """A grey picture reduced by a whole factor: means of the green values, which are the sharpest.

    Args:
        image: (height, width, 3) BGR.
        factor: at least 1.
    """
    if factor == 1:
        return np.ascontiguousarray(image[:, :, 1])
    small = np.empty((image.shape[0] // factor, image.shape[1] // factor), np.uint8)
    if factor == 2:
        _halve(rows_of_bytes(image), small)
    else:
        _shrink(rows_of_bytes(image), factor, small)
    return small


class Corners(NamedTuple):
    """The best corner of each cell of a grid. A cell has the same index in all pictures of one size.

    Attributes:
        places: (cells, 2) columns and rows.
        scores: (cells,) smaller eigenvalue, as a mean square of differences of grey values over two pixels.
        information: (cells, 3) sums of gx^2, gy^2 and gx gy over the window, with gradients in grey values
            per pixel. Divided by the variance of a grey value, they are the inverse covariance of the
            position.
    """

    places: NDArray[np.float32]
    scores: NDArray[np.float32]
    information: NDArray[np.float64]

    @property
    def contrast(self) -> NDArray[np.float64]:
        """(cells,) root mean square of the gradient in the window, in grey values per pixel."""
        return np.sqrt((self.information[:, 0] + self.information[:, 1]) / (2 * WINDOW_SAMPLES))

    @property
    def roundness(self) -> NDArray[np.float64]:
        """(cells,) smaller eigenvalue over the larger: 0 on an edge, 1 if all directions are alike."""
        xx, yy, xy = self.information.T
        both, apart = xx + yy, np.hypot(xx - yy, 2 * xy)
        return (both - apart) / np.maximum(both + apart, 1e-9)


def find_corners(grey: NDArray[np.uint8], cell_px: tuple[int, int]) -> Corners:
    """The best corner of each cell.

    Args:
        grey: (height, width), at least 8 pixels either way.
        cell_px: width and height of a cell, multiples of 4.
    """
    height, width = grey.shape
    rows, columns = height // BLOCK_PX, width // BLOCK_PX
    moments = np.empty((3, rows, columns), np.float32)
    _moments(grey, moments)
    cell_columns, cell_rows = cell_px[0] // BLOCK_PX, cell_px[1] // BLOCK_PX
    cells = -(-(rows - 1) // cell_rows) * -(-(columns - 1) // cell_columns)
    found = np.empty((cells, 6), np.float32)
    _best_of_cells(moments, cell_rows, cell_columns, found)
    places = found[:, :2] * BLOCK_PX + (BLOCK_PX - 0.5)  # the middle of 2x2 blocks
    # Differences over two pixels are twice the gradient, and half of the rows were summed.
    return Corners(places, found[:, 2] / np.float32(WINDOW_SAMPLES), found[:, 3:].astype(np.float64) / 2)
