"""Own speed by the road as a whole, where none of its points can be followed.

In compressed video a road has hardly a corner. What it shows of dashes, patches, cracks and shadows still
comes nearer as one picture. A strip of the road ahead is seen from above in both pictures of a step; what
stands in it (solid lines, the own bonnet, what the codec repeats) is taken away; and the shift along the road
under which the two correlate is the way driven. One pair tells little: a grid of speeds gathers what pairs
tell, a histogram filter (Thrun, Burgard & Fox 2005, "Probabilistic Robotics", section 4.1).
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
from fcw.motion.view import RoadView

STEP_M, ROWS, NEAREST_M, HALF_WIDTH_M = 0.1, 90, 4.5, 3.0
"""Of the strip: its resolution, its length in steps, where it begins, and half of its width."""
COLUMNS = 2 * round(HALF_WIDTH_M / STEP_M) + 1
MIDDLE_M = NEAREST_M + STEP_M * ROWS / 2
CORNERS = np.array([(0, 0), (ROWS - 1, 0), (ROWS - 1, COLUMNS - 1), (0, COLUMNS - 1)], np.float32)
"""Of the strip, row and column, the columns to the left;"""
CORNERS_M = (NEAREST_M, -HALF_WIDTH_M) + STEP_M * CORNERS.astype(np.float64)
"""and where they are, ahead and to the left."""
OVERLAP_ROWS = 30
"""So much of the strip both pictures must show."""
AROUND_STEPS = (11, 9)
"""Length and width of the surroundings whose brightness is taken away."""
LARGEST_CONTRAST = 20.0
"""In grey values: more counts as so much, or one reflection would rule."""
STANDS_S = 0.4
"""Time in which what stands is learnt."""
SPEEDS_MPS = np.arange(0.0, 52.0, 0.5)
SLOWEST_MPS, FASTEST_MPS = 4.0, 47.0
"""Slower, the road hardly moves against what is learnt to stand; faster is the end of the grid."""
ACCELERATION_MPS2 = 3.0
WEIGHT_PER_S = 400.0
"""Of a correlation of 1, in the logarithm of the odds."""
REMEMBERED_S = 1.0
LEAST_CORRELATION = 0.2
"""In the mean over `REMEMBERED_S`. Below are speeds found by chance."""
SURE_PART, SURE_MPS = 0.06, 0.4
"""The grid tells a speed while its 1-sigma is less than this part of it, or this;"""
LASTS_S = 1.0
"""what it has told for so long is believed."""
ERROR_PART, ERROR_MPS = 0.07, 0.3
"""1-sigma of what slopes and pitching leave in it."""
KNOWN_PART = 0.2
"""The speed is known while its 1-sigma is less than this part of it."""


class RoadPair(NamedTuple):
    """The road in two pictures.

    Attributes:
        greys: the small pictures, (height, width).
        views: of the road in each.
        yaw_rad: of the camera, to the left of the direction of travel.
        turned_rad: to the left, from the first to the second.
        boxes: of vehicles in the small pictures.
        dt_s: from the first to the second.
    """

    greys: tuple[NDArray[np.uint8], NDArray[np.uint8]]
    views: tuple[RoadView, RoadView]
    yaw_rad: float
    turned_rad: float
    boxes: Sequence[Box]
    dt_s: float


class RoadPlane:
    """Gathers what pairs of pictures tell of the speed.

    Its settings were looked at on the clips of docs/figures.md, "Own motion".
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._log_odds = np.zeros(len(SPEEDS_MPS))
        self._correlation = np.zeros(len(SPEEDS_MPS))
        self._stands: NDArray[np.float32] | None = None
        self._lasted_s = self._since_s = 0.0
        self._told: Gaussian | None = None

    def look(self, pair: RoadPair) -> None:
        """Take two pictures."""
        # What is d ahead goes to the right by d times the angle that we turn to the left.
        before = _strip(pair.greys[0], pair.views[0], pair.yaw_rad - pair.turned_rad, pair.boxes)
        now = _strip(pair.greys[1], pair.views[1], pair.yaw_rad, pair.boxes)
        if self._stands is None:
            self._stands = now.copy()
        self._stands += min(pair.dt_s / STANDS_S, 1.0) * (now - self._stands)
        correlation = _by_speed(before - self._stands, now - self._stands, pair.dt_s)
        lasting = math.exp(-pair.dt_s / REMEMBERED_S)
        self._log_odds = _spread(lasting * self._log_odds, ACCELERATION_MPS2 * pair.dt_s)
        self._log_odds += WEIGHT_PER_S * pair.dt_s * np.maximum(correlation, 0.0)
        self._correlation = lasting * self._correlation + (1 - lasting) * correlation
        found = self._found()
        self._lasted_s = 0.0 if found is None else self._lasted_s + pair.dt_s
        self._since_s += pair.dt_s
        if self._lasted_s >= LASTS_S:
            self._told, self._since_s = found, 0.0

    def speed_mps(self, height_m: float, pitch_sigma_rad: float) -> Gaussian | None:
        """The speed; None where it is not known. What was told last decays.

        Args:
            height_m: of the camera.
            pitch_sigma_rad: 1-sigma of its pitch against the road: the scale of the strip hangs on it.
        """
        if self._told is None:
            return None
        mean_mps = self._told.value
        # A row shows d^2 / (focal length * height) of the road, which is wrong by 2 d / height a radian.
        part = math.hypot(ERROR_PART, 2 * MIDDLE_M / height_m * pitch_sigma_rad)
        grown_mps = math.hypot(self._told.sigma, ACCELERATION_MPS2 * self._since_s)
        sigma_mps = math.hypot(part * mean_mps, grown_mps, ERROR_MPS)
        return Gaussian(mean_mps, sigma_mps) if sigma_mps < KNOWN_PART * mean_mps else None

    def _found(self) -> Gaussian | None:
        """What the grid tells; None where it is not sure."""
        odds = np.exp(self._log_odds - self._log_odds.max())
        odds /= odds.sum()
        mean_mps = float(odds @ SPEEDS_MPS)
        sigma_mps = math.sqrt(float(odds @ (SPEEDS_MPS - mean_mps) ** 2))
        sure = sigma_mps < max(SURE_PART * mean_mps, SURE_MPS) and SLOWEST_MPS < mean_mps < FASTEST_MPS
        seen = float(np.interp(mean_mps, SPEEDS_MPS, self._correlation)) > LEAST_CORRELATION
        return Gaussian(mean_mps, sigma_mps) if sure and seen else None


def _strip(
    grey: NDArray[np.uint8], view: RoadView, yaw_rad: float, boxes: Sequence[Box]
) -> NDArray[np.float32]:
    """(COLUMNS, ROWS) the road from above, less the brightness around; 0 where it is not seen."""
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


def _by_speed(before: NDArray[np.float32], now: NDArray[np.float32], dt_s: float) -> FloatArray:
    """(speeds,) correlation of two strips if we drive so fast; 0 where they share too little."""
    shifts = np.arange(ROWS - OVERLAP_ROWS)
    product = np.fft.rfft(before, 2 * ROWS) * np.conj(np.fft.rfft(now, 2 * ROWS))
    common = np.fft.irfft(product.sum(axis=0), 2 * ROWS)[: len(shifts)]
    of_before = np.cumsum(np.square(before).sum(axis=0)[::-1])[::-1][shifts]
    of_now = np.cumsum(np.square(now).sum(axis=0))[ROWS - 1 - shifts]
    norm = np.maximum(np.sqrt(of_before * of_now), 1.0)
    return np.interp(SPEEDS_MPS * dt_s / STEP_M, shifts, common / norm, right=0.0)


def _spread(log_odds: FloatArray, sigma_mps: float) -> FloatArray:
    """What is believed of the speed after it may have changed by so much."""
    reach = 4
    steps_mps = (SPEEDS_MPS[1] - SPEEDS_MPS[0]) * np.arange(-reach, reach + 1)
    kernel = np.exp(-0.5 * (steps_mps / sigma_mps) ** 2)
    odds = np.exp(log_odds - log_odds.max())
    spread = np.convolve(np.pad(odds, reach, mode="edge"), kernel / kernel.sum(), "valid")
    return np.log(spread + 1e-12)
