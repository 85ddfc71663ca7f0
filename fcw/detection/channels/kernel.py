"""The compiled kernel of the channels: row by row, every stage a loop over full-width rows.

What is computed is defined in `fcw.detection.channels.aggregated`; here stands how. `channel_rows` goes down
the picture one pixel row a step, and each stage works on the row for which the one before has just made ready
what it looks at:

    row         stage                    looks at                     writes
    step        `luv_row`               one row of BGR pixels        luv         ring of 4 rows
    step - 1    `smooth_row`            luv, one row either side     smooth      ring of 4 rows
                `add_colours`           smooth                       sums[0..2]
    step - 2    `gradient_row`          smooth, one row either side  magnitudes, orientations: rings of 16
    step - 7    `vertical_triangle`     magnitudes, 5 either side    filtered
                `normalise`             filtered, 5 columns either side  normalised
                `add_orientations`      normalised, orientations     sums[4..9]
    each last   `cell_row`              sums of the cell's rows      cells       ring of 8 rows of cells
    row of a    `total_of_orientations` cells[4..9]                  cells[3]
    cell        `store_row`             cells, one row either side   out, as uint8, one row of cells later

Rings are indexed by the row's lowest bits, so that nothing is moved; 16 rows hold the 11 of the triangle
filter. Rows beyond the picture repeat its edge: by clamped indices down the columns, and along a row by the
elements next to its first and last. Only rows from `first` to `end` are made, with the few rows above and
below that their stages look at: the sky and the bonnet cost nothing.

Loops run over whole rows and hold no branch that the compiler cannot turn into a select, which makes them
SIMD code; tiles narrower than the picture were 2.3 times slower. Two more things matter as much. All scratch
comes from the caller, who uses it again for each picture, and each row of it starts where a cache line does
(`fcw.kernels.aligned`); of rows that are looked at beyond their ends, it is the `PAD`-th element that does.
And stages are given whole rings with the number of a row, not a view of the row: a view costs two atomic
counts of references, and there would be fifty for each row of the picture.

A numpy twin of it all, written for reading, stands in tests/detection/test_channels.py.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.channels.stages import (
    CELL_RING,
    LUV_RING,
    MAGNITUDE,
    MAGNITUDE_RING,
    TRIANGLE_REACH,
    add_colours,
    add_orientations,
    cell_row,
    gradient_row,
    luv_row,
    normalise,
    smooth_row,
    store_row,
    total_of_orientations,
    vertical_triangle,
)
from fcw.detection.model import CHANNEL_COUNT
from fcw.kernels.jit import kernel


@kernel()
def channel_rows(
    image: NDArray,
    first: int,
    end: int,
    cell_px: int,
    side: float,
    triangle: NDArray,
    constant: float,
    luv: NDArray,
    smooth: NDArray,
    magnitudes: NDArray,
    orientations: NDArray,
    normalised: NDArray,
    vertical: NDArray,
    filtered: NDArray,
    sums: NDArray,
    cells: NDArray,
    out: NDArray,
) -> None:
    """Rows first..end-1 of cells into `out`, streaming down the picture, each stage some rows behind.

    Args:
        image: (height, 3 * width or more) BGR.
        first: first row of cells wanted.
        end: one past the last.
        cell_px: side of a cell, 4 or 2.
        side: outer weights of the smoothing of the colours.
        triangle: (6,) weights of the normalisation's triangle filter from its middle outwards.
        constant: what is added to the filtered magnitude.
        luv: (LUV_RING, 3, padded width) scratch, as all up to `out`.
        smooth: (LUV_RING, 3, padded width).
        magnitudes: (MAGNITUDE_RING, width or more).
        orientations: (MAGNITUDE_RING, width or more).
        normalised: (width,).
        vertical: (1, 3 * padded width).
        filtered: (padded width,).
        sums: (10, padded width).
        cells: (CELL_RING, 10, padded columns).
        out: (end - first, columns, 10).
    """
    columns = out.shape[1]
    width, cell_rows = columns * cell_px, image.shape[0] // cell_px
    last_row, last_cell = cell_rows * cell_px - 1, cell_rows - 1
    # Pixel rows whose normalised gradients are wanted, and those each earlier stage needs for them.
    top, bottom = max(first - 1, 0) * cell_px, min(end + 1, cell_rows) * cell_px - 1
    magnitude_top = max(top - TRIANGLE_REACH, 0)
    magnitude_bottom = min(bottom + TRIANGLE_REACH, last_row)
    smooth_top, smooth_bottom = max(magnitude_top - 1, 0), min(magnitude_bottom + 1, last_row)
    luv_top, luv_bottom = max(smooth_top - 1, 0), min(smooth_bottom + 1, last_row)
    sums[:] = np.float32(0)
    # The colours of a row as one long row: fewer, longer loops.
    luv_rows, smooth_rows = luv.reshape(LUV_RING, -1), smooth.reshape(LUV_RING, -1)
    sum_row = sums.reshape(-1)

    for step in range(luv_top, bottom + TRIANGLE_REACH + 3):
        if step <= luv_bottom:
            luv_row(image, step, width, luv, step & 3)
        row = step - 1
        if smooth_top <= row <= smooth_bottom:
            above, below = max(row - 1, 0) & 3, min(row + 1, last_row) & 3
            smooth_row(luv_rows, above, row & 3, below, width, side, vertical, smooth_rows)
            if top <= row <= bottom:
                add_colours(smooth_rows, row & 3, sum_row)
                if row % cell_px == cell_px - 1:
                    slot = (row // cell_px) & (CELL_RING - 1)
                    cell_row(sums, 0, MAGNITUDE, columns, cell_px, cells, slot)
        row = step - 2
        if magnitude_top <= row <= magnitude_bottom:
            above, below = max(row - 1, 0) & 3, min(row + 1, last_row) & 3
            slot = row & (MAGNITUDE_RING - 1)
            gradient_row(smooth, above, row & 3, below, width, magnitudes, orientations, slot)
        row = step - 2 - TRIANGLE_REACH
        if top <= row <= bottom:
            slot = row & (MAGNITUDE_RING - 1)
            vertical_triangle(magnitudes, row, last_row, width, triangle, filtered)
            normalise(magnitudes, slot, filtered, width, triangle, constant, normalised)
            add_orientations(normalised, orientations, slot, width, sums)
            if row % cell_px == cell_px - 1:
                cell = row // cell_px
                slot = cell & (CELL_RING - 1)
                cell_row(sums, MAGNITUDE + 1, CHANNEL_COUNT, columns, cell_px, cells, slot)
                total_of_orientations(cells, slot, columns)
                if first <= cell - 1 < end:
                    store_row(cells, cell - 1, last_cell, cell_px, vertical, out, cell - 1 - first)
                if cell == last_cell and end == cell_rows:
                    store_row(cells, cell, last_cell, cell_px, vertical, out, cell - first)
