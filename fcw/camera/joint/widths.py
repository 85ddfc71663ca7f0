"""How well a calibration agrees with the vehicles of a drive, whose widths should be usual near and far."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.joint.evidence import Ruler
from fcw.camera.joint.fit import FLEET_SIGMA
from fcw.camera.joint.rulers import width_misfits
from fcw.camera.lens.usual import usual_lens

LEVEL_RAD = 0.0
"""Slope of the road; it is the same for all calibrations that are compared, so its value does not matter."""
FLEETS = np.linspace(-1.5, 1.5, 301)
"""Logarithms of the factors by which all vehicles together may be wider than usual."""


@dataclass(frozen=True, slots=True)
class WidthsFit:
    """How wide the vehicles are under a calibration.

    Attributes:
        cost: twice the negative log-likelihood of their widths, up to a constant.
        scale: factor by which all vehicles together are wider than usual.
    """

    cost: float
    scale: float


def fit_of_widths(calibration: Calibration, rulers: Sequence[Ruler]) -> WidthsFit:
    """Fit the widths of vehicles under a calibration.

    The results are comparable between calibrations for pictures of the same size.

    Args:
        calibration: the calibration to judge.
        rulers: the vehicles, at least one.
    """
    way = calibration.straightening
    places = np.array([(ruler.column_px, ruler.row_px) for ruler in rulers])
    if way is not None:
        places = way.to_straight(places)
    size = calibration.image_size
    view = usual_lens(size, marked=False).field_of_view_rad
    assert view is not None
    # The same for every calibration, so that none gains by explaining widths as the sides of vehicles.
    focal_px = size.width / 2 / math.tan(view.value / 2)
    misfits = np.array(
        [
            np.sum(width_misfits(rulers, places, calibration.camera, fleet, LEVEL_RAD, focal_px) ** 2)
            for fleet in FLEETS.tolist()
        ]
    )
    costs = misfits + (FLEETS / FLEET_SIGMA) ** 2
    return WidthsFit(float(costs.min()), math.exp(FLEETS[np.argmin(misfits)]))
