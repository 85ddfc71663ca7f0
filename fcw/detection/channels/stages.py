"""The stages of the channels, each a loop over one row: `channels.kernel` calls them in turn."""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import CHANNEL_COUNT
from fcw.kernels.inner import inner_kernel

MAGNITUDE = 3
"""Its channel; the colours are before it, its parts in the orientations behind."""
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

# Stored steps: of L, u and v; of the gradients' square roots.
_COLOUR_STEPS = (_f(255 * 270 / 100), _f(510), _f(510))
_COLOUR_OFFSETS = (_ZERO, _f(112) - _f(510) * _GREY_U, _f(112) - _f(510) * _GREY_V)
_GRADIENT_STEPS, _MAX = _f(200), _f(255)

PAD = 16
"""Elements before a row's first, which so starts a cache line as the whole does, and after its last."""
# Rows kept of each stage while streaming down the picture; powers of two no smaller than what is looked at.
LUV_RING, MAGNITUDE_RING, CELL_RING = 4, 16, 8


@inner_kernel(no_alias=True)
def luv_row(image: NDArray, row: int, width: int, luv: NDArray, slot: int) -> None:
    """Toolbox-scaled LUV of one row of BGR pixels."""
    for i in range(width):
        blue, green, red = _f(image[row, 3 * i]), _f(image[row, 3 * i + 1]), _f(image[row, 3 * i + 2])
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
        luv[slot, 0, PAD + i] = light
        luv[slot, 1, PAD + i] = light * (_f(52) * x * inverse - _f(13) * _WHITE_U) + _GREY_U
        luv[slot, 2, PAD + i] = light * (_f(117) * y * inverse - _f(13) * _WHITE_V) + _GREY_V


@inner_kernel(no_alias=True)
def smooth_row(
    luv: NDArray,
    above: int,
    here: int,
    below: int,
    width: int,
    side: float,
    vertical: NDArray,
    smooth: NDArray,
) -> None:
    """[side, 1 - 2 side, side] both ways over three rows, into the row `here`, padded again."""
    middle, pitch = _ONE - _TWO * side, luv.shape[1] // 3
    for x in range(3 * pitch):
        vertical[0, x] = side * (luv[above, x] + luv[below, x]) + middle * luv[here, x]
    _repeat_edges(vertical, 0, pitch, width)
    for i in range(3 * pitch - 2 * PAD):
        x = PAD + i
        smooth[here, x] = side * (vertical[0, x - 1] + vertical[0, x + 1]) + middle * vertical[0, x]
    _repeat_edges(smooth, here, pitch, width)


@inner_kernel(no_alias=True)
def _repeat_edges(rows: NDArray, slot: int, pitch: int, width: int) -> None:
    """Beside the first and last element of each of three colours."""
    for k in range(3):
        first, last = k * pitch + PAD, k * pitch + PAD + width - 1
        rows[slot, first - 1], rows[slot, last + 1] = rows[slot, first], rows[slot, last]


@inner_kernel(no_alias=True)
def add_colours(smooth: NDArray, slot: int, sums: NDArray) -> None:
    """Smoothed colours onto the column sums, all three as one long row."""
    for x in range(smooth.shape[1]):
        sums[x] += smooth[slot, x]


@inner_kernel(no_alias=True)
def gradient_row(
    smooth: NDArray,
    above: int,
    here: int,
    below: int,
    width: int,
    magnitudes: NDArray,
    orientations: NDArray,
    slot: int,
) -> None:
    """Magnitude and orientation (in bins, [0, 6)) of the longest of three channels' gradients."""
    for x in range(width):
        at = PAD + x
        # Twice the gradients.
        gx, gy = (
            smooth[here, 0, at + 1] - smooth[here, 0, at - 1],
            smooth[below, 0, at] - smooth[above, 0, at],
        )
        gx1, gy1 = (
            smooth[here, 1, at + 1] - smooth[here, 1, at - 1],
            smooth[below, 1, at] - smooth[above, 1, at],
        )
        gx2, gy2 = (
            smooth[here, 2, at + 1] - smooth[here, 2, at - 1],
            smooth[below, 2, at] - smooth[above, 2, at],
        )
        length, length1, length2 = gx * gx + gy * gy, gx1 * gx1 + gy1 * gy1, gx2 * gx2 + gy2 * gy2
        longer = length1 > length
        gx, gy, length = gx1 if longer else gx, gy1 if longer else gy, length1 if longer else length
        longer = length2 > length
        gx, gy, length = gx2 if longer else gx, gy2 if longer else gy, length2 if longer else length
        magnitudes[slot, x] = np.sqrt(length) * _HALF
        ax, ay = abs(gx), abs(gy)
        ratio = min(ax, ay) / (max(ax, ay) + _TINY)
        square = ratio * ratio
        angle = ratio * (
            _ARCTAN[0]
            + square * (_ARCTAN[1] + square * (_ARCTAN[2] + square * (_ARCTAN[3] + square * _ARCTAN[4])))
        )
        angle = _HALF_TURN_BINS - angle if ay > ax else angle
        orientations[slot, x] = _BINS - angle if gx * gy < _ZERO else angle


@inner_kernel(no_alias=True)
def vertical_triangle(ring: NDArray, row: int, last: int, width: int, weights: NDArray, out: NDArray) -> None:
    """Triangle filter down the columns of the magnitudes; rows beyond 0..last repeat the edge."""
    mask = MAGNITUDE_RING - 1
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    here = row & mask
    a1, b1 = max(row - 1, 0) & mask, min(row + 1, last) & mask
    a2, b2 = max(row - 2, 0) & mask, min(row + 2, last) & mask
    a3, b3 = max(row - 3, 0) & mask, min(row + 3, last) & mask
    a4, b4 = max(row - 4, 0) & mask, min(row + 4, last) & mask
    a5, b5 = max(row - 5, 0) & mask, min(row + 5, last) & mask
    for x in range(width):
        out[PAD + x] = (
            w0 * ring[here, x]
            + w1 * (ring[a1, x] + ring[b1, x])
            + w2 * (ring[a2, x] + ring[b2, x])
            + w3 * (ring[a3, x] + ring[b3, x])
            + w4 * (ring[a4, x] + ring[b4, x])
            + w5 * (ring[a5, x] + ring[b5, x])
        )
    for i in range(TRIANGLE_REACH):
        out[PAD - 1 - i], out[PAD + width + i] = out[PAD], out[PAD + width - 1]


@inner_kernel(no_alias=True)
def normalise(
    magnitudes: NDArray, slot: int, s: NDArray, width: int, weights: NDArray, constant: float, out: NDArray
) -> None:
    """Magnitude over its neighbourhood's: `s` is filtered down the columns, here along the row."""
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for x in range(width):
        at = PAD + x
        mean = (
            w0 * s[at]
            + w1 * (s[at - 1] + s[at + 1])
            + w2 * (s[at - 2] + s[at + 2])
            + w3 * (s[at - 3] + s[at + 3])
            + w4 * (s[at - 4] + s[at + 4])
            + w5 * (s[at - 5] + s[at + 5])
        )
        out[x] = magnitudes[slot, x] / (mean + constant)


@inner_kernel(no_alias=True)
def add_orientations(magnitude: NDArray, orientations: NDArray, slot: int, width: int, sums: NDArray) -> None:
    """Each pixel's magnitude, shared between its two nearest orientations, onto the column sums."""
    first = MAGNITUDE + 1
    for x in range(width):
        away = min(orientations[slot, x], _BINS - orientations[slot, x])  # the first is near the last
        sums[first, PAD + x] += magnitude[x] * max(_ONE - away, _ZERO)
    for k in range(1, ORIENTATIONS):
        centre = _f(k)
        for x in range(width):
            away = abs(orientations[slot, x] - centre)
            sums[first + k, PAD + x] += magnitude[x] * max(_ONE - away, _ZERO)


@inner_kernel(no_alias=True)
def cell_row(
    sums: NDArray, first: int, end: int, columns: int, cell_px: int, cells: NDArray, slot: int
) -> None:
    """Sums of four (or two) columns each into a row of cells of some channels, and the sums back to zero."""
    for k in range(first, end):
        if cell_px == 4:
            for c in range(columns):
                x = PAD + 4 * c
                cells[slot, k, PAD + c] = sums[k, x] + sums[k, x + 1] + (sums[k, x + 2] + sums[k, x + 3])
        else:
            for c in range(columns):
                x = PAD + 2 * c
                cells[slot, k, PAD + c] = sums[k, x] + sums[k, x + 1]
        sums[k] = _ZERO


@inner_kernel(no_alias=True)
def total_of_orientations(cells: NDArray, slot: int, columns: int) -> None:
    """The magnitudes of a row of cells: their parts in the six orientations add up to them."""
    for i in range(columns):
        x = PAD + i
        first_three = cells[slot, 4, x] + cells[slot, 5, x] + cells[slot, 6, x]
        cells[slot, MAGNITUDE, x] = first_three + cells[slot, 7, x] + cells[slot, 8, x] + cells[slot, 9, x]


@inner_kernel(no_alias=True)
def store_row(
    cells: NDArray, row: int, last: int, cell_px: int, vertical: NDArray, out: NDArray, to: int
) -> None:
    """Smooth one row of cells of every channel and store it as uint8."""
    columns = out.shape[1]
    part = _ONE / _f(cell_px * cell_px)  # sums over a cell's pixels become means
    mask = CELL_RING - 1
    above, here, below = max(row - 1, 0) & mask, row & mask, min(row + 1, last) & mask
    for k in range(CHANNEL_COUNT):
        for c in range(columns):
            x = PAD + c
            vertical[0, x] = _QUARTER * (cells[above, k, x] + cells[below, k, x]) + _HALF * cells[here, k, x]
        vertical[0, PAD - 1], vertical[0, PAD + columns] = vertical[0, PAD], vertical[0, PAD + columns - 1]
        if k < MAGNITUDE:
            steps, offset = _COLOUR_STEPS[k] * part, _COLOUR_OFFSETS[k] + _HALF
            for c in range(columns):
                x = PAD + c
                smooth = _QUARTER * (vertical[0, x - 1] + vertical[0, x + 1]) + _HALF * vertical[0, x]
                out[to, c, k] = np.uint8(min(max(steps * smooth + offset, _ZERO), _MAX))
        else:
            for c in range(columns):
                x = PAD + c
                smooth = _QUARTER * (vertical[0, x - 1] + vertical[0, x + 1]) + _HALF * vertical[0, x]
                out[to, c, k] = np.uint8(min(_GRADIENT_STEPS * np.sqrt(part * smooth) + _HALF, _MAX))
