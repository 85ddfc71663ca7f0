"""One picture in the making: where points of the world are in it, and flat things painted into it."""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.simulation.picture.canvas import FloatImage
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.projection import dynamic_camera, project
from fcw.simulation.picture.quads import Texture, paint_quad
from fcw.simulation.world.state import WorldState

NEAR_DEPTH_M = 0.4
"""What is nearer to the camera's own plane is cut off."""
CREST_STEP_M, CREST_END_M = 2.0, 600.0


class View:
    """The picture of one instant.

    Args:
        image: (rows, columns, 3) float32 BGR, painted on.
        state: the instant.
        camera: as calibrated.
        light: of the drive.

    Attributes:
        camera: as it stands at this instant.
    """

    def __init__(
        self, image: FloatImage, state: WorldState, camera: GroundPlaneCamera, light: Daylight
    ) -> None:
        self.image, self.state, self.light = image, state, light
        self.camera = dynamic_camera(camera, state.ego.pitch_deviation_rad, state.ego.bounce_m)
        ahead_m = np.arange(CREST_STEP_M, CREST_END_M, CREST_STEP_M)
        points = state.road_points(state.ego.s_m + ahead_m, state.ego.lateral_m)
        rows = self.pixels(points)[:, 1]
        self._crest_rows = np.minimum.accumulate(np.where(np.isfinite(rows), rows, np.inf))

    def pixels(self, points_m: FloatArray) -> FloatArray:
        """Columns and rows (n, 2) of points (n, 3) in the own vehicle's axes; nan behind the camera."""
        return np.stack(project(points_m, self.camera), axis=-1)

    def depth_m(self, points_m: FloatArray) -> FloatArray:
        """Depth along the optical axis of points (..., 3) in the own vehicle's axes."""
        pitch_rad = self.camera.pitch_rad
        below_m = self.camera.height_m - points_m[..., 2]
        return points_m[..., 0] * math.cos(pitch_rad) + below_m * math.sin(pitch_rad)

    def lowest_row(self, s_m: float) -> float:
        """Row below which a crest of the road hides what stands behind it."""
        index = math.floor((s_m - self.state.ego.s_m - 2.0) / CREST_STEP_M) - 1
        return math.inf if index < 0 else float(self._crest_rows[min(index, len(self._crest_rows) - 1)])

    def quad(
        self,
        texture: Texture,
        corners_m: FloatArray,
        light: float = 1.0,
        part: tuple[float, float] = (0.0, 1.0),
        lowest_row_px: float = math.inf,
    ) -> None:
        """Paint a flat texture.

        Args:
            texture: what is painted.
            corners_m: (4, 3) in the own vehicle's axes: top left, top right, bottom right, bottom left of the
                texture. What lies behind the camera is cut off between its left and right edge.
            light: factor of brightness.
            part: top and bottom of what is painted, as fractions of the texture.
            lowest_row_px: nothing is painted below it.
        """
        depths_m = self.depth_m(corners_m)
        left_m, right_m = min(depths_m[0], depths_m[3]), min(depths_m[1], depths_m[2])
        if max(left_m, right_m) < NEAR_DEPTH_M:
            return
        first, last = 0.0, 1.0
        if left_m < NEAR_DEPTH_M:
            first = (NEAR_DEPTH_M - left_m) / (right_m - left_m)
        elif right_m < NEAR_DEPTH_M:
            last = (left_m - NEAR_DEPTH_M) / (left_m - right_m)
        top_left, top_right, bottom_right, bottom_left = corners_m
        cut = np.stack(
            [
                start + (end - start) * part_of
                for start, end, part_of in (
                    (top_left, top_right, first),
                    (top_left, top_right, last),
                    (bottom_left, bottom_right, last),
                    (bottom_left, bottom_right, first),
                )
            ]
        )
        pixels = self.pixels(cut)
        if not np.isfinite(pixels).all():
            return
        clarity = math.exp(-max(float(depths_m.mean()), 0.0) / self.light.visibility_m)
        box = (first, part[0], last, part[1])
        paint_quad(self.image, texture, pixels, box, light, clarity, self.light.haze, lowest_row_px)

    def upright(
        self,
        texture: Texture,
        foot_m: NDArray[np.float64],
        width_m: float,
        height_m: float,
        lowest_row_px: float,
    ) -> None:
        """Paint something flat that stands at a point and faces us."""
        left, top = np.array((0.0, width_m / 2, 0.0)), np.array((0.0, 0.0, height_m))
        corners = np.stack((foot_m + left + top, foot_m - left + top, foot_m - left, foot_m + left))
        self.quad(texture, corners, lowest_row_px=lowest_row_px)
