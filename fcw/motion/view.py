"""Between the small picture and the road: rays in level axes, and places of points of the road."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera


@dataclass(frozen=True, slots=True)
class RoadView:
    """How the road shows in a picture made smaller by a whole factor.

    Level axes (x right, y down, z forward) belong to the calibrated camera; the road is level in them but for
    the two angles.

    Attributes:
        focal_px: of the small picture.
        column_px: of the optical axis in it.
        row_px: likewise.
        pitch_rad: of the camera as calibrated.
        height_m: of it.
        road_pitch_rad: how much lower the camera looks against the road than it was calibrated to.
        road_roll_rad: how much it is rolled to the right.
    """

    focal_px: float
    column_px: float
    row_px: float
    pitch_rad: float
    height_m: float
    road_pitch_rad: float = 0.0
    road_roll_rad: float = 0.0

    @classmethod
    def of(cls, camera: GroundPlaneCamera, factor: int) -> "RoadView":
        """The view of a camera as calibrated, for its pictures made smaller by a factor."""
        return cls(
            camera.focal_y_px / factor,
            (camera.principal_column_px + 0.5) / factor - 0.5,
            (camera.principal_row_px + 0.5) / factor - 0.5,
            camera.pitch_rad,
            camera.height_m,
        )

    def turned(self, road_pitch_rad: float, road_roll_rad: float) -> "RoadView":
        """The same view, of a road with these two angles."""
        return replace(self, road_pitch_rad=road_pitch_rad, road_roll_rad=road_roll_rad)

    def rays(self, places: NDArray[np.float32]) -> FloatArray:
        """(N, 2) x / z and y / z in level axes of (N, 2) places."""
        x = (places[:, 0] - self.column_px) / self.focal_px
        y = (places[:, 1] - self.row_px) / self.focal_px
        sine, cosine = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        z = cosine - y * sine
        return np.column_stack((x / z, (y * cosine + sine) / z)).astype(np.float64)

    def project(
        self, x: FloatArray, y: FloatArray, z: FloatArray
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Columns and rows of points in level axes."""
        sine, cosine = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        depth = y * sine + z * cosine
        columns = self.column_px + self.focal_px * x / depth
        rows = self.row_px + self.focal_px * (y * cosine - z * sine) / depth
        return columns.astype(np.float32), rows.astype(np.float32)

    def places(
        self, lateral_m: FloatArray, distance_m: FloatArray
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Columns and rows of points of the road, lateral positive to the left; arrays of one shape."""
        lateral_m, distance_m = np.broadcast_arrays(lateral_m, distance_m)
        below_m = self.height_m + self.road_roll_rad * lateral_m - self.road_pitch_rad * distance_m
        return self.project(-lateral_m, below_m, distance_m)

    def inverse_depth(self, rays: FloatArray) -> FloatArray:
        """(N,) 1/m of the road along (N, 2) rays; negative above the horizon."""
        return (self.road_roll_rad * rays[:, 0] + rays[:, 1] + self.road_pitch_rad) / self.height_m
