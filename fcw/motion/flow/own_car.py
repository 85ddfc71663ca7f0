"""Which of the picture is the own car: bonnet, dashboard, wipers, and what lies on them; sunshade and mirror.

It stands still in the picture while the rest moves, and it reaches the lower or the upper edge. Taken for the
road, it says that we stand, at any speed; taken for what is far, that we drive elsewhere. How far a cell has
moved between two pictures follows without any search from how its grey values changed, by the gradients that
they have (Horn & Schunck 1981); that is right up to about a pixel, and more than that is only known to be
more, which is enough.

The limits were set while looking at eight clips with a dashboard or bonnet in view and six without, eight of
them not of the project's data; none was left out. By their medians, cells of the own car were still in nine
looks of ten, and others of the lower half in none to two of ten, but for one clip that repeats its pictures
(eight of ten). On the six without one no cell was taken.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel
from fcw.motion.flow.corners import BLOCK_PX

LOOKED_S = 0.2
"""Time between two looks; more of them tell no more."""
MOVED_PX, STILL_PX = 0.6, 0.4
PLAIN = 4.0
"""Mean square of the gradient, in grey values a pixel, below which a cell shows nothing that could move."""
MOVING_PART = 0.25
"""The rest of the picture moves if so many of the cells do."""
STILL_PART = 0.8
FEWEST_LOOKS = 5.0
FORGOTTEN_S = 60.0
PLAIN_ROWS = 3
"""How many cells that show nothing may lie between the edge and the own car, and within it."""
BESIDE = 2
"""How far the own car reaches is the median over this many columns to either side."""
UPPER_PART = 1 / 3
"""Of the picture's height it reaches down no farther: what is far stands still, too."""
SOBEL_SCALE = 8
"""What Sobel's filter says is so many times the slope."""


@kernel()
def _mean_changes(
    last: NDArray[np.uint8],
    now: NDArray[np.uint8],
    cell_width: int,
    cell_height: int,
    means: NDArray[np.float64],
) -> None:  # pragma: no cover - compiled
    """Means over each cell of two pictures' change, of its square, and of the square of the first one's slope
    by Sobel's filter; `means` is (3, rows, columns). Cells that reach beyond the picture repeat its edge."""
    height, width = last.shape
    sums = np.empty((3, width), np.int32)  # of the pixels of a column of a row of cells
    for row in range(means.shape[1]):
        sums[:] = 0
        for y in range(row * cell_height, (row + 1) * cell_height):
            here = min(y, height - 1)
            above, below = abs(here - 1), here + 1 if here + 1 < height else height - 2  # mirrored
            for x in range(width):
                change = np.int32(now[here, x]) - np.int32(last[here, x])
                sums[0, x] += change
                sums[1, x] += change * change
            for x in range(1, width - 1):
                high, low = np.int32(last[above, x - 1]), np.int32(last[below, x - 1])
                high_after, low_after = np.int32(last[above, x + 1]), np.int32(last[below, x + 1])
                beside = np.int32(last[here, x + 1]) - np.int32(last[here, x - 1])
                under = np.int32(last[below, x]) - np.int32(last[above, x])
                across = high_after + low_after - high - low + 2 * beside
                down = low + low_after - high - high_after + 2 * under
                sums[2, x] += across * across + down * down
            for x, inner in ((0, 1), (width - 1, width - 2)):
                edge = np.int32(last[below, x]) - np.int32(last[above, x])
                down = 2 * (edge + np.int32(last[below, inner]) - np.int32(last[above, inner]))
                sums[2, x] += down * down
        for column in range(means.shape[2]):
            for kind in range(3):
                total = np.int64(0)
                for x in range(column * cell_width, (column + 1) * cell_width):
                    total += sums[kind, min(x, width - 1)]
                means[kind, row, column] = total / (cell_width * cell_height)


class OwnCar:
    """Learns the cells of the own car.

    Args:
        grey_shape: rows and columns of the small picture.
        cell_px: width and height of a cell, as of `fcw.motion.flow.corners.find_corners`.

    Attributes:
        cells: (cells,) which show the own car, by the numbers of the corners' cells.
        rest_moves: whether the rest of the picture moved at the latest look.
    """

    def __init__(self, grey_shape: tuple[int, ...], cell_px: tuple[int, int]) -> None:
        self._cell_px = cell_px
        blocks = grey_shape[0] // BLOCK_PX - 1, grey_shape[1] // BLOCK_PX - 1
        self._rows = -(-blocks[0] // (cell_px[1] // BLOCK_PX))
        self._columns = -(-blocks[1] // (cell_px[0] // BLOCK_PX))
        self._still = np.zeros((self._rows, self._columns))
        self._moved = np.zeros((self._rows, self._columns))
        self._looked_ns: int | None = None
        self.rest_moves = False
        self.cells = np.zeros(self._rows * self._columns, bool)

    def look(
        self,
        time_ns: int,
        last: NDArray[np.uint8],
        now: NDArray[np.uint8],
        others: Sequence[Box] = (),
    ) -> None:
        """Take two pictures that follow each other.

        Args:
            time_ns: of the second.
            last: (height, width) grey.
            now: likewise.
            others: where other vehicles are in them: one ahead of us at a constant gap stands as still.
        """
        since_s = 0.0 if self._looked_ns is None else (time_ns - self._looked_ns) / 1e9
        if self._looked_ns is not None and since_s < LOOKED_S:
            return
        self._looked_ns = time_ns
        moved_px, shows = self._motion(last, now)
        for box in others:
            width, height = self._cell_px
            rows = slice(max(int(box.y // height), 0), max(int(box.bottom // height) + 1, 0))
            shows[rows, max(int(box.x // width), 0) : max(int(box.right // width) + 1, 0)] = False
        self.rest_moves = self._part_moved(moved_px, shows) >= MOVING_PART
        if not self.rest_moves:
            return
        kept = np.exp(-since_s / FORGOTTEN_S)
        still = moved_px < STILL_PX
        self._still = kept * self._still + (shows & still)
        self._moved = kept * self._moved + (shows & ~still)
        self.cells = self._standing().ravel()

    def part_moved(self, ago: NDArray[np.uint8], now: NDArray[np.uint8]) -> float:
        """Part of the cells beside the own car that moved between two (height, width) grey pictures."""
        return self._part_moved(*self._motion(ago, now))

    def _part_moved(self, moved_px: FloatArray, shows: NDArray[np.bool_]) -> float:
        rest = shows & ~self.cells.reshape(shows.shape)
        return float((moved_px[rest] > MOVED_PX).mean()) if rest.any() else 0.0

    def _motion(
        self, last: NDArray[np.uint8], now: NDArray[np.uint8]
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """(rows, columns) how far each cell has moved, in pixels, and whether it shows anything."""
        changed, squared, slope = means = np.empty((3, self._rows, self._columns))
        _mean_changes(last, now, *self._cell_px, means)
        # Of any one direction half of the slopes' squares; a change of exposure moves nothing.
        slope /= 2 * SOBEL_SCALE**2
        change = np.maximum(squared - changed**2, 0.0)
        return np.sqrt(change / np.maximum(slope, 1e-6)), slope > PLAIN

    def _standing(self) -> NDArray[np.bool_]:
        """(rows, columns) which cells are of the own car: still ones, as far from an edge as they reach."""
        looks = self._still + self._moved
        known = looks >= FEWEST_LOOKS
        still = known & (self._still > STILL_PART * looks)
        rows = np.arange(self._rows)[:, None]
        above = np.minimum(self._reach(still, known), UPPER_PART * self._rows)
        return (rows < above) | (rows >= self._rows - self._reach(still[::-1], known[::-1]))

    def _reach(self, still: NDArray[np.bool_], known: NDArray[np.bool_]) -> FloatArray:
        """(columns,) how many rows the own car reaches from the first one on."""
        reach = np.zeros(self._columns)
        for column in range(self._columns):
            plain = 0
            for row in range(self._rows):
                if still[row, column]:
                    reach[column], plain = row + 1, 0
                elif known[row, column] or plain == PLAIN_ROWS:
                    break
                else:
                    plain += 1
        around = np.pad(reach, BESIDE, mode="edge")
        return np.median(np.lib.stride_tricks.sliding_window_view(around, 2 * BESIDE + 1), axis=1)
