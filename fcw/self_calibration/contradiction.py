"""How much less is known of a horizon where the two things that tell it contradict each other.

Where a drive leads to and how wide the vehicles ahead look have nothing in common but the road. On clips of
strangers they mostly agree to half a degree, and on one in four they do not, by up to 6 degrees. Sometimes it
is the vehicles, boxes that are none; sometimes the drive, of a few seconds. Neither's own sigma knows of it.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, matrix3
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.solve import row_jacobian
from fcw.camera.uncertainty import camera_sigmas


@dataclass(frozen=True, slots=True)
class Contradiction:
    """How far apart a drive and its vehicles see the horizon.

    Attributes:
        apart_rad: angle between the two horizons.
        sigmas: the same in sigmas of both together; more than 1.
    """

    apart_rad: float
    sigmas: float

    def widened(self, calibration: Calibration) -> Calibration:
        """The calibration with the sigma of its horizon multiplied by `sigmas` (Birge 1932)."""
        camera = calibration.camera
        sigma_rad = camera_sigmas(calibration).horizon_row_px / camera.focal_y_px
        support_m = np.array(calibration.support_distances_m) + calibration.reference_offset_m
        # Of the support rows by the tangent of the pitch, with the axis where it is.
        by_tangent = row_jacobian(camera, support_m)[:, 0] - camera.focal_y_px
        more = sigma_rad**2 * (self.sigmas**2 - 1) * np.outer(by_tangent, by_tangent)
        return replace(calibration, covariance=matrix3(np.array(calibration.covariance) + more))


def contradiction_in(known: Known) -> Contradiction | None:
    """The contradiction between drive and vehicles; None if they agree, or one of them is missing."""
    evidence = known.evidence
    if evidence.travel_px is None or not evidence.rulers:
        return None
    drive, vehicles = (
        calibrate_jointly(replace(known, evidence=part))
        for part in (replace(evidence, rulers=()), replace(evidence, travel_px=None))
    )
    apart_px = abs(drive.horizon_row_px - vehicles.horizon_row_px)
    sigmas = apart_px / math.hypot(*(camera_sigmas(one).horizon_row_px for one in (drive, vehicles)))
    return Contradiction(apart_px / drive.camera.focal_y_px, sigmas) if sigmas > 1 else None
