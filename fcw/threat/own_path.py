"""The own path where nobody has measured it: straight, or as the yaw rate says, and how uncertain that is.

The constants were chosen and tried on KITTI tracking 0000 to 0010 and the simulated scenarios; nothing was
left out.
"""

import math

from fcw.motion.bend.turn import USUAL_MPS
from fcw.motion.state import OwnPath
from fcw.tracking.lead import path_curvature_per_m

LATERAL_MPS2 = 0.5
"""1-sigma of the lateral acceleration of ordinary driving: what an unknown bend may be, R = 800 m at 72
km/h."""
LATERAL_WITH_YAW_RATE_MPS2 = 0.15
"""And where the yaw rate is known: how much it changes on the way."""
ENDING_BEND_PART = 0.5
"""And this part of it may be over soon: who turns off at a crossing drives straight on a moment later."""
MOUNT_YAW_RAD = math.radians(1.0)
"""1-sigma of a camera's direction against that of travel where it was not measured; KITTI's is 0.9
degrees."""
MOUNT_OFFSET_M = 0.15
"""1-sigma of a camera's place beside the middle of the car: behind the mirror."""
SLOWEST_MPS = 5.0
"""Slower, a bend is no sharper than at this speed: a car turns on a circle."""


def assumed_path(own_mps: float | None, yaw_rate_radps: float | None = None) -> OwnPath:
    """The own path along the camera's axis, bent by the yaw rate where that is known.

    Args:
        own_mps: own speed; None when unknown.
        yaw_rate_radps: how fast we turn, positive to the left; None when unknown.
    """
    speed_mps = max(USUAL_MPS if own_mps is None else own_mps, SLOWEST_MPS)
    lateral_mps2 = LATERAL_MPS2
    if yaw_rate_radps is not None:
        ending_mps2 = ENDING_BEND_PART * yaw_rate_radps * speed_mps
        lateral_mps2 = min(math.hypot(LATERAL_WITH_YAW_RATE_MPS2, ending_mps2), LATERAL_MPS2)
    return OwnPath(
        curvature_per_m=path_curvature_per_m(own_mps, yaw_rate_radps),
        offset_sigma_m=MOUNT_OFFSET_M,
        heading_sigma_rad=MOUNT_YAW_RAD,
        curvature_sigma_per_m=lateral_mps2 / speed_mps**2,
    )
