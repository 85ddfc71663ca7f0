"""How we turn now, and how a vehicle that follows our path seems to move sideways as a result.

The path ahead may bend otherwise than here. Our present yaw rate makes a vehicle sweep across the picture,
and its own driving along the path moves it sideways too. With r the yaw rate, v and w our speed and its, h
the heading of the path at the camera, k its curvature at the vehicle, and x the distance,

    rate across = (h + k x) w - h v - r x

This is -(h + k x) (v - w) if the path bends as we turn, r = k v. We mostly drive along our path, so its
curvature is a second measurement of our yaw rate, and the better one if the first is poor.
"""

import math
from dataclasses import dataclass

from fcw.motion.state import OwnMotion, OwnPath

USUAL_MPS = 12.0
"""Assumed if the own speed is unknown; for the sweep across the picture it matters little."""
LARGEST_SIGMA_RADPS = math.radians(3.0)
"""A yaw rate with a larger 1-sigma is unknown: it tells no more than that we drive along our path."""
ALONG_PATH_MPS2 = 0.4
"""1-sigma of the difference between our lateral acceleration and that of our path here: a comfortable jerk of
0.5 m/s^3 over the 0.8 s by which the path is ahead of us (`fcw.motion.bend.turning`)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """Our turning now.

    Attributes:
        own_mps: own speed; `USUAL_MPS` if it is unknown.
        yaw_rate_radps: yaw rate, positive to the left.
        sigma_radps: 1-sigma of the yaw rate.
    """

    own_mps: float
    yaw_rate_radps: float
    sigma_radps: float = 0.0

    @property
    def measured_part(self) -> float:
        """Weight of the measured yaw rate, from 0 to 1; the rest is the weight of our path's curvature."""
        return 1 / (1 + (self.sigma_radps * self.own_mps / ALONG_PATH_MPS2) ** 2)

    def its_mps(self, closing_mps: float, oncoming: bool) -> float:
        """Speed of a vehicle along our path; at least 0 unless it surely comes towards us."""
        its_mps = self.own_mps - closing_mps
        return its_mps if oncoming else max(its_mps, 0.0)

    def rate_radps(self, path: OwnPath) -> float:
        """Our yaw rate: weighted mean of the measured one and of that by our path's curvature here."""
        part = self.measured_part
        return part * self.yaw_rate_radps + (1 - part) * path.curvature_per_m * self.own_mps


def turn_of(motion: OwnMotion) -> Turn | None:
    """Our turning by own motion; None if it is unknown. A given yaw rate is taken as exact."""
    sigma_radps = motion.yaw_rate_sigma_radps or 0.0
    if motion.yaw_rate_radps is None or sigma_radps > LARGEST_SIGMA_RADPS:
        return None
    return Turn(
        own_mps=USUAL_MPS if motion.speed_mps is None else motion.speed_mps,
        yaw_rate_radps=motion.yaw_rate_radps,
        sigma_radps=sigma_radps,
    )


def sweep_mps(
    path: OwnPath, turn: Turn | None, distance_m: float, closing_mps: float, oncoming: bool = False
) -> float:
    """Lateral speed to the left, as seen by us, of a vehicle that keeps its distance from our path.

    Args:
        path: our own path.
        turn: our turning; if None, we are assumed to turn as the path bends.
        distance_m: distance of the vehicle from the camera.
        closing_mps: its closing speed.
        oncoming: whether it surely comes towards us; see `Turn.its_mps`.
    """
    if turn is None:
        return -path.slope_at(distance_m) * closing_mps
    return (
        path.slope_at(distance_m) * turn.its_mps(closing_mps, oncoming)
        - path.heading_rad * turn.own_mps
        - turn.rate_radps(path) * distance_m
    )
