"""Finds a frame that somebody put around a picture: one colour, a blurred copy, or a player's window.

Its inner edges are straight and in the same place in all pictures. Nothing that a camera sees is like that on
two opposite sides. Outside these edges, nothing is sharp, or nothing changes.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEAST_PART = 0.02
"""Smallest border on each side, as a part of the width or height: thinner ones are an encoder's margin."""
UNEVEN_PART = 0.02
"""Largest difference between the two sides: a visor or a black sky is seldom as high as a bonnet."""
LARGEST_PART = 0.45
"""A wider border would leave next to nothing of the picture."""
LEAST_EDGE = 15.0
"""Least mean step of the grey values along the inner edges, in every picture. In 40 clips without a frame,
the weaker of two edges that could be a frame's has at most 12.6, and at most 4.6 if both are as straight as a
frame's. In clips with a drawn frame it has 29 or more."""
BESIDE_PX, LEAST_TIMES = 4, 3.0
"""The step is at least so many times the step so many rows beside it. A visor's edge is less straight."""
FEWEST = 2
"""So many pictures are needed to tell a frame from what a single picture shows by chance."""
LARGEST_DETAIL, LARGEST_CHANGE = 0.2, 0.1
"""Largest detail, or change, outside the edges, as a part of that inside. In the clips without a frame these
are at least 0.24 and 0.32. In the drawn frames one of the two is at most 0.05."""
SMALLEST_PX = 16
"""A smaller picture has no room for a frame."""
LEAST_CHANGE = 1.0
"""Least change inside the edges, in grey values. With less, a frame looks like a scene at rest."""
FloatArray = NDArray[np.float32]


class _Side(NamedTuple):
    """What the rows, or the columns, of one picture show.

    Attributes:
        edge: (N - 1,) mean step to the next row or column.
        detail: (N,) mean step along the row or column.
        change: (N,) mean change since the picture before; None for the first picture.
    """

    edge: FloatArray
    detail: FloatArray
    change: FloatArray | None


class Borders:
    """Looks for a frame in several pictures of a drive."""

    def __init__(self) -> None:
        self._sides: tuple[list[_Side], list[_Side]] = ([], [])
        """By column and by row, one entry for each picture."""
        self._last: NDArray[np.int16] | None = None

    def see(self, image: NDArray[np.uint8]) -> None:
        """Take a picture, (height, width, 3) BGR."""
        if min(image.shape[:2]) < SMALLEST_PX:
            return
        green = image[:, :, 1].astype(np.int16)
        change = None if self._last is None else np.abs(green - self._last)
        down, across = (np.abs(np.diff(green, axis=axis)) for axis in (0, 1))
        for axis, sides in enumerate(self._sides):
            edge, detail = (across, down) if axis == 0 else (down, across)
            sides.append(
                _Side(
                    edge.mean(axis=axis, dtype=np.float32),
                    detail.mean(axis=axis, dtype=np.float32),
                    None if change is None else change.mean(axis=axis, dtype=np.float32),
                )
            )
        self._last = green

    @property
    def may_be(self) -> bool:
        """Whether the pictures so far may have a frame."""
        return any(_margins(sides).any() for sides in self._sides)

    @property
    def margins(self) -> NDArray[np.int64]:
        """Columns left and right, and rows above and below, that the frame takes; 0 if there is none."""
        if len(self._sides[0]) < FEWEST:
            return np.zeros(4, np.int64)
        return np.concatenate([_margins(sides) for sides in self._sides])


def _margins(sides: list[_Side]) -> NDArray[np.int64]:
    """Widths of the frame's two sides in one direction; 0 if there is no frame."""
    none = np.zeros(2, np.int64)
    if not sides:
        return none
    first, last, step = _edges(np.min([side.edge for side in sides], axis=0))
    if step < LEAST_EDGE:
        return none
    count = len(sides[0].detail)
    beyond = np.ones(count, bool)
    beyond[first : count - last] = False
    smooth = all(_part(side.detail, beyond) <= LARGEST_DETAIL for side in sides)
    changes = [side.change for side in sides if side.change is not None]
    moves = all(change[~beyond].mean() >= LEAST_CHANGE for change in changes)
    still = moves and all(_part(change, beyond) <= LARGEST_CHANGE for change in changes)
    return np.array((first, last), np.int64) if smooth or still else none


def _edges(edge: FloatArray) -> tuple[int, int, float]:
    """The most marked two edges as far from both sides: how far, and how marked the weaker one is."""
    count = len(edge) + 1
    padded = np.pad(edge, BESIDE_PX, mode="edge")
    beside = np.maximum(padded[: -2 * BESIDE_PX], padded[2 * BESIDE_PX :])
    edge = np.where(edge >= LEAST_TIMES * beside, edge, np.float32(0.0))
    least, widest = math.ceil(LEAST_PART * count), int(LARGEST_PART * count)
    uneven = int(UNEVEN_PART * count)
    before, behind = edge[:widest], edge[::-1][:widest]
    best = 0, 0, 0.0
    for more in range(-uneven, uneven + 1):
        both = np.minimum(
            before[max(-more, 0) : widest - max(more, 0)], behind[max(more, 0) :][: widest - abs(more)]
        )
        both[: max(least - 1, 0)] = 0.0
        if both.size and both.max() > best[2]:
            place = int(np.argmax(both))
            best = place + max(-more, 0) + 1, place + max(more, 0) + 1, float(both[place])
    return best


def _part(values: FloatArray, beyond: NDArray[np.bool_]) -> float:
    """The mean outside the edges, as a part of the mean inside."""
    return float(values[beyond].mean() / max(values[~beyond].mean(), 1e-6))
