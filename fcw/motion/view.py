"""Conversions between the small picture and the road: rays in level axes, pixels of points on the road."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera


@dataclass(frozen=True, slots=True)
class RoadView:
    """How the road appears in a picture that was reduced by a whole factor.

    The level axes (x right, y down, z forward) are those of the calibrated camera. The road is level in them
    except for the two angles.

    Attributes:
        focal_px: focal length in the small picture.
        column_px: column of the optical axis in it.
        row_px: row of the optical axis in it.
        pitch_rad: calibrated pitch of the camera.
        height_m: height of the camera.
        road_pitch_rad: how much lower the camera looks, relative to the road, than when it was calibrated.
        road_roll_rad: how far it is rolled to the right relative to the road.
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
        """The view of a calibrated camera in pictures reduced by a factor."""
        return cls(
            camera.focal_y_px / factor,
            (camera.principal_column_px + 0.5) / factor - 0.5,
            (camera.principal_row_px + 0.5) / factor - 0.5,
            camera.pitch_rad,
            camera.height_m,
        )

    def turned(self, road_pitch_rad: float, road_roll_rad: float) -> "RoadView":
        """The same view with these two angles of the road."""
        return replace(self, road_pitch_rad=road_pitch_rad, road_roll_rad=road_roll_rad)

    def rays(self, places: NDArray[np.float32]) -> FloatArray:
        """(N, 2) rays x / z and y / z in level axes of (N, 2) pixels."""
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
        """Columns and rows of points on the road, lateral positive to the left; the arrays are broadcast."""
        lateral_m, distance_m = np.broadcast_arrays(lateral_m, distance_m)
        below_m = self.height_m + self.road_roll_rad * lateral_m - self.road_pitch_rad * distance_m
        return self.project(-lateral_m, below_m, distance_m)

    def inverse_depth(self, rays: FloatArray) -> FloatArray:
        """(N,) inverse depth of the road along (N, 2) rays, 1/m; negative above the horizon."""
        return (self.road_roll_rad * rays[:, 0] + rays[:, 1] + self.road_pitch_rad) / self.height_m
