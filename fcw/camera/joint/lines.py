"""Lines of the road: each runs to the point straight ahead, the first two as far apart as a lane is wide."""

import math

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera

SMALLEST_BELOW_PX = 0.5
"""An end of a line is taken to be at least this far below the horizon."""


def line_misfits(
    ends_px: FloatArray, camera: GroundPlaneCamera, click_px: float, width_m: Gaussian | None
) -> FloatArray:
    """How far lines are from leading straight ahead, then their distance from the lane's width; in sigmas.

    Args:
        ends_px: (2 N, 2) columns and rows in the straight picture, both ends of each line after each other.
        camera: the straight one.
        click_px: standard deviation of a clicked column or row.
        width_m: from the first line to the second; None where it is not known.
    """
    horizon_px, column_px = camera.horizon_row_px, camera.principal_column_px
    cosine = math.cos(camera.pitch_rad)
    found, sides_m = [], []
    for line in ends_px.reshape(-1, 2, 2).tolist():
        near, far = sorted(line, key=lambda place: -place[1])
        below_px = max(near[1] - horizon_px, SMALLEST_BELOW_PX)
        ratio = max(far[1] - horizon_px, SMALLEST_BELOW_PX) / below_px
        side_px = near[0] - column_px
        # Where the far end must be, seen along the row, for the line to lead straight ahead.
        slope = side_px / below_px
        # Of both ends, column and row: the row of an end moves its place by the slope.
        sigma_px = click_px * math.hypot(1, ratio) * math.hypot(1, slope)
        found.append((far[0] - column_px - ratio * side_px) / sigma_px)
        sides_m.append(-slope * camera.height_m / cosine)
    if width_m is not None and len(sides_m) > 1:
        found.append((abs(sides_m[0] - sides_m[1]) - width_m.value) / width_m.sigma)
    return np.array(found)
