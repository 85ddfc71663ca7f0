"""Own motion from picture to picture: corners followed from one to the next, solved, and filtered."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import FloatArray
from fcw.motion.corners import find_corners
from fcw.motion.filter import (
    MOUNT_PITCH,
    MOUNT_ROLL,
    MOUNT_YAW,
    SPEED,
    SPRING,
    UNKNOWN_SPEED_SIGMA_MPS,
    YAW_RATE,
    MotionFilter,
)
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import ROAD_PITCH, ROAD_ROLL, TRAVEL, YAW, PITCH, solve
from fcw.motion.state import Mount, OwnMotion, SpeedSource

VEHICLE_MARGIN = 0.15
"""Boxes are taken so much larger, in parts of themselves: shadows and errors of the detector."""
STANDING_MPS = 0.3
FIRST_SPEED_SIGMA_MPS = 3.0
BACKGROUND_ABOVE = 0.004
"""What is this little above the horizon, in units of rays, is background already."""


class _Picture(NamedTuple):
    time_ns: int
    grey: NDArray[np.uint8]
    boxes: tuple[Box, ...]


class MotionEstimator:
    """Own motion and mount of one drive.

    Args:
        calibration: for the size of the pictures.
        settings: see `MotionSettings`.
    """

    def __init__(self, calibration: Calibration, settings: MotionSettings | None = None) -> None:
        self._settings = settings or MotionSettings()
        size = calibration.image_size
        self._factor = max(1, round(size.width / self._settings.working_width_px))
        self._camera = calibration.camera
        self._focal_px = self._camera.focal_y_px / self._factor
        self._axis = tuple(
            (pixel + 0.5) / self._factor - 0.5
            for pixel in (self._camera.principal_column_px, self._camera.principal_row_px)
        )
        self._filter = MotionFilter(self._settings)
        self._last: _Picture | None = None
        self._tried = -1
        self._known = False
        self._silent = 0
        self.points = (0, 0)

    def update(self, time_ns: int, image: NDArray[np.uint8], boxes: Sequence[Box] = ()) -> OwnMotion:
        """Take a picture.

        Args:
            time_ns: of it; must rise.
            image: (height, width, 3) BGR.
            boxes: of other vehicles in it.
        """
        last = self._last
        if last is not None and (time_ns - last.time_ns) / 1e9 < self._settings.shortest_step_s:
            return self.state
        picture = _Picture(time_ns, self._small(image), tuple(boxes))
        self._last = picture
        if last is None:
            return self.state
        dt_s = (time_ns - last.time_ns) / 1e9
        self._filter.predict(dt_s)
        if dt_s > self._settings.longest_step_s or not self._take_step(last, picture, dt_s):
            self._miss()
        return self.state

    @property
    def state(self) -> OwnMotion:
        """What is believed now."""
        filtered, settings = self._filter, self._settings
        speed_mps, sigma_mps = max(float(filtered.x[SPEED]), 0.0), filtered.sigma(SPEED)
        known = self._known and sigma_mps < max(settings.known_part * speed_mps, settings.known_mps)
        return OwnMotion(
            speed_mps=speed_mps if known else None,
            speed_sigma_mps=sigma_mps if known else None,
            speed_source=SpeedSource.PICTURE if known else SpeedSource.UNKNOWN,
            yaw_rate_radps=float(filtered.x[YAW_RATE]) if self._known else None,
            yaw_rate_sigma_radps=filtered.sigma(YAW_RATE) if self._known else None,
            mount=Mount(
                pitch_rad=self._camera.pitch_rad + float(filtered.x[MOUNT_PITCH]),
                yaw_rad=float(filtered.x[MOUNT_YAW]),
                roll_rad=float(filtered.x[MOUNT_ROLL]),
                pitch_sigma_rad=filtered.sigma(MOUNT_PITCH),
                yaw_sigma_rad=filtered.sigma(MOUNT_YAW),
                roll_sigma_rad=filtered.sigma(MOUNT_ROLL),
            ),
            picture_speed_mps=speed_mps if known else None,
        )

    def _miss(self) -> None:
        """Two pictures said nothing: what is known decays, and in the end another speed is tried."""
        self._silent += 1
        if self._filter.sigma(SPEED) > self._settings.known_part * abs(float(self._filter.x[SPEED])) + 1.0:
            self._known = False
        if not self._known:
            speeds = self._settings.first_speeds_mps
            self._tried = (self._tried + 1) % len(speeds)
            self._filter.forget_speed(speeds[self._tried], FIRST_SPEED_SIGMA_MPS)

    def _small(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        if self._factor > 1:
            size = (grey.shape[1] // self._factor, grey.shape[0] // self._factor)
            grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
        return np.asarray(grey, np.uint8)

    def _rays(self, places: NDArray[np.float32]) -> FloatArray:
        """(N, 2) x / z and y / z in level axes of (N, 2) places in the small picture."""
        x = (places[:, 0] - self._axis[0]) / self._focal_px
        y = (places[:, 1] - self._axis[1]) / self._focal_px
        sine, cosine = math.sin(self._camera.pitch_rad), math.cos(self._camera.pitch_rad)
        z = cosine - y * sine
        return np.column_stack((x / z, (y * cosine + sine) / z)).astype(np.float64)

    def _places(self, x: FloatArray, y: FloatArray, z: FloatArray) -> NDArray[np.float32]:
        """(N, 2) places in the small picture of points in level axes."""
        sine, cosine = math.sin(self._camera.pitch_rad), math.cos(self._camera.pitch_rad)
        depth = y * sine + z * cosine
        columns = self._axis[0] + self._focal_px * x / depth
        rows = self._axis[1] + self._focal_px * (y * cosine - z * sine) / depth
        return np.column_stack((columns, rows)).astype(np.float32)

    def _take_step(self, last: _Picture, now: _Picture, dt_s: float) -> bool:
        """Whether two pictures said anything."""
        settings, height_m = self._settings, self._camera.height_m
        mean, covariance, by_state = self._filter.expect(dt_s)
        places, road = self._choose(last, mean)
        if road.sum() < settings.fewest_points:
            return False
        rays = self._rays(places)
        below = np.maximum(mean[ROAD_ROLL] * rays[:, 0] + rays[:, 1] + mean[ROAD_PITCH], 0.0) / height_m
        inverse_depth = np.where(road, below, np.maximum(settings.far_inverse_depth, below))
        spread = np.where(road, settings.unevenness, settings.far_inverse_depth_sigma + below / 2)
        expected = self._expected(rays, np.where(road, below, 0.01), mean)
        followed, status, _ = cv2.calcOpticalFlowPyrLK(
            last.grey,
            now.grey,
            places[:, None],
            expected[:, None].copy(),
            winSize=(settings.window_px, settings.window_px),
            maxLevel=settings.levels,
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 8, 0.03),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
            minEigThreshold=1e-4,
        )
        kept = status[:, 0] == 1
        if road[kept].sum() < settings.fewest_points:
            return False
        road = road[kept]
        solution = solve(
            rays[kept],
            self._rays(followed[kept, 0]),
            road,
            inverse_depth[kept],
            spread[kept],
            height_m,
            settings.place_sigma_px / self._focal_px,
            mean,
            covariance,
            settings.scales,
        )
        inlying = solution.inlying > 0.25
        self.points = (int((inlying & road).sum()), int((inlying & ~road).sum()))
        self.debug = (places[kept], followed[kept, 0], road, solution.inlying)
        if self.points[0] < settings.fewest_points or inlying[road].mean() < settings.fewest_inlying:
            return False
        self._filter.correct(solution, mean, covariance, by_state)
        self._known, self._silent = True, 0
        return True

    def _choose(self, picture: _Picture, mean: FloatArray) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """(N, 2) places to follow from a picture, and (N,) which are of the road."""
        settings = self._settings
        places, scores = find_corners(picture.grey, 0, settings.cell_px)
        places, scores = places[scores > settings.faintest], scores[scores > settings.faintest]
        free = np.ones(len(places), bool)
        for box in picture.boxes:
            left, right = box.x - VEHICLE_MARGIN * box.w, box.right + VEHICLE_MARGIN * box.w
            top, bottom = box.y - VEHICLE_MARGIN * box.h, box.bottom + VEHICLE_MARGIN * box.h
            x, y = places[:, 0] * self._factor, places[:, 1] * self._factor
            free &= (x < left) | (x > right) | (y < top) | (y > bottom)
        places, scores = places[free], scores[free]
        rays = self._rays(places)
        below = mean[ROAD_ROLL] * rays[:, 0] + rays[:, 1] + mean[ROAD_PITCH]
        depth_m = self._camera.height_m / np.maximum(below, 1e-6)
        aside_m = np.abs(rays[:, 0] - mean[YAW]) * depth_m
        nearest_m = max(
            settings.road_near_m, float(mean[TRAVEL]) / (1 - 1 / settings.largest_growth)
        )
        road = (aside_m < settings.road_half_width_m) & (depth_m > nearest_m)
        road &= depth_m < max(settings.road_far_m, 2 * nearest_m)
        other = (below < -BACKGROUND_ABOVE) | (aside_m > settings.road_half_width_m + 1.0)
        other &= depth_m > nearest_m
        chosen = []
        for which, most in ((road, settings.road_points), (other, settings.other_points)):
            index = np.flatnonzero(which)
            if len(index) > most:
                index = index[np.argpartition(-scores[index], most)[:most]]
            chosen.append(index)
        index = np.concatenate(chosen)
        return places[index], road[index]

    def _expected(self, rays: FloatArray, inverse_depth: FloatArray, mean: FloatArray) -> NDArray[np.float32]:
        """Where points are expected in the next picture."""
        wx, wy, wz, travel = mean[:4]
        x = rays[:, 0] - inverse_depth * travel * mean[YAW]
        y = rays[:, 1] + inverse_depth * travel * mean[PITCH]
        z = 1 - inverse_depth * travel
        return self._places(x + wz * y - wy * z, y - wz * x + wx * z, z + wy * x - wx * y)
