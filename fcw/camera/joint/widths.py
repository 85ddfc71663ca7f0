"""How well a calibration agrees with vehicles of a drive: each as wide as its kind, near and far."""

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
"""The slope of the road: whatever it is, it is the same for the calibrations that are compared."""
FLEETS = np.linspace(-1.5, 1.5, 301)
"""By how much wider than their kind all vehicles together may come out, as a logarithm."""


@dataclass(frozen=True, slots=True)
class WidthsFit:
    """How vehicles come out by a calibration.

    Attributes:
        cost: twice the negative logarithm of their likelihood, but for what is the same of every calibration.
        scale: of their widths, all together, against those of their kinds.
    """

    cost: float
    scale: float


def fit_of_widths(calibration: Calibration, rulers: Sequence[Ruler]) -> WidthsFit:
    """Vehicles as a calibration has them; comparable between calibrations of pictures of one size.

    Args:
        calibration: to judge.
        rulers: the vehicles, at least one.
    """
    way = calibration.straightening
    places = np.array([(ruler.column_px, ruler.row_px) for ruler in rulers])
    if way is not None:
        places = way.to_straight(places)
    size = calibration.image_size
    view = usual_lens(size, marked=False).field_of_view_rad
    assert view is not None
    # The same for every calibration, so that none gains by taking what is seen for the vehicles' sides.
    focal_px = size.width / 2 / math.tan(view.value / 2)
    misfits = np.array(
        [
            np.sum(width_misfits(rulers, places, calibration.camera, fleet, LEVEL_RAD, focal_px) ** 2)
            for fleet in FLEETS.tolist()
        ]
    )
    costs = misfits + (FLEETS / FLEET_SIGMA) ** 2
    return WidthsFit(float(costs.min()), math.exp(FLEETS[np.argmin(misfits)]))
