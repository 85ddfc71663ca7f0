"""Own speed from the road as a whole, if its points cannot be tracked.

In compressed video, a road has hardly any corners. But its dashes, patches, cracks and shadows still move as
a whole. A strip of the road ahead is warped to the view from above in both pictures of a step. Everything
stationary in it is subtracted (solid lines, our own bonnet, blocks that the codec repeats). The shift along
the road at which the two correlate is the distance driven. A single pair tells little, so a grid of speeds
accumulates the evidence of many.

Something stationary that was not yet learned as such (a drifting reflection, a solid line in a bend, the
codec's blocks) may outweigh a faint road. But it correlates backwards as well as forwards. So the correlation
minus its mirror image is used as well if the correlation itself gives no speed.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray
from fcw.motion.flow.speed_grid import ACCELERATION_MPS2, LEAST_CORRELATION, SPEEDS_MPS, SpeedGrid
from fcw.motion.view import RoadView

STEP_M, ROWS, NEAREST_M, HALF_WIDTH_M = 0.1, 90, 4.5, 3.0
"""Resolution of the strip, its length in steps, where it begins, and half of its width."""
COLUMNS = 2 * round(HALF_WIDTH_M / STEP_M) + 1
MIDDLE_M = NEAREST_M + STEP_M * ROWS / 2
CORNERS = np.array([(0, 0), (ROWS - 1, 0), (ROWS - 1, COLUMNS - 1), (0, COLUMNS - 1)], np.float32)
"""Row and column of the corners of the strip; columns increase to the left."""
CORNERS_M = (NEAREST_M, -HALF_WIDTH_M) + STEP_M * CORNERS.astype(np.float64)
"""Positions of these corners: ahead of the camera, and to the left."""
FINER = 4
"""Number of shifts tried per row, because at 5 m/s and 15 pairs per second the road moves by only three
rows."""
OVERLAP_ROWS = 30
"""Least number of rows of the strip that both pictures must share."""
AROUND_STEPS = (11, 9)
"""Length and width of the surroundings whose mean brightness is subtracted."""
LARGEST_CONTRAST = 20.0
"""Larger differences of grey values are clipped to this, so that one reflection cannot dominate."""
STANDS_S = 0.4
"""Time constant with which stationary parts are learned."""
SLOWEST_MPS = 4.0
"""Below this speed, the road hardly moves relative to what is learned as stationary."""
SLOWEST_LESS_BACKWARDS_MPS = 9.0
"""Below this speed, the backward correlation of the road overlaps the forward one."""
ERROR_PART, ERROR_MPS = 0.07, 0.3
"""1-sigma of the error that slopes and pitching leave, relative and absolute."""
KNOWN_PART = 0.2
"""The speed is known while its 1-sigma is less than this fraction of it."""


class RoadPair(NamedTuple):
    """The road in two pictures.

    Attributes:
        greys: the small pictures, (height, width).
        views: view of the road in each.
        yaw_rad: yaw of the camera, to the left of the direction of travel.
        turned_rad: rotation to the left from the first to the second.
        boxes: boxes of vehicles in the small pictures.
        dt_s: time from the first to the second.
    """

    greys: tuple[NDArray[np.uint8], NDArray[np.uint8]]
    views: tuple[RoadView, RoadView]
    yaw_rad: float
    turned_rad: float
    boxes: Sequence[Box]
    dt_s: float


class RoadPlane:
    """Accumulates evidence on the speed from pairs of pictures.

    Its settings were chosen while looking at the clips of docs/figures/own-motion.md.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Start anew."""
        self._grid, self._grid_less_backwards = SpeedGrid(SLOWEST_MPS), SpeedGrid(SLOWEST_LESS_BACKWARDS_MPS)
        self._stands: NDArray[np.float32] | None = None
        self._since_s = 0.0
        self._told: Gaussian | None = None

    def look(self, pair: RoadPair) -> None:
        """Update with two pictures."""
        # A point at distance d moves to the right by d times the angle by which we turn to the left.
        before = _strip(pair.greys[0], pair.views[0], pair.yaw_rad - pair.turned_rad, pair.boxes)
        now = _strip(pair.greys[1], pair.views[1], pair.yaw_rad, pair.boxes)
        if self._stands is None:
            self._stands = now.copy()
        self._stands += min(pair.dt_s / STANDS_S, 1.0) * (now - self._stands)
        ahead, backwards = _by_speed(before - self._stands, now - self._stands, pair.dt_s)
        self._since_s += pair.dt_s
        told = [
            (found, correlation)
            for grid, correlation in (
                (self._grid, ahead),
                (self._grid_less_backwards, ahead - np.maximum(backwards, 0.0)),
            )
            if (found := grid.update(correlation, pair.dt_s)) is not None
        ]
        if told:
            self._told, correlation = told[0]
            # A grid remembers for a second, without our braking since. Only a speed that is seen now is
            # fresh.
            if float(np.interp(self._told.value, SPEEDS_MPS, correlation)) > LEAST_CORRELATION:
                self._since_s = 0.0

    def speed_mps(self, height_m: float, pitch_sigma_rad: float) -> Gaussian | None:
        """The speed; None when unknown. The last one is kept with a growing sigma.

        Args:
            height_m: height of the camera.
            pitch_sigma_rad: 1-sigma of its pitch relative to the road, which the scale of the strip depends
                on.
        """
        if self._told is None:
            return None
        mean_mps = self._told.value
        # A row covers d^2 / (focal length * height) of the road, a scale that changes by 2 d / height per
        # radian.
        part = math.hypot(ERROR_PART, 2 * MIDDLE_M / height_m * pitch_sigma_rad)
        grown_mps = math.hypot(self._told.sigma, ACCELERATION_MPS2 * self._since_s)
        sigma_mps = math.hypot(part * mean_mps, grown_mps, ERROR_MPS)
        return Gaussian(mean_mps, sigma_mps) if sigma_mps < KNOWN_PART * mean_mps else None


def _strip(
    grey: NDArray[np.uint8], view: RoadView, yaw_rad: float, boxes: Sequence[Box]
) -> NDArray[np.float32]:
    """(COLUMNS, ROWS) the road from above, minus the mean brightness around; 0 where it is not seen."""
    seen = np.zeros(grey.shape, np.uint8)
    seen[1:-1, 1:-1] = 1
    for box in boxes:
        top, bottom, left, right = (max(round(side), 0) for side in (box.y, box.bottom, box.x, box.right))
        seen[top : bottom + 1, left : right + 1] = 0
    left_m = CORNERS_M[:, 1] - CORNERS_M[:, 0] * yaw_rad
    places = np.column_stack(view.places(left_m, CORNERS_M[:, 0]))
    homography = cv2.getPerspectiveTransform(CORNERS, places)
    from_above = functools.partial(cv2.warpPerspective, M=homography, dsize=(ROWS, COLUMNS))
    strip = from_above(grey, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP).astype(np.float32)
    part = from_above(seen, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP).astype(np.float32)
    around = cv2.blur(strip * part, AROUND_STEPS) / np.maximum(cv2.blur(part, AROUND_STEPS), 1e-3)
    return np.clip(part * (strip - around), -LARGEST_CONTRAST, LARGEST_CONTRAST, dtype=np.float32)


def _by_speed(
    before: NDArray[np.float32], now: NDArray[np.float32], dt_s: float
) -> tuple[FloatArray, FloatArray]:
    """(speeds,) forward and backward correlation of two strips at each speed; 0 with too little overlap."""
    rows = np.arange(ROWS - OVERLAP_ROWS)
    product = np.fft.rfft(before, 2 * ROWS) * np.conj(np.fft.rfft(now, 2 * ROWS))
    # Zero padding of the spectrum interpolates between whole rows.
    common = FINER * np.fft.irfft(product.sum(axis=0), FINER * 2 * ROWS)
    of_before = np.cumsum(np.square(before).sum(axis=0)[::-1])[::-1][rows]
    of_now = np.cumsum(np.square(now).sum(axis=0))[ROWS - 1 - rows]
    shifts = np.arange(FINER * rows[-1] + 1)
    norm = np.interp(shifts / FINER, rows, np.maximum(np.sqrt(of_before * of_now), 1.0))
    shift = FINER * SPEEDS_MPS * dt_s / STEP_M
    ahead, backwards = (np.interp(shift, shifts, common[way * shifts] / norm, right=0.0) for way in (1, -1))
    return ahead, backwards
