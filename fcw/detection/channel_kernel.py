"""The compiled kernel of the channels: row by row, every stage a loop over full-width rows.

What is computed is defined in `fcw.detection.channels`; here stands how. `channel_rows` goes down the
picture one pixel row a step, and each stage works on the row for which the one before has just made ready
what it looks at:

    row         stage                    looks at                     writes
    step        `_luv_row`               one row of BGR pixels        luv         ring of 4 rows
    step - 1    `_smooth_row`            luv, one row either side     smooth      ring of 4 rows
                `_add`                   smooth                       sums[0..2], the colours
    step - 2    `_gradient_row`          smooth, one row either side  polar       ring of 16 rows
    step - 7    `_vertical_triangle`     magnitudes, 5 either side    padded
                `_normalise`             padded, 5 columns either side  normalised
                `_add`, `_add_orientations`                           sums[3], sums[4..9]
    each last   `_cell_row`              sums of the cell's rows      cells       ring of 8 rows of cells
    row of a    `_store_row`, one row    cells, one row either side   out, as uint8
    cell        of cells later

Rings are indexed by the row's lowest bits, so that nothing is moved; 16 rows hold the 11 of the triangle
filter. Rows beyond the picture repeat its edge: by clamped indices down the columns, and by one padded
element at either end along a row, which is why colours and cells have two columns more. Only rows from
`first` to `end` are made, with the few rows above and below that their stages look at: the sky and the
bonnet cost nothing.

Loops run over whole rows and hold no branch that the compiler cannot turn into a select, which makes them
SIMD code; tiles narrower than the picture were 2.3 times slower. All scratch comes from the caller and is
used again for each picture. A numpy twin of it all, written for reading, stands in
tests/detection/test_channels.py.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.jit import kernel
from fcw.detection.model import CHANNEL_COUNT

ORIENTATIONS = 6
TRIANGLE_REACH = 5
"""Largest radius of the normalisation's triangle filter."""

_f = np.float32
_ZERO, _HALF, _ONE, _TWO = _f(0), _f(0.5), _f(1), _f(2)

# RGB (0..255, gamma kept) -> X, Y and X + 15 Y + 3 Z, after the toolbox's matrix.

_TO_XYZ = np.array(
    [[0.430574, 0.341550, 0.178325], [0.222015, 0.706655, 0.071330], [0.020183, 0.129553, 0.939180]]
)
_TO_X, _TO_Y, _TO_TOTAL = (
    tuple(_f(w) for w in weights @ _TO_XYZ / 255) for weights in np.array([[1, 0, 0], [0, 1, 0], [1, 15, 3]])
)
_WHITE_U, _WHITE_V = _f(0.197833), _f(0.468331)
_LUV_SCALE = _f(1 / 270)
_GREY_U, _GREY_V = _f(88 / 270), _f(134 / 270)
_LINEAR_BELOW_Y, _LINEAR_SLOPE = _f((6 / 29) ** 3), _f((29 / 3) ** 3)
# First guess of a cube root on [(6/29)^3, 1], within 6 %; one step of Halley's method brings it to 1.4e-4.
_CUBE_ROOT = tuple(_f(c) for c in (0.18444633, 3.96746603, -12.07783064, 16.72822145, -7.8593116))
# atan(x) * 6 / pi on [0, 1], within 6e-5 of an orientation bin.
_ARCTAN = tuple(_f(c) for c in (1.90963647, -0.63139669, 0.34653786, -0.16647493, 0.04175589))
_TINY = _f(1e-20)

_QUARTER = _f(1 / 4)
_BINS, _HALF_TURN_BINS = _f(ORIENTATIONS), _f(ORIENTATIONS / 2)

_L_STEPS, _UV_STEPS, _GRADIENT_STEPS = _f(255 * 270 / 100), _f(510), _f(200)
_UV_OFFSET, _MAX = _f(112), _f(255)

# Rows kept of each stage while streaming down the picture; powers of two no smaller than what is looked at.
LUV_RING, MAGNITUDE_RING, CELL_RING = 4, 16, 8


@kernel()
def _luv_row(pixels: NDArray, lightness: NDArray, u: NDArray, v: NDArray) -> None:
    """Toolbox-scaled LUV of one row of BGR pixels into padded rows, edges repeated."""
    width = len(lightness) - 2
    light_row, u_row, v_row = lightness[1:-1], u[1:-1], v[1:-1]
    for i in range(width):
        blue, green, red = _f(pixels[3 * i]), _f(pixels[3 * i + 1]), _f(pixels[3 * i + 2])
        x = _TO_X[0] * red + _TO_X[1] * green + _TO_X[2] * blue
        y = _TO_Y[0] * red + _TO_Y[1] * green + _TO_Y[2] * blue
        total = _TO_TOTAL[0] * red + _TO_TOTAL[1] * green + _TO_TOTAL[2] * blue
        inverse = _ONE / (total + _TINY)
        root = _CUBE_ROOT[0] + y * (
            _CUBE_ROOT[1] + y * (_CUBE_ROOT[2] + y * (_CUBE_ROOT[3] + y * _CUBE_ROOT[4]))
        )
        cube = root * root * root
        root = root * (cube + _TWO * y) / (_TWO * cube + y)
        curved, straight = _f(116) * root - _f(16), _LINEAR_SLOPE * y
        light = (curved if y > _LINEAR_BELOW_Y else straight) * _LUV_SCALE
        light_row[i] = light
        u_row[i] = light * (_f(52) * x * inverse - _f(13) * _WHITE_U) + _GREY_U
        v_row[i] = light * (_f(117) * y * inverse - _f(13) * _WHITE_V) + _GREY_V
    for row in (lightness, u, v):
        row[0] = row[1]
        row[width + 1] = row[width]


@kernel()
def _smooth_row(
    above: NDArray, here: NDArray, below: NDArray, side: float, vertical: NDArray, out: NDArray
) -> None:
    """[side, 1 - 2 side, side] both ways over three padded rows; `out` is padded again."""
    width = len(out) - 2
    middle = _ONE - _TWO * side
    for x in range(width + 2):
        vertical[x] = side * (above[x] + below[x]) + middle * here[x]
    for x in range(1, width + 1):
        out[x] = side * (vertical[x - 1] + vertical[x + 1]) + middle * vertical[x]
    out[0] = out[1]
    out[width + 1] = out[width]


@kernel()
def _add(values: NDArray, total: NDArray) -> None:
    for x in range(len(total)):
        total[x] += values[x]


@kernel()
def _gradient_row(
    above: NDArray, here: NDArray, below: NDArray, magnitude: NDArray, orientation: NDArray
) -> None:
    """Magnitude and orientation (in bins, [0, 6)) of the longest of three channels' gradients."""
    above0, above1, above2 = above[0], above[1], above[2]
    here0, here1, here2 = here[0], here[1], here[2]
    below0, below1, below2 = below[0], below[1], below[2]
    for x in range(len(magnitude)):
        # Twice the gradients.
        gx, gy = here0[x + 2] - here0[x], below0[x + 1] - above0[x + 1]
        gx1, gy1 = here1[x + 2] - here1[x], below1[x + 1] - above1[x + 1]
        gx2, gy2 = here2[x + 2] - here2[x], below2[x + 1] - above2[x + 1]
        length, length1, length2 = gx * gx + gy * gy, gx1 * gx1 + gy1 * gy1, gx2 * gx2 + gy2 * gy2
        longer = length1 > length
        gx, gy, length = gx1 if longer else gx, gy1 if longer else gy, length1 if longer else length
        longer = length2 > length
        gx, gy, length = gx2 if longer else gx, gy2 if longer else gy, length2 if longer else length
        magnitude[x] = np.sqrt(length) * _HALF
        ax, ay = abs(gx), abs(gy)
        ratio = min(ax, ay) / (max(ax, ay) + _TINY)
        square = ratio * ratio
        angle = ratio * (
            _ARCTAN[0]
            + square * (_ARCTAN[1] + square * (_ARCTAN[2] + square * (_ARCTAN[3] + square * _ARCTAN[4])))
        )
        angle = _HALF_TURN_BINS - angle if ay > ax else angle
        orientation[x] = _BINS - angle if gx * gy < _ZERO else angle


@kernel()
def _vertical_triangle(ring: NDArray, row: int, last: int, weights: NDArray, out: NDArray) -> None:
    """Triangle filter down the columns of the magnitudes; rows beyond 0..last repeat the edge."""
    mask = MAGNITUDE_RING - 1
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    a0 = ring[row & mask]
    a1, b1 = ring[max(row - 1, 0) & mask], ring[min(row + 1, last) & mask]
    a2, b2 = ring[max(row - 2, 0) & mask], ring[min(row + 2, last) & mask]
    a3, b3 = ring[max(row - 3, 0) & mask], ring[min(row + 3, last) & mask]
    a4, b4 = ring[max(row - 4, 0) & mask], ring[min(row + 4, last) & mask]
    a5, b5 = ring[max(row - 5, 0) & mask], ring[min(row + 5, last) & mask]
    padded = out[TRIANGLE_REACH:-TRIANGLE_REACH]
    for x in range(len(padded)):
        padded[x] = (
            w0 * a0[x]
            + w1 * (a1[x] + b1[x])
            + w2 * (a2[x] + b2[x])
            + w3 * (a3[x] + b3[x])
            + w4 * (a4[x] + b4[x])
            + w5 * (a5[x] + b5[x])
        )
    for i in range(TRIANGLE_REACH):
        out[i] = padded[0]
        out[-1 - i] = padded[-1]


@kernel()
def _normalise(magnitude: NDArray, s: NDArray, weights: NDArray, constant: float, out: NDArray) -> None:
    """Magnitude over its neighbourhood's: `s` is filtered down the columns, here along the row."""
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for x in range(len(out)):
        mean = (
            w0 * s[x + 5]
            + w1 * (s[x + 4] + s[x + 6])
            + w2 * (s[x + 3] + s[x + 7])
            + w3 * (s[x + 2] + s[x + 8])
            + w4 * (s[x + 1] + s[x + 9])
            + w5 * (s[x] + s[x + 10])
        )
        out[x] = magnitude[x] / (mean + constant)


@kernel()
def _add_orientations(magnitude: NDArray, orientation: NDArray, sums: NDArray) -> None:
    """Each pixel's magnitude, shared between its two nearest orientations, onto the column sums."""
    for k in range(ORIENTATIONS):
        centre = _f(k)
        total = sums[k]
        for x in range(len(magnitude)):
            away = abs(orientation[x] - centre)
            away = min(away, _BINS - away)
            total[x] += magnitude[x] * max(_ONE - away, _ZERO)


@kernel()
def _cell_row(sums: NDArray, cell_px: int, out: NDArray) -> None:
    """Sums of four (or two) columns each into a padded row of cells, and the sums back to zero."""
    cells = len(out) - 2
    if cell_px == 4:
        for c in range(cells):
            out[c + 1] = sums[4 * c] + sums[4 * c + 1] + sums[4 * c + 2] + sums[4 * c + 3]
    else:
        for c in range(cells):
            out[c + 1] = sums[2 * c] + sums[2 * c + 1]
    out[0] = out[1]
    out[cells + 1] = out[cells]
    sums[:] = _ZERO


@kernel()
def _store_row(
    ring: NDArray, row: int, last: int, cell_px: int, smooth: NDArray, vertical: NDArray, out: NDArray
) -> None:
    """Smooth one row of cells of every channel and store it as uint8 in out (columns, 10)."""
    part = _ONE / _f(cell_px * cell_px)
    mask = CELL_RING - 1
    above, here, below = ring[max(row - 1, 0) & mask], ring[row & mask], ring[min(row + 1, last) & mask]
    for k in range(CHANNEL_COUNT):
        _smooth_row(above[k], here[k], below[k], _QUARTER, vertical, smooth)
        cells = out[:, k]
        # Sums over a cell's pixels become means here.
        if k == 0:
            for x in range(len(cells)):
                cells[x] = np.uint8(min(_L_STEPS * part * smooth[x + 1] + _HALF, _MAX))
        elif k < 3:
            grey = _GREY_U if k == 1 else _GREY_V
            for x in range(len(cells)):
                value = _UV_OFFSET + _UV_STEPS * (part * smooth[x + 1] - grey)
                cells[x] = np.uint8(min(max(value + _HALF, _ZERO), _MAX))
        else:
            for x in range(len(cells)):
                cells[x] = np.uint8(min(_GRADIENT_STEPS * np.sqrt(part * smooth[x + 1]) + _HALF, _MAX))


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
    polar: NDArray,
    normalised: NDArray,
    padded: NDArray,
    sums: NDArray,
    cells: NDArray,
    out: NDArray,
) -> None:
    """Rows first..end-1 of cells into `out`, streaming down the picture, each stage some rows behind.

    Args:
        image: (height, width, 3) BGR.
        first: first row of cells wanted.
        end: one past the last.
        cell_px: side of a cell, 4 or 2.
        side: outer weights of the smoothing of the colours.
        triangle: (6,) weights of the normalisation's triangle filter from its middle outwards.
        constant: what is added to the filtered magnitude.
        luv: (LUV_RING, 3, width + 2) scratch, as all up to `out`.
        smooth: (LUV_RING, 3, width + 2).
        polar: (2, MAGNITUDE_RING, width), magnitude and orientation.
        normalised: (width,).
        padded: (3, width + 2 * TRIANGLE_REACH).
        sums: (10, width).
        cells: (CELL_RING, 10, columns + 2).
        out: (end - first, columns, 10).
    """
    columns = out.shape[1]
    width = columns * cell_px
    cell_rows = image.shape[0] // cell_px
    last_row, last_cell = cell_rows * cell_px - 1, cell_rows - 1
    # Pixel rows whose normalised gradients are wanted, and those each earlier stage needs for them.
    top, bottom = max(first - 1, 0) * cell_px, min(end + 1, cell_rows) * cell_px - 1
    magnitude_top = max(top - TRIANGLE_REACH, 0)
    magnitude_bottom = min(bottom + TRIANGLE_REACH, last_row)
    smooth_top, smooth_bottom = max(magnitude_top - 1, 0), min(magnitude_bottom + 1, last_row)
    luv_top, luv_bottom = max(smooth_top - 1, 0), min(smooth_bottom + 1, last_row)
    vertical, filtered = padded[0, : width + 2], padded[1]
    cell_smooth = padded[2, : columns + 2]
    sums[:] = _ZERO

    for step in range(luv_top, bottom + TRIANGLE_REACH + 3):
        if step <= luv_bottom:
            _luv_row(image[step].reshape(-1), luv[step & 3, 0], luv[step & 3, 1], luv[step & 3, 2])
        row = step - 1
        if smooth_top <= row <= smooth_bottom:
            above, here, below = luv[max(row - 1, 0) & 3], luv[row & 3], luv[min(row + 1, last_row) & 3]
            for k in range(3):
                _smooth_row(above[k], here[k], below[k], side, vertical, smooth[row & 3, k])
            if top <= row <= bottom:
                for k in range(3):
                    _add(smooth[row & 3, k, 1:-1], sums[k])
                if row % cell_px == cell_px - 1:
                    for k in range(3):
                        _cell_row(sums[k], cell_px, cells[(row // cell_px) & (CELL_RING - 1)][k])
        row = step - 2
        if magnitude_top <= row <= magnitude_bottom:
            above, here, below = (
                smooth[max(row - 1, 0) & 3],
                smooth[row & 3],
                smooth[min(row + 1, last_row) & 3],
            )
            slot = row & (MAGNITUDE_RING - 1)
            _gradient_row(above, here, below, polar[0, slot], polar[1, slot])
        row = step - 2 - TRIANGLE_REACH
        if top <= row <= bottom:
            slot = row & (MAGNITUDE_RING - 1)
            _vertical_triangle(polar[0], row, last_row, triangle, filtered)
            _normalise(polar[0, slot], filtered, triangle, constant, normalised)
            _add(normalised, sums[3])
            _add_orientations(normalised, polar[1, slot], sums[4:])
            if row % cell_px == cell_px - 1:
                cell = row // cell_px
                for k in range(3, CHANNEL_COUNT):
                    _cell_row(sums[k], cell_px, cells[cell & (CELL_RING - 1)][k])
                if first <= cell - 1 < end:
                    _store_row(
                        cells, cell - 1, last_cell, cell_px, cell_smooth, vertical, out[cell - 1 - first]
                    )
                if cell == last_cell and end == cell_rows:
                    _store_row(cells, cell, last_cell, cell_px, cell_smooth, vertical, out[cell - first])
