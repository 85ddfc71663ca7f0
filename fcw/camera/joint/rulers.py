"""Vehicles as rulers: how wide they would be, against how wide their kind is."""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.joint.evidence import CAR_LENGTH_M, Ruler

SIDE_SIGMA = 0.5
"""Of the side that is shown, as a part of it: vehicles are turned, and boxes end where they will."""
STRAY_DENSITY = 0.01
"""How likely a stray box is as wide as it is, against a vehicle's that is as wide as its kind: one box in ten
is no vehicle, and of any width, the widest three e-folds above the narrowest; vehicles are alike to 9 %."""
STARTS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Which of the horizons by each vehicle alone, in their order, a fit starts from: strays may be many."""
APART_RAD = math.radians(1.0)
"""Starts that are nearer to each other lead to the same fit."""


def horizons_by_widths(rulers: Sequence[Ruler], height_m: float, focal_px: float) -> list[float]:
    """Where the horizon may be: a width stands as far above the lower edge as the camera above the road."""
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
    """(2 N,) in sigmas: the width of each by its row, against that of its kind.

    A box may be a stray, as of a house or the own bonnet, so that a wild one has a largest cost: that of a
    mixture of both (Hogg, Bovy and Lang 2010, section 3). Widths and rows say nothing of the focal length, so
    the sides that are seen must not either: they are those of the usual one. Sigmas that depend on the camera
    have a cost, the second half: that of the density's factor 1 / sigma. Otherwise a camera that sees mostly
    the sides of all vehicles fits whatever was seen. The error of a row is a part of the height in the
    picture that the width tells, not of the one that the camera gives. Otherwise a horizon below a vehicle
    would excuse its width, and two false boxes on the own bonnet outweigh the vehicles ahead.

    Args:
        rulers: the vehicles.
        places: (N, 2) columns and rows of their lower edges in the straight picture.
        camera: of it.
        log_fleet: how much wider all vehicles are together, as a logarithm.
        slope_rad: by how much the road that they stand on falls away from the plane that the car stands on.
        usual_focal_px: focal length as it is believed beforehand, or of a lens that is known.
    """
    below = np.maximum(places[:, 1] - camera.horizon_row_px - usual_focal_px * slope_rad, 1.0)
    widths_px = np.array([ruler.width_px for ruler in rulers])
    metres_per_px = camera.height_m / (below * math.cos(camera.pitch_rad))
    usual_m = np.array([ruler.width_m.value for ruler in rulers])
    # A vehicle beside our path shows its side, whose far end is a car's length farther away.
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
