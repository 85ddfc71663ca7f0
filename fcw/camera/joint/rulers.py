"""Vehicles as rulers: their widths in metres, compared with the usual width of their kind."""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.joint.evidence import CAR_LENGTH_M, Ruler

SIDE_SIGMA = 0.5
"""Relative error of the visible side: vehicles are turned, and boxes are not exact."""
STRAY_DENSITY = 0.01
"""Density of the width of a stray box, relative to that of a vehicle with the usual width. One box in ten is
not a vehicle and may have any width over three e-folds; vehicles differ by 9 %."""
STARTS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Quantiles of the horizons from single vehicles at which a fit starts, because many may be stray boxes."""
APART_RAD = math.radians(1.0)
"""Starts that are closer together lead to the same fit."""


def horizons_by_widths(rulers: Sequence[Ruler], height_m: float, focal_px: float) -> list[float]:
    """Rows where the horizon may be: above the lower edge of a vehicle by the camera height in its scale."""
    by_each = [ruler.row_px - ruler.width_px * height_m / ruler.width_m.value for ruler in rulers]
    found: list[float] = []
    for row_px in np.quantile(by_each, STARTS, method="nearest").tolist():
        if not found or row_px - found[-1] > APART_RAD * focal_px:
            found.append(row_px)
    return found


def width_misfits(
    rulers: Sequence[Ruler],
    places: FloatArray,
    camera: GroundPlaneCamera,
    log_fleet: float,
    slope_rad: float,
    usual_focal_px: float,
) -> FloatArray:
    """(2 N,) misfits in sigmas: the width of each vehicle at its row, against the usual width of its kind.

    A box may be a stray one, of a house or the own bonnet. So the cost of a box has an upper limit, that of
    a mixture of both (Hogg, Bovy and Lang 2010, section 3).

    Widths and rows do not show the focal length, so the visible sides must not influence it either: they are
    computed with the usual focal length.

    Sigmas that depend on the camera need a cost of their own, that of the factor 1 / sigma in the density;
    this is the second half. Without it, a camera that sees mostly the sides of all vehicles would fit
    anything.

    The error of a row is a part of the vehicle's height in the picture, taken from its width and not from the
    camera. Otherwise a horizon below a vehicle would excuse its width, and two false boxes on the own bonnet
    would outweigh the vehicles ahead.

    Args:
        rulers: the vehicles.
        places: (N, 2) columns and rows of their lower edges in the straight picture.
        camera: camera of the straight picture.
        log_fleet: logarithm of how much wider all vehicles are together.
        slope_rad: how much the road under them falls relative to the plane that the car stands on.
        usual_focal_px: prior focal length, or that of a known lens.
    """
    below = np.maximum(places[:, 1] - camera.horizon_row_px - usual_focal_px * slope_rad, 1.0)
    widths_px = np.array([ruler.width_px for ruler in rulers])
    metres_per_px = camera.height_m / (below * math.cos(camera.pitch_rad))
    usual_m = np.array([ruler.width_m.value for ruler in rulers])
    # A vehicle beside our path shows its side, whose far end is one car length farther away.
    outer_m = (np.abs(places[:, 0] - camera.principal_column_px) + widths_px / 2) * metres_per_px
    distances_m = usual_focal_px * metres_per_px
    sides_m = np.maximum(outer_m - usual_m, 0.0) * CAR_LENGTH_M / (distances_m + CAR_LENGTH_M)
    sides_m[[ruler.side_known for ruler in rulers]] = 0.0
    seen_m = np.maximum(widths_px * metres_per_px - sides_m, usual_m / 3)
    relative = np.array([ruler.width_m.sigma / ruler.width_m.value for ruler in rulers])
    row_parts = np.array([ruler.row_sigma_px for ruler in rulers]) * usual_m / (widths_px * camera.height_m)
    widened = 1 + (row_parts**2 + (SIDE_SIGMA * sides_m / seen_m) ** 2) / relative**2
    sigmas = relative * np.sqrt(widened)
    misfits = (np.log(seen_m / usual_m) - log_fleet) / sigmas
    off = -2 * np.log((np.exp(-(misfits**2) / 2) + STRAY_DENSITY) / (1 + STRAY_DENSITY))
    robust = np.sign(misfits) * np.sqrt(np.maximum(off, 0.0))
    return np.concatenate((robust, np.sqrt(np.log(widened))))
