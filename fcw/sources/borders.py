"""The frame that somebody put around a picture: of one colour, a blurred copy of it, or a player's window.

Its inner edge is straight, and in all pictures in the same place; nothing that a camera sees is so on two
opposite sides. Beyond it nothing is to be seen that is sharp, or nothing that changes.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEAST_PART = 0.02
"""Of the width or height, at either side: thinner ones are an encoder's margin."""
UNEVEN_PART = 0.02
"""The two sides differ by no more of it: a visor or a black sky is seldom as high as a bonnet."""
LARGEST_PART = 0.45
"""A wider border would leave next to nothing."""
LEAST_EDGE = 15.0
"""Mean step of the grey values along the inner edges, in every picture. In 40 clips without a frame no two
edges that could be one's have more than 12.6 both, and 4.6 where they are as straight as a frame's; where a
frame was drawn, 29 and more."""
BESIDE_PX, LEAST_TIMES = 4, 3.0
"""Such a step is so many times that of the rows so far beside it: a visor's edge is never as straight."""
FEWEST = 2
"""Pictures that tell a frame from what one shows by chance."""
LARGEST_DETAIL, LARGEST_CHANGE = 0.2, 0.1
"""What is beyond has at most so much of the picture's detail, or of its change. In those clips it has 0.24
and more of the one, 0.32 and more of the other; in the frames 0.05 of one of them at most."""
SMALLEST_PX = 16
"""A smaller picture has no room for a frame."""
LEAST_CHANGE = 1.0
"""Of the picture in grey values: less does not tell a frame from a scene that stands."""
FloatArray = NDArray[np.float32]


class _Side(NamedTuple):
    """Of one direction, by row or column, of one picture.

    Attributes:
        edge: (N - 1,) mean step to the next one.
        detail: (N,) mean step along it.
        change: (N,) mean change since the picture before; None in the first.
    """

    edge: FloatArray
    detail: FloatArray
    change: FloatArray | None


class Borders:
    """Looks for a frame in some pictures of a drive."""

    def __init__(self) -> None:
        self._sides: tuple[list[_Side], list[_Side]] = ([], [])
        """By column, and by row."""
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
        """Whether there may be a frame, by the pictures so far."""
        return any(_margins(sides).any() for sides in self._sides)

    @property
    def margins(self) -> NDArray[np.int64]:
        """Columns left and right, and rows above and below, of the frame; 0 where there is none."""
        if len(self._sides[0]) < FEWEST:
            return np.zeros(4, np.int64)
        return np.concatenate([_margins(sides) for sides in self._sides])


def _margins(sides: list[_Side]) -> NDArray[np.int64]:
    """Of both sides of one direction."""
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
    """Mean of what is beyond, as a part of that of the picture."""
    return float(values[beyond].mean() / max(values[~beyond].mean(), 1e-6))
