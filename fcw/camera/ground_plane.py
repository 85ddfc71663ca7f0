"""A camera over a flat road: image rows and columns against distance and lateral position.

The paper's eq. 4 in image coordinates (rows grow downwards, everything signed) is a one-dimensional
projective map between distance d along the ground and row v:

    v = v0 + f_y tan(atan(h/d) - a)  =  B + K / (d + C)

    B = v0 - f_y tan(a)    the horizon's row
    C = h tan(a)           the image plane meets the road C behind the camera's foot
    K = h f_y / cos(a)^2

Distances in this module are from the point of the road below the camera, along the ground.
"""

import math
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GroundPlaneCamera:
    """A pinhole camera with square pixels, no roll and no yaw, above a flat road.

    Attributes:
        pitch_rad: rotation of the optical axis below the horizontal, a in the paper.
        focal_y_px: focal length in pixels, f_y; f_x is the same.
        principal_row_px: row of the optical axis, v0.
        height_m: height of the camera above the road, h.
        principal_column_px: column of the optical axis, u0, which points along the vehicle's axis.
    """

    pitch_rad: float
    focal_y_px: float
    principal_row_px: float
    height_m: float
    principal_column_px: float

    @classmethod
    def from_row_map(
        cls,
        horizon_row_px: float,
        row_scale_m_px: float,
        pole_m: float,
        height_m: float,
        principal_column_px: float,
    ) -> "GroundPlaneCamera":
        """The camera of height h whose row map has the coefficients B, K and C.

        The height changes no distance; it splits the row map into pitch, focal length and principal row.
        """
        tangent = pole_m / height_m
        focal_px = row_scale_m_px / (height_m * (1 + tangent**2))
        return cls(
            math.atan(tangent), focal_px, horizon_row_px + focal_px * tangent, height_m, principal_column_px
        )

    @property
    def horizon_row_px(self) -> float:
        """Row of the horizon, B: where distance becomes infinite."""
        return self.principal_row_px - self.focal_y_px * math.tan(self.pitch_rad)

    @property
    def pole_m(self) -> float:
        """C: a point at the distance -C is in the plane of the camera's centre, and has no row."""
        return self.height_m * math.tan(self.pitch_rad)

    @property
    def row_scale_m_px(self) -> float:
        """K: rows below the horizon, times distance from the pole."""
        return self.height_m * self.focal_y_px * (1 + math.tan(self.pitch_rad) ** 2)

    @overload
    def row_at(self, distance_m: float) -> float: ...
    @overload
    def row_at(self, distance_m: FloatArray) -> FloatArray: ...
    def row_at(self, distance_m: float | FloatArray) -> float | FloatArray:
        """Row of the road at a distance (eq. 4 with its sign corrected); +inf for points behind the camera.

        An infinite distance gives the horizon's row.
        """
        scale, pole, horizon = self.row_scale_m_px, self.pole_m, self.horizon_row_px
        if not isinstance(distance_m, np.ndarray):
            depth_m = distance_m + pole
            return float(horizon + scale / depth_m) if depth_m > 0 else math.inf
        depths_m = distance_m.astype(np.float64) + pole
        rows = np.full(depths_m.shape, math.inf)
        return horizon + np.divide(scale, depths_m, out=rows, where=depths_m > 0)

    @overload
    def distance_at(self, row_px: float) -> float: ...
    @overload
    def distance_at(self, row_px: FloatArray) -> FloatArray: ...
    def distance_at(self, row_px: float | FloatArray) -> float | FloatArray:
        """Distance of the road seen at a row (eq. 3, signed); inf at and above the horizon."""
        scale, pole, horizon = self.row_scale_m_px, self.pole_m, self.horizon_row_px
        if not isinstance(row_px, np.ndarray):
            below_px = row_px - horizon
            return float(scale / below_px - pole) if below_px > 0 else math.inf
        below = row_px.astype(np.float64) - horizon
        distances = np.full(below.shape, math.inf)
        return np.divide(scale, below, out=distances, where=below > 0) - pole

    def row_slope_at(self, distances_m: FloatArray) -> FloatArray:
        """Number of rows per metre of distance, at distances in front of the camera."""
        return self.row_scale_m_px / (distances_m + self.pole_m) ** 2

    @overload
    def lateral_at(self, column_px: float, row_px: float) -> float: ...
    @overload
    def lateral_at(self, column_px: FloatArray, row_px: FloatArray) -> FloatArray: ...
    def lateral_at(self, column_px: float | FloatArray, row_px: float | FloatArray) -> float | FloatArray:
        """Lateral position of the road seen at a pixel, left positive; nan at and above the horizon."""
        cosine = math.cos(self.pitch_rad)
        below = np.asarray(row_px, np.float64) - self.horizon_row_px
        # The ray through the pixel sinks by cos(a) (v - B) / f_y for each unit of depth.
        with np.errstate(divide="ignore", invalid="ignore"):
            lateral = (self.principal_column_px - np.asarray(column_px, np.float64)) * (
                self.height_m / np.where(below > 0, below * cosine, math.nan)
            )
        return float(lateral) if lateral.ndim == 0 else lateral

    @overload
    def column_at(self, lateral_m: float, distance_m: float) -> float: ...
    @overload
    def column_at(self, lateral_m: FloatArray, distance_m: FloatArray) -> FloatArray: ...
    def column_at(self, lateral_m: float | FloatArray, distance_m: float | FloatArray) -> float | FloatArray:
        """Column of a point of the road, lateral positive to the left; nan for points behind the camera."""
        depth = self._depth_m(np.asarray(distance_m, np.float64), 0.0)
        column = self.principal_column_px - self.focal_y_px * np.asarray(lateral_m, np.float64) / np.where(
            depth > 0, depth, math.nan
        )
        return float(column) if column.ndim == 0 else column

    def ground_box(self, distance_m: float, lateral_m: float, width_m: float, height_m: float) -> Box:
        """Box of the upright rear of a vehicle at a distance.

        Args:
            distance_m: distance of the rear, along the ground.
            lateral_m: lateral position of the rear's middle, positive to the left.
            width_m: width of the rear.
            height_m: height of the rear above the road.

        Raises:
            ValueError: a corner of the rear is beside or behind the camera.
        """
        bottom_depth_m = self._depth_m(distance_m, 0.0)
        top_depth_m = self._depth_m(distance_m, height_m)
        if bottom_depth_m <= 0 or top_depth_m <= 0:
            raise ValueError(f"a vehicle at {distance_m} m is not in front of the camera")
        tangent = math.tan(self.pitch_rad)
        top_row = (
            self.horizon_row_px
            + self.focal_y_px
            * (self.height_m - height_m)
            * (1 + tangent**2)
            * math.cos(self.pitch_rad)
            / top_depth_m
        )
        bottom_row = self.row_at(float(distance_m))
        # With pitch, the depths of the top and the bottom edge differ.
        left = min(self.focal_y_px * -(lateral_m + width_m / 2) / z for z in (bottom_depth_m, top_depth_m))
        right = max(self.focal_y_px * -(lateral_m - width_m / 2) / z for z in (bottom_depth_m, top_depth_m))
        return Box(self.principal_column_px + left, top_row, right - left, bottom_row - top_row)

    @overload
    def _depth_m(self, distance_m: float, height_m: float) -> float: ...
    @overload
    def _depth_m(self, distance_m: FloatArray, height_m: float) -> FloatArray: ...
    def _depth_m(self, distance_m: float | FloatArray, height_m: float) -> float | FloatArray:
        """Depth along the optical axis of a point above the road."""
        return distance_m * math.cos(self.pitch_rad) + (self.height_m - height_m) * math.sin(self.pitch_rad)
