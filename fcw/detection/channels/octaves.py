"""A picture's channels octave by octave, and the smaller pictures that they are computed of."""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.detection.channels.aggregated import COARSE, CONTEXT_PX, FINE, ChannelComputer
from fcw.detection.channels.halving import halve_rows
from fcw.detection.model import CELL_PX, CHANNEL_COUNT
from fcw.detection.windows.plan import PAD_CELLS, Level
from fcw.frame import ImageSize
from fcw.kernels.aligned import aligned_zeros
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel, rows_of_bytes


class Octave:
    """One octave's channels in the rows that its levels need, edges repeated beyond the picture.

    Attributes:
        picture_rows: rows of the picture that the channels depend on.
        first_row: the octave's row of cells that is the grid's first; negative above the picture.
        rows: rows of the grid.
        columns: columns of the grid, `PAD_CELLS` beyond the picture on both sides.
        first_inside: first row of the grid that lies in the picture.
        end_inside: one past the last such row.
        grid: (10, rows, columns), once it has memory.
    """

    grid: NDArray[np.uint8]

    def __init__(self, size: ImageSize, number: int, levels: list[Level]) -> None:
        """`size` is that of the picture the channels are computed of."""
        settings = FINE if number > 0 else COARSE
        first_cut = min(level.first_cut for level in levels)
        end_cut = max(level.first_cut + level.cut_rows for level in levels)
        first, end = max(first_cut, 0), min(end_cut, size.height // settings.cell_px)
        context = math.ceil(CONTEXT_PX / CELL_PX)
        first_cell, end_cell = max(first - context, 0), min(end + context, size.height // settings.cell_px)
        self.picture_rows = slice(first_cell * settings.cell_px, end_cell * settings.cell_px)
        height = self.picture_rows.stop - self.picture_rows.start
        self._computer = ChannelComputer(ImageSize(size.width, height), settings)
        self._wanted = first - first_cell, end - first_cell
        self.first_row = first_cut
        self.rows, self.columns = end_cut - first_cut, self._computer.columns + 2 * PAD_CELLS
        self.first_inside, self.end_inside = first - first_cut, end - first_cut

    def use(self, memory: NDArray[np.uint8]) -> None:
        """Keep the grid in this memory, of 10 * rows * columns bytes."""
        self.grid = memory.reshape(CHANNEL_COUNT, self.rows, self.columns)
        self._inside = self.grid[:, self.first_inside : self.end_inside, PAD_CELLS:-PAD_CELLS]

    def compute(self, picture_rows: NDArray[np.uint8]) -> None:
        """Fill the part inside the picture from the rows asked for."""
        self._computer.compute(picture_rows, *self._wanted, out=self._inside)


@kernel()
def repeat_edges(grids: NDArray[np.uint8], octaves: NDArray[np.int64], pad: int) -> None:
    """Repeat the outermost cells beyond the picture.

    Args:
        grids: memory of all octaves.
        octaves: (N, 5), for each octave the place of its first cell, rows, columns, and first and end row
            inside the picture.
        pad: columns outside on either side.
    """
    for first_cell, rows, columns, first, end in octaves:
        for channel in range(CHANNEL_COUNT):
            start = first_cell + channel * rows * columns
            for row in range(first, end):
                cells = grids[start + row * columns : start + (row + 1) * columns]
                for x in range(pad):
                    cells[x] = cells[pad]
                    cells[columns - 1 - x] = cells[columns - 1 - pad]
            for row in range(first):
                _copy(grids, start + first * columns, start + row * columns, columns)
            for row in range(end, rows):
                _copy(grids, start + (end - 1) * columns, start + row * columns, columns)


@inner_kernel()
def _copy(grids: NDArray[np.uint8], source: int, target: int, count: int) -> None:
    for x in range(count):
        grids[target + x] = grids[source + x]


class Halves:
    """The picture at 1/2, 1/4, ... of its size, each in the rows needed of it and of the next."""

    def __init__(self, size: ImageSize, octaves: dict[int, Octave]) -> None:
        self._first_rows = {0: 0}
        self._reduced: dict[int, NDArray[np.uint8]] = {}
        needed = None
        for number in range(min(octaves, default=0), 0):
            wanted = [needed] if needed else []
            wanted += [octaves[number].picture_rows] if number in octaves else []
            rows = slice(min(r.start for r in wanted), max(r.stop for r in wanted))
            self._first_rows[number] = rows.start
            self._reduced[number] = np.empty((rows.stop - rows.start, size.width >> -number, 3), np.uint8)
            needed = slice(2 * rows.start, 2 * rows.stop)
        self._sums = aligned_zeros((3 * size.width,), np.uint16)

    def compute(self, image: NDArray[np.uint8]) -> None:
        """Fill them from a picture."""
        source = image
        for number in sorted(self._reduced, reverse=True):
            first = 2 * self._first_rows[number] - self._first_rows[number + 1]
            reduced = self._reduced[number]
            halve_rows(rows_of_bytes(source), first, self._sums, reduced.reshape(len(reduced), -1))
            source = reduced

    def rows(self, image: NDArray[np.uint8], number: int, rows: slice) -> NDArray[np.uint8]:
        """Rows of the picture at an octave; above the picture's own scale, of the picture itself."""
        if number >= 0:
            return image[rows]
        first = self._first_rows[number]
        return self._reduced[number][rows.start - first : rows.stop - first]
