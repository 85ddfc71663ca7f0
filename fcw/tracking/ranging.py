"""From a detection's box to measurements of range: the bottom row through the calibration, and the width.

The bottom row measures the inverse of the distance: on a flat road both are affine in each other, so row
noise that is symmetric in pixels stays symmetric there, also far out where distance itself is badly skewed.
The width measures distance up to an unknown factor, the vehicle's own width, and so how the distance
changes (Dagan et al. 2004, "Forward collision warning with a single camera").
"""

import math
from dataclasses import dataclass

from fcw.camera.calibration import Calibration
from fcw.detection.types import Box

CUT_MARGIN_PX = 2.0
"""An edge this near the picture's border may be the border and not the vehicle's edge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxNoise:
    """How far the edges of a detector's boxes are off.

    Attributes:
        edge_floor_px: 1-sigma of an edge of the smallest boxes: the grid of windows is no finer.
        edge_fraction: 1-sigma of an edge as a fraction of the box's height: the detector's windows are a
            twelfth of a vehicle apart and neighbouring scales differ by as much, uniform errors of 2.5 %
            each. Together 1.3 px at a height of 20 px and 2.6 px at 60 px.
        correlation_s: time over which the errors of one vehicle's boxes stay alike.
    """

    edge_floor_px: float = 1.0
    edge_fraction: float = 0.04
    correlation_s: float = 0.1

    def edge_sigma_px(self, box: Box) -> float:
        """1-sigma of the row or column of one edge of a box."""
        return math.hypot(self.edge_floor_px, self.edge_fraction * box.h)

    def log_width_sigma(self, box: Box) -> float:
        """1-sigma of the logarithm of a box's width, whose two edges err independently."""
        return math.sqrt(2) * self.edge_sigma_px(box) / box.w


@dataclass(frozen=True, slots=True)
class RowMeasurement:
    """What the bottom row says about the distance from the camera.

    Attributes:
        inverse_distance_per_m: one over the distance from the camera; noise may carry it to zero and below
            for a vehicle near the horizon.
        sigma_per_m: its 1-sigma from the noise of the box; pitch and calibration come on top.
    """

    inverse_distance_per_m: float
    sigma_per_m: float


def measure_row(calibration: Calibration, box: Box, noise: BoxNoise) -> RowMeasurement | None:
    """Range by the bottom row; None where the picture cuts the box off, so that its edge is not the road."""
    if box.bottom >= calibration.image_size.height - 0.5 - CUT_MARGIN_PX:
        return None
    camera = calibration.camera
    # The row map v = B + K / (D + C), solved for 1/D: finite through the horizon, where D is not.
    below_px = box.bottom - camera.horizon_row_px
    depth_scale = camera.row_scale_m_px - camera.pole_m * below_px
    if depth_scale <= 0:
        return None
    slope = camera.row_scale_m_px / depth_scale**2
    return RowMeasurement(below_px / depth_scale, noise.edge_sigma_px(box) * slope)


def measures_width(calibration: Calibration, box: Box) -> bool:
    """Whether both sides of the box are the vehicle's own, not the picture's border."""
    right_limit_px = calibration.image_size.width - 0.5 - CUT_MARGIN_PX
    return box.x > -0.5 + CUT_MARGIN_PX and box.right < right_limit_px


def distance_with_interval(
    calibration: Calibration, camera_distance_m: float, log_sigma: float
) -> tuple[float, float, float]:
    """What a distance with its own uncertainty is worth, the calibration's uncertainty added.

    Args:
        calibration: of the pictures.
        camera_distance_m: from the camera.
        log_sigma: standard deviation of its logarithm, without what the calibration contributes.

    Returns:
        (distance, 16th percentile, 84th percentile) from the reference, at least 0; inf where unbounded.
    """
    offset_m = calibration.reference_offset_m
    distance_m = max(camera_distance_m - offset_m, 0.0)
    row_px = calibration.row_at(distance_m)
    nearer_px = calibration.row_at(camera_distance_m / math.exp(log_sigma) - offset_m)
    # As a row noise, so that the calibration adds its own part of the interval.
    low_m, high_m = calibration.distance_interval(row_px, nearer_px - row_px)
    return distance_m, max(low_m, 0.0), high_m
