"""Windows of a picture for the nets, each at its own scale.

A window is measured in units. A vehicle with sqrt(w h) = `VEHICLE_UNITS` is horizontally centred in it, and
its bottom edge is `BOTTOM_UNITS` below the window's top.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.channels.halving import halve_rows
from fcw.frame import ImageSize
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel, rows_of_bytes

WINDOW_UNITS = 64.0
VEHICLE_UNITS = 40.0
BOTTOM_UNITS = 52.0
LEVELS = 5
"""Number of levels of a pyramid. The last has a sixteenth of the width; a window of 48 px there covers 768
px."""


class Pyramid:
    """A picture and its repeated halves, to cut windows from at any scale."""

    def __init__(self, picture: NDArray[np.uint8]) -> None:
        levels = [np.ascontiguousarray(picture)]
        for _ in range(LEVELS - 1):
            levels.append(_half(levels[-1]))
        self._pictures = tuple(levels)
        self._levels = tuple(rows_of_bytes(level) for level in levels)

    def part(self, level: int, rows: slice, columns: slice, shown: ImageSize) -> NDArray[np.uint8]:
        """A part of a level, resized to `shown`."""
        part = self._pictures[level][rows, columns]
        return np.asarray(cv2.resize(part, (shown.width, shown.height)), np.uint8)

    def windows(
        self, placements: NDArray[np.float64], side_px: int, side_units: float = WINDOW_UNITS
    ) -> NDArray[np.uint8]:
        """Cut windows, or other squares with the same centres. The picture's edges are repeated beyond it.

        Args:
            placements: (N, 3) the vehicles that the windows expect: middle column, bottom row, sqrt(w h), px.
            side_px: side of the results in pixels.
            side_units: side of the squares that are cut, in units.

        Returns:
            (N, side_px, side_px, 3) uint8.
        """
        middles, bottoms, sizes = placements.T
        units = sizes / VEHICLE_UNITS
        sides = side_units * units
        # The origin of coordinates is the centre of the first pixel, that of the squares is its edge.
        lefts = middles + 0.5 - sides / 2
        tops = bottoms + 0.5 - (BOTTOM_UNITS - WINDOW_UNITS / 2) * units - sides / 2
        cut = np.empty((len(placements), side_px, side_px, 3), np.uint8)
        squares = np.ascontiguousarray(np.column_stack([lefts, tops, sides]))
        _cut(self._levels, squares, cut.reshape(-1, 3 * side_px))
        return cut


def level_sizes(size: ImageSize) -> tuple[ImageSize, ...]:
    """Sizes of the levels of a pyramid."""
    sizes = [size]
    for _ in range(LEVELS - 1):
        sizes.append(ImageSize(-(-sizes[-1].width // 2), -(-sizes[-1].height // 2)))
    return tuple(sizes)


def _half(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture of half the size, rounded up. For even sizes, the same as OpenCV's in half the time."""
    height, width = picture.shape[:2]
    if height % 2 or width % 2:
        size = -(-width // 2), -(-height // 2)
        return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    half = np.empty((height // 2, width // 2, 3), np.uint8)
    halve_rows(rows_of_bytes(picture), 0, np.empty(3 * width, np.uint16), half.reshape(len(half), -1))
    return half


@kernel()
def _cut(levels: tuple[NDArray[np.uint8], ...], squares: NDArray[np.float64], cut: NDArray[np.uint8]) -> None:
    """Sample each square (left, top, side; px of the picture) from the level with the best resolution for it.

    Bilinear: two rows are interpolated first, then the columns of the result.
    """
    side_px = cut.shape[1] // 3
    # For each element of a row of results, the two elements that are interpolated, and the right one's
    # weight.
    lefts, besides = np.empty((2, 3 * side_px), np.int32)
    rights = np.empty(3 * side_px, np.float32)
    mixed = np.empty(levels[0].shape[1], np.float32)
    for i in range(len(squares)):
        side = squares[i, 2]
        halvings = int(min(max(np.floor(np.log2(side / side_px)), 0.0), len(levels) - 1.0))
        level = levels[halvings]
        height, width = level.shape[0], level.shape[1] // 3
        by_x, by_y = level.shape[1] / levels[0].shape[1], height / levels[0].shape[0]
        step_x, step_y = side * by_x / side_px, side * by_y / side_px
        for column in range(side_px):
            x = min(max(squares[i, 0] * by_x + (column + 0.5) * step_x - 0.5, 0.0), width - 1.0)
            for channel in range(3):
                to = 3 * column + channel
                lefts[to], rights[to] = 3 * int(x) + channel, x - int(x)
                besides[to] = 3 * min(int(x) + 1, width - 1) + channel
        first, end = lefts[0], besides[-1] + 1
        for row in range(side_px):
            y = min(max(squares[i, 1] * by_y + (row + 0.5) * step_y - 0.5, 0.0), height - 1.0)
            _mix(level, int(y), min(int(y) + 1, height - 1), np.float32(y - int(y)), first, end, mixed)
            _pick(mixed, lefts, besides, rights, cut, i * side_px + row)


@inner_kernel(no_alias=True)
def _mix(
    level: NDArray[np.uint8],
    above: int,
    below: int,
    part: np.float32,
    first: int,
    end: int,
    mixed: NDArray[np.float32],
) -> None:
    """Interpolate between two rows; `part` is the weight of the second."""
    for i in range(first, end):
        x = np.uint64(i)
        upper, lower = np.float32(level[np.uint64(above), x]), np.float32(level[np.uint64(below), x])
        mixed[x] = upper + part * (lower - upper)


@inner_kernel(no_alias=True)
def _pick(
    mixed: NDArray[np.float32],
    lefts: NDArray[np.int32],
    besides: NDArray[np.int32],
    rights: NDArray[np.float32],
    out: NDArray[np.uint8],
    row: int,
) -> None:
    """Interpolate between the elements of a row."""
    for x in range(len(lefts)):
        left, beside = mixed[np.uint64(lefts[x])], mixed[np.uint64(besides[x])]
        out[np.uint64(row), np.uint64(x)] = np.uint8(left + rights[x] * (beside - left) + np.float32(0.5))


def boxes_of(placements: NDArray[np.float64], offsets: NDArray[np.floating]) -> NDArray[np.float64]:
    """(N, 4) x, y, w, h of vehicles, from the placements of their windows and the net's offsets.

    Args:
        placements: (N, 3) middle, bottom and size.
        offsets: (N, 4) shift of middle and bottom, in sizes, and logarithms of width and height over the
            size.
    """
    middles, bottoms, sizes = placements.T
    widths, heights = sizes * np.exp(np.clip(offsets[:, 2:].T.astype(np.float64), -1.0, 1.0))
    middles, bottoms = middles + offsets[:, 0] * sizes, bottoms + offsets[:, 1] * sizes
    return np.column_stack([middles - widths / 2, bottoms - heights, widths, heights])


def placements_on(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) placements (middle, bottom, size) of windows that expect vehicles exactly in these boxes."""
    x, y, w, h = boxes.T
    return np.column_stack([x + w / 2, y + h, np.sqrt(w * h)])
