"""Points of a clip tracked through many pictures, without any knowledge of the camera."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.motion.flow.corners import find_corners, small_grey
from fcw.motion.flow.pacing import REPEATED_CHANGE

WORKING_WIDTH_PX = 800
SHORTEST_STEP_S = 0.06
"""Least time between pictures that are used: sixteen per second."""
DENSE_PX, SPARSE_PX = 16, 32
"""Sides of the cells in which a corner is looked for; a picture takes about 7 ms or 3 ms."""
SPACING = 0.75
"""No new point is added to a square of this fraction of a cell that already has one."""
FAINTEST, LEAST_ROUNDNESS = 12.0, 0.06
"""Least score and roundness of corners; see `fcw.motion.flow.corners.Corners`."""
WINDOW_PX = 13
LEVELS = 4
RETURNS_PX = 0.4
"""A point that is tracked forward and back must return this near to where it began."""
EDGE_PX = 4
FEWEST_POINTS = 30


@dataclass(frozen=True, slots=True)
class FollowedPoints:
    """Points of one picture.

    Attributes:
        time_s: time of the picture.
        numbers: (N,) ids of the points, ascending; a point keeps its id from picture to picture.
        places: (N, 2) columns and rows in the small picture.
        shift_px: median shift to the right since the previous picture.
    """

    time_s: float
    numbers: NDArray[np.int64]
    places: NDArray[np.float32]
    shift_px: float


class PointTracks:
    """Tracks points through a clip.

    Args:
        width_px: width of the whole pictures.
        cell_px: `DENSE_PX` or `SPARSE_PX`.

    Attributes:
        factor: reduction factor of the small pictures.
        pictures: the points of the pictures that were used.
    """

    def __init__(self, width_px: int, cell_px: int = DENSE_PX) -> None:
        self.factor = max(1, round(width_px / WORKING_WIDTH_PX))
        self._cell_px = cell_px
        self.pictures: list[FollowedPoints] = []
        self.size = (0, 0)
        self._grey: NDArray[np.uint8] | None = None
        self._next = 0

    def update(self, time_s: float, image: NDArray[np.uint8]) -> bool:
        """Update with a picture.

        Args:
            time_s: time of the picture; must increase.
            image: (height, width, 3) BGR.

        Returns:
            Whether it was used. A repeated picture, or one too soon after the last, is not.
        """
        if self.pictures and time_s - self.pictures[-1].time_s < SHORTEST_STEP_S:
            return False
        grey, last = small_grey(image, self.factor), self._grey
        numbers, places, shift_px = np.zeros(0, np.int64), np.zeros((0, 2), np.float32), 0.0
        if last is not None:
            change = np.subtract(grey[::4, ::4], last[::4, ::4], dtype=np.float32)
            if np.abs(change).mean() < REPEATED_CHANGE:
                return False
            before = self.pictures[-1]
            followed, kept = _follow(last, grey, before.places)
            numbers, places = before.numbers[kept], followed[kept]
            if len(places) >= FEWEST_POINTS:
                shift_px = float(np.median(places[:, 0] - before.places[kept, 0]))
        new = _new_places(grey, places, self._cell_px)
        numbers = np.concatenate((numbers, np.arange(self._next, self._next + len(new))))
        self._next += len(new)
        self._grey, self.size = grey, (grey.shape[1], grey.shape[0])
        self.pictures.append(FollowedPoints(time_s, numbers, np.concatenate((places, new)), shift_px))
        return True


def _follow(
    last: NDArray[np.uint8], now: NDArray[np.uint8], places: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """(N, 2) positions of points in the next picture, and (N,) which came back when tracked back."""
    if not len(places):
        return places, np.zeros(0, bool)
    window = (WINDOW_PX, WINDOW_PX)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 15, 0.02)
    start = places[:, None]
    there, found, _ = cv2.calcOpticalFlowPyrLK(
        last, now, start, start.copy(), winSize=window, maxLevel=LEVELS, criteria=criteria
    )
    back, returned, _ = cv2.calcOpticalFlowPyrLK(
        now,
        last,
        there,
        start.copy(),
        winSize=window,
        maxLevel=1,
        criteria=criteria,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    followed = np.asarray(there[:, 0], np.float32)
    kept = (found[:, 0] == 1) & (returned[:, 0] == 1)
    kept &= np.abs(back[:, 0] - places).max(axis=1) < RETURNS_PX
    kept &= (followed >= EDGE_PX).all(axis=1)
    kept &= (followed < np.array(now.shape[::-1]) - EDGE_PX).all(axis=1)
    return followed, kept


def _new_places(grey: NDArray[np.uint8], taken: NDArray[np.float32], cell_px: int) -> NDArray[np.float32]:
    """(N, 2) corners at which there is no point yet."""
    corners, spacing_px = find_corners(grey, (cell_px, cell_px)), round(SPACING * cell_px)
    good = corners.places[(corners.scores > FAINTEST) & (corners.roundness > LEAST_ROUNDNESS)]
    occupied = np.zeros((grey.shape[0] // spacing_px + 2, grey.shape[1] // spacing_px + 2), bool)
    columns, rows = (taken // spacing_px).astype(int).T
    occupied[rows, columns] = True
    columns, rows = (good // spacing_px).astype(int).T
    return good[~occupied[rows, columns]].astype(np.float32)
