"""The own path, fused from mount, yaw rate and lane lines, or assumed if nothing was measured."""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.motion.bend.turn import USUAL_MPS
from fcw.motion.bend.turning import AHEAD_S, Turning
from fcw.motion.lanes import Lane
from fcw.motion.state import OwnMotion, OwnPath

SLOWEST_TURN_MPS = 3.0
"""Below this speed, even a tiny yaw rate would mean a sharp bend."""
OFFSET_SIGMA_M = 0.35
"""1-sigma of our position in the lane: drivers keep to the middle this well."""
STRAY_RAD = math.radians(0.4)
"""1-sigma of our heading along the lane. The uncertainty of the camera's yaw is added (see `Mount`)."""
BEND_SIGMA_MPS2 = 0.15
"""1-sigma of the change of the lateral acceleration on the way, as the road ahead may bend otherwise than
here. At 50 km/h that is 0.35 m at 30 m."""
BEND_PART = 0.4
LARGEST_BEND_SIGMA_MPS2 = 0.5
"""A bend may end or get sharper. The 1-sigma of that is `BEND_PART` of the lateral acceleration, and at most
`LARGEST_BEND_SIGMA_MPS2`.

These are the likeliest values for the own motion of KITTI tracking 0000 to 0010, 2 and 3 s ahead, if the
sigma of a straight road is fitted too: in seven of eleven choices with one sequence left out; the others gave
0.3 to 0.4 and 0.4 to 0.8. With the sigma of a straight road as it is above, the part would be 0.2; the
present value gives fewer warnings of parked cars in bends."""
GROWTH_SIGMA = 1.0
"""1-sigma of the change of a bend, as a fraction of it: it may stop changing, or change twice as fast."""
UNKNOWN_BEND_SIGMA_PER_M = 2e-3
"""1-sigma of the curvature if nothing is known about it."""
ROAD_BEND_MPS2 = 1.0
"""1-sigma of the lateral acceleration in bends before anything is measured."""
UNKNOWN_SPEED_PART = 0.5
"""1-sigma of the curvature, as a fraction of it, if the yaw rate is known but not the speed: we may drive
half as fast as usual, or twice."""
GIVEN_YAW_RATE_SIGMA_RADPS = math.radians(0.3)
"""1-sigma of a given yaw rate as a prediction of the path. For our turning now it is exact (`turn_of`)."""

# Constants of an assumed path. They were chosen and tried on KITTI tracking 0000 to 0010 and the simulated
# scenarios. No drive was left out.
LATERAL_MPS2 = 0.5
"""1-sigma of the lateral acceleration in ordinary driving, and so of an unknown bend: R = 800 m at 72
km/h."""
MOUNT_YAW_RAD = math.radians(1.0)
"""1-sigma of a camera's yaw if it was not measured; KITTI's is 0.9 degrees."""
MOUNT_OFFSET_M = 0.15
"""1-sigma of a camera's lateral distance from the middle of the car: it hangs behind the mirror."""
SLOWEST_BEND_MPS = 5.0
"""At lower speeds an unknown bend is assumed no sharper than at this speed, as a car has a turning circle."""


class PathAhead:
    """The own path of one drive, frame by frame."""

    def __init__(self) -> None:
        self._turning = Turning()

    def update(self, time_ns: int, motion: OwnMotion, lane: Lane | None) -> OwnPath:
        """The path at a frame; see `own_path`."""
        sigma_radps = motion.yaw_rate_sigma_radps or GIVEN_YAW_RATE_SIGMA_RADPS
        change_radps = self._turning.update(time_ns, motion.speed_mps, motion.yaw_rate_radps, sigma_radps)
        return own_path(motion, lane, change_radps)


def own_path(motion: OwnMotion, lane: Lane | None, change_radps: float = 0.0) -> OwnPath:
    """The path from own motion and lane lines, each weighted by how well it is known.

    Args:
        motion: own motion; the mount gives the direction of the path relative to the camera's axis.
        lane: the lane, in the same coordinates; None if no lines are seen.
        change_radps: expected change of the yaw rate on the way; see `Turning`.
    """
    by_motion, sigmas = _by_motion(motion, change_radps)
    if lane is None:
        return _path((*by_motion.tolist(), 0.0), sigmas, None)
    # Own motion measures the curvature that the path has after a third of the way.
    third_m = AHEAD_S * max(USUAL_MPS if motion.speed_mps is None else motion.speed_mps, SLOWEST_TURN_MPS)
    told = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, third_m]])
    before, covariance = lane.mean[:4], lane.covariance[:4, :4]
    of_told = told @ covariance
    total = of_told @ told.T + np.diag(sigmas**2)
    gain = np.linalg.solve(total, of_told).T
    mean = before + gain @ (by_motion - told @ before)
    told_covariance = (of_told - of_told @ told.T @ gain.T) @ told.T
    return _path(mean.tolist(), np.sqrt(np.diag(told_covariance)), float(lane.mean[4]))


def assumed_path(own_mps: float | None) -> OwnPath:
    """The path if nothing was measured: straight along the camera's axis, with its uncertainty.

    Args:
        own_mps: own speed; None when unknown.
    """
    speed_mps = max(USUAL_MPS if own_mps is None else own_mps, SLOWEST_BEND_MPS)
    return OwnPath(
        offset_sigma_m=MOUNT_OFFSET_M,
        heading_sigma_rad=MOUNT_YAW_RAD,
        curvature_sigma_per_m=LATERAL_MPS2 / speed_mps**2,
    )


def path_curvature_per_m(own_mps: float | None, yaw_rate_radps: float | None) -> float:
    """Curvature of the own path from our yaw rate, positive to the left; 0 if unknown or too slow."""
    if own_mps is None or yaw_rate_radps is None or own_mps < SLOWEST_TURN_MPS:
        return 0.0
    return yaw_rate_radps / own_mps


def _by_motion(motion: OwnMotion, change_radps: float) -> tuple[FloatArray, FloatArray]:
    """Mean and 1-sigma of offset, heading and curvature by mount and yaw rate."""
    heading_rad, heading_sigma_rad = 0.0, STRAY_RAD
    if motion.mount is not None:
        heading_rad = -motion.mount.yaw_rad
        heading_sigma_rad = math.hypot(STRAY_RAD, motion.mount.yaw_sigma_rad)
    bend_per_m, bend_sigma_per_m = 0.0, UNKNOWN_BEND_SIGMA_PER_M
    speed_mps, yaw_rate_radps = motion.speed_mps, motion.yaw_rate_radps
    if speed_mps is None and yaw_rate_radps is not None:
        bend_per_m = yaw_rate_radps / USUAL_MPS
        bend_sigma_per_m = math.hypot(bend_sigma_per_m, UNKNOWN_SPEED_PART * bend_per_m)
    if speed_mps is not None and yaw_rate_radps is not None and speed_mps >= SLOWEST_TURN_MPS:
        sigma_radps = motion.yaw_rate_sigma_radps or GIVEN_YAW_RATE_SIGMA_RADPS
        # Shrink a poorly known yaw rate (after a while in the dark, say) towards the bends that roads have.
        measured_sigma_per_m = sigma_radps / speed_mps
        road_sigma_per_m = max(UNKNOWN_BEND_SIGMA_PER_M, ROAD_BEND_MPS2 / speed_mps**2)
        believed = road_sigma_per_m**2 / (road_sigma_per_m**2 + measured_sigma_per_m**2)
        bend_per_m = believed * (yaw_rate_radps + change_radps) / speed_mps
        across_mps2 = abs(bend_per_m) * speed_mps**2
        bend_sigma_per_m = math.hypot(
            BEND_SIGMA_MPS2 / speed_mps**2,
            min(BEND_PART * across_mps2, LARGEST_BEND_SIGMA_MPS2) / speed_mps**2,
            math.sqrt(believed) * measured_sigma_per_m,
            GROWTH_SIGMA * change_radps / speed_mps,
        )
    return (
        np.array([0.0, heading_rad, bend_per_m]),
        np.array([OFFSET_SIGMA_M, heading_sigma_rad, bend_sigma_per_m]),
    )


def _path(mean: Sequence[float], sigmas: FloatArray, lane_width_m: float | None) -> OwnPath:
    offset_m, heading_rad, curvature_per_m, growth_per_m2 = mean
    offset_sigma_m, heading_sigma_rad, curvature_sigma_per_m = sigmas.tolist()
    return OwnPath(
        offset_m=offset_m,
        heading_rad=heading_rad,
        curvature_per_m=curvature_per_m,
        growth_per_m2=growth_per_m2,
        offset_sigma_m=offset_sigma_m,
        heading_sigma_rad=heading_sigma_rad,
        curvature_sigma_per_m=curvature_sigma_per_m,
        lane_width_m=lane_width_m,
    )
