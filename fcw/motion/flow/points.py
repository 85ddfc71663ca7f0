"""Points that are tracked from one picture to the next: which are chosen, and where they went."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.kernels.jit import kernel
from fcw.motion.flow.corners import Corners, find_corners, small_grey
from fcw.motion.flow.kinds import OTHER, ROAD, kinds_of_corners
from fcw.motion.flow.own_car import OwnCar
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import PITCH, ROAD_PITCH, ROAD_ROLL, TRAVEL, YAW
from fcw.motion.view import RoadView

VEHICLE_MARGIN = 0.15
"""Boxes are enlarged by this fraction on each side, for shadows and errors of the detector."""
BACKGROUND_ABOVE = 0.004
"""Points at least this far above the horizon, in units of rays, are background."""
FAR_INVERSE_DEPTH = 0.01
"""Inverse depth, 1/m, for which a background point is predicted in the next picture."""
IN_PLACE_PX = 1.0
"""A point that moved by less between two pictures counts as in place."""
BONNET_REACHES_M, BEYOND_PART = 8.0, 1 / 3
"""A bonnet that mirrors the world has the best corners, but they do not move. So `BEYOND_PART` of the road's
points are taken beyond it, if there are as many. A third, a half and none were tried
(docs/figures/own-motion.md)."""
PLANE_MARGIN_PX = 16
"""Rows above the highest point of the road that are warped, too, for the windows at upper levels of the
pyramid."""


Places = NDArray[np.float32]
"""(N, 2) columns and rows in a small picture."""


class SmallPicture(NamedTuple):
    """A picture prepared for own motion.

    Attributes:
        time_ns: time of the picture.
        grey: (height, width) the small grey picture.
        corners: corners of the small picture.
        boxes: boxes of other vehicles, in pixels of the whole picture.
    """

    time_ns: int
    grey: NDArray[np.uint8]
    corners: Corners
    boxes: tuple[Box, ...]


class Flow(NamedTuple):
    """N tracked points.

    Attributes:
        cells: (N,) indices of the corners' cells.
        before: (N, 2) rays x / z and y / z in level axes, in the first picture.
        after: (N, 2) rays in the second picture.
        road: (N,) which points are taken as road.
        inverse_depth: (N,) inverse depth, 1/m; a guess for points off the road.
        depth_sigma: (N,) 1-sigma of the inverse depth; relative to it for the road.
        precision: (N, 3) xx, yy and xy of the inverse covariance of `after`.
    """

    cells: NDArray[np.int64]
    before: FloatArray
    after: FloatArray
    road: NDArray[np.bool_]
    inverse_depth: FloatArray
    depth_sigma: FloatArray
    precision: FloatArray

    def of(self, which: NDArray[np.bool_]) -> "Flow":
        """Some of the points, (N,)."""
        return Flow._make([values[which] for values in self])


class _Chosen(NamedTuple):
    """N corners that were chosen for tracking.

    Attributes:
        cells: (N,) indices of their cells.
        road: (N,) which are taken as road.
        rays: (N, 2) rays x / z and y / z in level axes.
        below: (N,) inverse depth of the road along the rays, 1/m.
    """

    cells: NDArray[np.int64]
    road: NDArray[np.bool_]
    rays: FloatArray
    below: FloatArray


@kernel()
def _moved(
    rays: FloatArray,
    inverse_depth: FloatArray,
    mean: FloatArray,
    focal_px: float,
    axis_px: tuple[float, float],
    pitch_rad: float,
    places: Places,
) -> None:  # pragma: no cover - compiled
    """(N, 2) pixels of points on rays after the camera moved by the solver's unknowns `mean`."""
    sine, cosine = math.sin(pitch_rad), math.cos(pitch_rad)
    wx, wy, wz, travel, yaw, pitch = mean[0], mean[1], mean[2], mean[TRAVEL], mean[YAW], mean[PITCH]
    for i in range(len(rays)):
        x = rays[i, 0] - inverse_depth[i] * travel * yaw
        y = rays[i, 1] + inverse_depth[i] * travel * pitch
        z = 1 - inverse_depth[i] * travel
        x, y, z = x + wz * y - wy * z, y - wz * x + wx * z, z + wy * x - wx * y
        depth = y * sine + z * cosine
        places[i, 0] = axis_px[0] + focal_px * x / depth
        places[i, 1] = axis_px[1] + focal_px * (y * cosine - z * sine) / depth


class PointFollower:
    """Chooses useful points, and tracks them.

    Args:
        camera: the calibrated camera, for the whole picture.
        width_px: width of the whole picture.
        settings: see `MotionSettings`.

    Attributes:
        view: the calibrated view in the small pictures.
    """

    def __init__(self, camera: GroundPlaneCamera, width_px: int, settings: MotionSettings) -> None:
        self._settings, self._height_m = settings, camera.height_m
        self._factor = max(1, round(width_px / settings.working_width_px))
        self.view = RoadView.of(camera, self._factor)
        self._trust = np.zeros(0)
        self._own_car: OwnCar | None = None

    def small(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The small grey picture of a (height, width, 3) BGR picture."""
        return small_grey(image, self._factor)

    def picture(self, time_ns: int, grey: NDArray[np.uint8], boxes: Sequence[Box]) -> SmallPicture:
        """Prepare a picture.

        Args:
            time_ns: time of the picture.
            grey: the small picture, from `small`.
            boxes: boxes of other vehicles in it.
        """
        corners = find_corners(grey, self._settings.cell_px)
        if len(self._trust) != len(corners.scores):
            self._trust = np.full(len(corners.scores), self._settings.first_trust)
            self._own_car = OwnCar(grey.shape, self._settings.cell_px)
        return SmallPicture(time_ns, grey, corners, tuple(boxes))

    def find_own_car(self, last: SmallPicture, now: SmallPicture) -> None:
        """Learn from two pictures where our own car is visible. No points are chosen there from now on."""
        if self._own_car is not None:
            self._own_car.look(now.time_ns, last.grey, now.grey, self.small_boxes(now))

    def small_boxes(self, picture: SmallPicture) -> list[Box]:
        """The boxes of other vehicles, in the pixels of the small picture."""
        k = 1 / self._factor
        return [Box(k * box.x, k * box.y, k * box.w, k * box.h) for box in picture.boxes]

    @property
    def picture_moves(self) -> bool:
        """Whether the picture apart from our own car moved recently, whatever the points show."""
        return self._own_car is not None and self._own_car.rest_moves

    def part_in_place(self, ago: SmallPicture, now: SmallPicture, mean: FloatArray) -> float:
        """Fraction of a picture's points that are still in place in a later one; 0 if there are none.

        Args:
            ago: the earlier picture.
            now: the later picture.
            mean: (8,) expected unknowns of `fcw.motion.solver`.
        """
        cells = self._choose(ago, mean).cells
        if not len(cells):
            return 0.0
        places = ago.corners.places[cells]
        places_now, found, differences = self._flow(ago.grey, now.grey, places, places)
        in_place = found & (differences < self._settings.largest_difference * ago.corners.contrast[cells])
        return float((in_place & (np.linalg.norm(places_now - places, axis=1) < IN_PLACE_PX)).mean())

    def in_place(self, flow: Flow) -> NDArray[np.bool_]:
        """(N,) which of N points are in place in the second picture."""
        return np.linalg.norm(flow.after - flow.before, axis=1) < IN_PLACE_PX / self.view.focal_px

    def part_changed(self, ago: SmallPicture, now: SmallPicture) -> float:
        """Fraction of a picture's cells, apart from our own car, that have changed in a later one."""
        return 0.0 if self._own_car is None else self._own_car.part_moved(ago.grey, now.grey)

    def follow(self, last: SmallPicture, now: SmallPicture, mean: FloatArray) -> Flow:
        """Track the points of one picture to the next.

        Args:
            last: the first picture.
            now: the second.
            mean: (8,) expected unknowns of `fcw.motion.solver`.
        """
        settings = self._settings
        cells, road, rays, below = self._choose(last, mean)
        places = last.corners.places[cells]
        inverse_depth = np.where(road, below, np.maximum(settings.far_inverse_depth, below))
        spread = np.where(
            road, settings.unevenness, settings.far_inverse_depth_sigma + np.maximum(below, 0.0)
        )
        if not len(cells):
            return Flow(cells, rays, rays, road, inverse_depth, spread, np.zeros((0, 3)))
        places_after = self._expected(rays, np.where(road, below, FAR_INVERSE_DEPTH), mean)
        found, differences = np.zeros(len(cells), bool), np.zeros(len(cells), np.float32)
        if road.any():
            places_after[road], found[road], differences[road] = self._follow_road(
                last.grey, now.grey, places[road], mean
            )
        if not road.all():
            places_after[~road], found[~road], differences[~road] = self._flow(
                last.grey, now.grey, places[~road], places_after[~road]
            )
        kept = found & (~road | (differences < settings.largest_difference * last.corners.contrast[cells]))
        return Flow(
            cells[kept],
            rays[kept],
            self.view.rays(places_after[kept]),
            road[kept],
            inverse_depth[kept],
            spread[kept],
            self._precision(last.corners.information[cells[kept]]),
        )

    def _follow_road(
        self, before: NDArray[np.uint8], after: NDArray[np.uint8], places: Places, mean: FloatArray
    ) -> tuple[Places, NDArray[np.bool_], NDArray[np.float32]]:
        """Like `_flow`, for points on the road.

        The second picture's road is warped to how it would look from where the first was taken, if we moved
        as expected. Near parts of the road grow between two pictures, the more the faster we are. Without the
        warp, a window of fixed size is tracked less far than it moves, and we seem slower than we are.
        """
        height, width = before.shape
        # Any four points on the road determine how all of it moves. These span the rows of its points,
        # because nearer parts may be behind us in the second picture.
        high, low = places[:, 1].min() - 1, places[:, 1].max()
        frame = np.array([(x, y) for y in (high, low) for x in (0, width - 1)], np.float32)
        rays = self.view.rays(frame)
        moved = self._expected(rays, self._road(mean).inverse_depth(rays), mean)
        plane = cv2.getPerspectiveTransform(frame, moved)
        top = max(int(high) - PLANE_MARGIN_PX, 0)
        drawn = cv2.warpPerspective(
            after,
            plane @ np.array(((1.0, 0.0, 0.0), (0.0, 1.0, top), (0.0, 0.0, 1.0))),
            (width, height - top),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        shift = np.array((0, top), np.float32)
        in_drawn, found, differences = self._flow(
            before[top:], drawn.astype(np.uint8, copy=False), places - shift, places - shift
        )
        places_after = cv2.perspectiveTransform((in_drawn + shift)[:, None], plane)[:, 0]
        inside = ((places_after > 0) & (places_after < (width - 1, height - 1))).all(axis=1)
        return places_after.astype(np.float32, copy=False), found & inside, differences

    def _flow(
        self, before: NDArray[np.uint8], after: NDArray[np.uint8], places: Places, expected: Places
    ) -> tuple[Places, NDArray[np.bool_], NDArray[np.float32]]:
        """Track (N, 2) points to another picture, starting from where they are expected.

        Returns:
            (N, 2) their positions, (N,) whether they were found, and (N,) mean differences of their windows.
        """
        settings = self._settings
        places_after, status, differences = cv2.calcOpticalFlowPyrLK(
            before,
            after,
            places[:, None],
            expected[:, None].copy(),
            winSize=(settings.window_px, settings.window_px),
            maxLevel=settings.levels,
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 8, 0.03),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        found = status[:, 0] == 1
        differences[~found] = np.inf  # OpenCV leaves these uninitialised
        single = np.column_stack((places_after[:, 0], differences)).astype(np.float32, copy=False)
        return single[:, :2], found, single[:, 2]

    def learn(self, cells: NDArray[np.int64], inlying: FloatArray, dt_s: float) -> None:
        """Learn in which cells points are inliers. Reflections and our own bonnet are not.

        Args:
            cells: (N,) indices of the points' cells.
            inlying: (N,) weights of the points, 0 to 1.
            dt_s: time since the previous step.
        """
        settings = self._settings
        self._trust += (settings.first_trust - self._trust) * min(dt_s / settings.trust_lasts_s, 1.0)
        self._trust[cells] += (inlying - self._trust[cells]) * min(dt_s / settings.trust_s, 1.0)

    def _choose(self, picture: SmallPicture, mean: FloatArray) -> "_Chosen":
        """Choose the corners that are tracked."""
        settings = self._settings
        corners = picture.corners
        rays = self.view.rays(corners.places)
        below = self._road(mean).inverse_depth(rays)
        boxes = np.empty((len(picture.boxes), 4))
        for sides, box in zip(boxes, picture.boxes, strict=True):
            aside_px, over_px = VEHICLE_MARGIN * box.w, VEHICLE_MARGIN * box.h
            sides[:] = box.x - aside_px, box.y - over_px, box.right + aside_px, box.bottom + over_px
        boxes /= self._factor
        nearest_m = max(settings.road_near_m, float(mean[TRAVEL]) / (1 - 1 / settings.largest_growth))
        farthest_m = max(settings.road_far_m, 2 * nearest_m)
        kinds = np.empty(len(rays), np.uint8)
        kinds_of_corners(
            corners,
            (settings.faintest, settings.least_trust, settings.least_roundness),
            self._trust,
            np.zeros(len(rays), bool) if self._own_car is None else self._own_car.cells,
            boxes,
            rays - (float(mean[YAW]), 0.0),
            below,
            (nearest_m, farthest_m, settings.road_half_width_m, -BACKGROUND_ABOVE / self._height_m),
            kinds,
        )
        worth = corners.scores * self._trust
        road, far = kinds == ROAD, below < 1 / BONNET_REACHES_M
        beyond = _best(worth, road & far, round(BEYOND_PART * settings.road_points))
        road[beyond] = False
        nearer = _best(worth, road, settings.road_points - len(beyond))
        cells = np.concatenate((beyond, nearer, _best(worth, kinds == OTHER, settings.other_points)))
        return _Chosen(cells, kinds[cells] == ROAD, rays[cells], below[cells])

    def _road(self, mean: FloatArray) -> RoadView:
        return self.view.turned(float(mean[ROAD_PITCH]), float(mean[ROAD_ROLL]))

    def _precision(self, information: FloatArray) -> FloatArray:
        """Inverse of sigma^2 I + grey^2 G^-1, in units of the rays, which is G (sigma^2 G + grey^2 I)^-1."""
        settings = self._settings
        xx, yy, xy = information.T
        place, grey = settings.place_sigma_px**2, settings.grey_sigma**2
        determinant = xx * yy - xy * xy
        a, b, c = place * xx + grey, place * yy + grey, place * xy
        scale = self.view.focal_px**2 / (a * b - c * c)
        # G times the adjoint; it is symmetric, as both are functions of G.
        return np.column_stack(
            (
                scale * (place * determinant + grey * xx),
                scale * (place * determinant + grey * yy),
                scale * grey * xy,
            )
        )

    def _expected(self, rays: FloatArray, inverse_depth: FloatArray, mean: FloatArray) -> Places:
        """(N, 2) expected pixels of points in the next small picture."""
        view, places = self.view, np.empty(rays.shape, np.float32)
        _moved(
            rays, inverse_depth, mean, view.focal_px, (view.column_px, view.row_px), view.pitch_rad, places
        )
        return places


def _best(worth: NDArray[np.floating], which: NDArray[np.bool_], most: int) -> NDArray[np.int64]:
    """(N,) indices of the elements with the largest worth among some, at most `most`."""
    index = np.flatnonzero(which)
    return index if len(index) <= most else index[np.argpartition(-worth[index], most)[:most]]
