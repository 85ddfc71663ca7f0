"""Which part of the picture shows our own car.

This is its bonnet, dashboard, wipers, objects on them, sunshade and mirror. It is stationary in the picture
while the rest moves, and it touches the lower or the upper edge. Taken as road, it would tell that we stand,
at any speed; taken as background, that we drive elsewhere. How far a cell has moved between two pictures
follows without a search from the change of its grey values and their gradients (Horn & Schunck 1981). This is
accurate up to about a pixel; a larger motion is only known to be larger, which is enough.

The limits were set while looking at eight clips with a dashboard or bonnet in view and six without, eight of
them not of the project's data; none was left out. By their medians, cells of our own car were still in nine
looks of ten, and other cells of the lower half in at most two of ten, except in one clip that repeats its
pictures (eight of ten). In the six without a bonnet, no cell was marked.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel
from fcw.motion.flow.corners import BLOCK_PX

LOOKED_S = 0.2
"""Time between two looks; more of them would tell nothing more."""
MOVED_PX, STILL_PX = 0.6, 0.4
"""A cell moved, or was still, if it moved by more or less than this."""
PLAIN = 4.0
"""Mean square of the gradient, in grey values per pixel, below which a cell has no texture that could
move."""
MOVING_PART = 0.25
"""The rest of the picture moves if at least this fraction of its cells does."""
STILL_PART = 0.8
"""A cell shows our own car if it was still in more than this fraction of the looks."""
FEWEST_LOOKS = 5.0
FORGOTTEN_S = 60.0
"""Time constant with which looks are forgotten."""
PLAIN_ROWS = 3
"""Largest number of cells without texture between the edge and our own car, and within it."""
BESIDE = 2
"""The extent of our own car is the median over this many columns to either side."""
UPPER_PART = 1 / 3
"""Largest extent from the upper edge, as a fraction of the height, because the far background is still,
too."""
SOBEL_SCALE = 8
"""Gain of Sobel's filter: its output over the gradient."""


@kernel()
def _mean_changes(
    last: NDArray[np.uint8],
    now: NDArray[np.uint8],
    cell_width: int,
    cell_height: int,
    means: NDArray[np.float64],
) -> None:  # pragma: no cover - compiled
    """Means over each cell of the change of two pictures, of its square, and of the squared Sobel gradient.

    `means` is (3, rows, columns). Cells that extend beyond the picture repeat its edge.
    """
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
    """Learns which cells show our own car.

    Args:
        grey_shape: rows and columns of the small picture.
        cell_px: width and height of a cell; see `fcw.motion.flow.corners.find_corners`.

    Attributes:
        cells: (cells,) which cells show our own car, by the indices of the corners' cells.
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
        """Update with two consecutive pictures.

        Args:
            time_ns: time of the second picture.
            last: (height, width) the first grey picture.
            now: (height, width) the second one.
            others: boxes of other vehicles, as one ahead at a constant gap is just as still.
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
        """Fraction of the cells apart from our own car that moved between two grey pictures."""
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
        # Half of the squared gradient is in any one direction. A change of exposure, the mean change, is no
        # motion.
        slope /= 2 * SOBEL_SCALE**2
        change = np.maximum(squared - changed**2, 0.0)
        return np.sqrt(change / np.maximum(slope, 1e-6)), slope > PLAIN

    def _standing(self) -> NDArray[np.bool_]:
        """(rows, columns) which cells show our own car: still ones that are connected to an edge."""
        looks = self._still + self._moved
        known = looks >= FEWEST_LOOKS
        still = known & (self._still > STILL_PART * looks)
        rows = np.arange(self._rows)[:, None]
        above = np.minimum(self._reach(still, known), UPPER_PART * self._rows)
        return (rows < above) | (rows >= self._rows - self._reach(still[::-1], known[::-1]))

    def _reach(self, still: NDArray[np.bool_], known: NDArray[np.bool_]) -> FloatArray:
        """(columns,) extent of our own car in rows, from the first row on."""
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
