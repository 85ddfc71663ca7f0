"""The camera's height where it is not sure: what its error does to the rows of the distances.

A height is no unknown of the fit. It is a number that the fit takes as given, and its error goes into the
covariance of the support rows to first order: a "consider parameter" (Tapley, Schutz and Born, Statistical
Orbit Determination, 2004). Points at taped distances tell distances whatever the height; without them every
distance is proportional to it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, matrix3

MEASURED_SIGMA_M = 0.03
"""A folding rule held from the road to the lens of a car that may be loaded on the drive."""


@dataclass(frozen=True, slots=True)
class TypicalHeight:
    """The lens at the mirror of a kind of vehicle.

    Beliefs, from the body heights of common models less the way from roof to mirror: a lens may also be on
    the dashboard, and the interval says so.

    Attributes:
        name: of the kind.
        height_m: of the lens above the road.
        sigma_m: standard deviation over vehicles of the kind and places in them.
    """

    name: str
    height_m: float
    sigma_m: float


TYPICAL_HEIGHTS = (
    TypicalHeight("Car", 1.25, 0.10),
    TypicalHeight("SUV or pick-up", 1.45, 0.15),
    TypicalHeight("Van", 1.8, 0.25),
    TypicalHeight("Lorry or bus", 2.4, 0.4),
)


def with_height_error(
    calibration: Calibration, sigma_m: float, calibrate_at: Callable[[float], Calibration]
) -> Calibration:
    """The calibration with the error of its height in the covariance of its rows.

    Args:
        calibration: as if the height were sure.
        sigma_m: standard deviation of the height.
        calibrate_at: the same facts with another height.

    Raises:
        UserError: a height that far off determines no camera.
    """
    support_m = np.array(calibration.support_distances_m)
    height_m = calibration.camera.height_m
    step_m = min(sigma_m, height_m / 2)
    rows_px = [calibrate_at(height_m + side * step_m).row_at(support_m) for side in (1, -1)]
    moved_px = (rows_px[0] - rows_px[1]) / 2 * (sigma_m / step_m)
    covariance = np.array(calibration.covariance) + np.outer(moved_px, moved_px)
    return replace(calibration, covariance=matrix3(covariance))
