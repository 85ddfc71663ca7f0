"""How we turn now, and how what goes along our path moves across it, seen from a car that turns.

The path ahead may bend otherwise than where we are. What is seen of a vehicle sweeps by our turning now; that
it drives along the path, where it is, makes it move on across it. With r the yaw rate, v and w our speed and
its, h the heading of the path at the camera and k its curvature there ahead, and x the distance,

    rate across = (h + k x) w - h v - r x

which is -(h + k x) (v - w) where the path bends as we turn, r = k v. We mostly drive along our path: that is
a second measurement of our turning, and where the first is poor it is the better one.
"""

import math
from dataclasses import dataclass

from fcw.motion.state import OwnMotion, OwnPath

USUAL_MPS = 12.0
"""Taken where the own speed is unknown: of what is seen to sweep across the path it matters little."""
LARGEST_SIGMA_RADPS = math.radians(3.0)
"""What is known of our turning less well than this is no better than that we drive along our path."""
ALONG_PATH_MPS2 = 0.4
"""1-sigma of the lateral acceleration by which we turn otherwise than our path bends here: what a comfortable
jerk of 0.5 m/s^3 makes in the 0.8 s by which the path is ahead of us (`fcw.motion.bend.turning`)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """Our turning now.

    Attributes:
        own_mps: own speed; `USUAL_MPS` where it is unknown.
        yaw_rate_radps: positive to the left.
        sigma_radps: 1-sigma.
    """

    own_mps: float
    yaw_rate_radps: float
    sigma_radps: float = 0.0

    @property
    def measured_part(self) -> float:
        """How much what was measured counts, from 0 to 1; the rest is that we drive along our path."""
        return 1 / (1 + (self.sigma_radps * self.own_mps / ALONG_PATH_MPS2) ** 2)

    def its_mps(self, closing_mps: float, oncoming: bool) -> float:
        """Speed of a vehicle along our path; at least 0 unless it surely comes towards us."""
        its_mps = self.own_mps - closing_mps
        return its_mps if oncoming else max(its_mps, 0.0)

    def rate_radps(self, path: OwnPath) -> float:
        """Our yaw rate, weighted from the measured one and from how our path bends here."""
        part = self.measured_part
        return part * self.yaw_rate_radps + (1 - part) * path.curvature_per_m * self.own_mps


def turn_of(motion: OwnMotion) -> Turn | None:
    """The turning of own motion; None where it is not known. A yaw rate that was given is exact."""
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
    """Rate at which a vehicle that keeps its place beside the path moves to the left, as seen from us.

    Args:
        path: our own.
        turn: None takes the path to bend as we turn.
        distance_m: of the vehicle from the camera.
        closing_mps: rate at which that shrinks.
        oncoming: whether it surely comes towards us, see `Turn.its_mps`.
    """
    if turn is None:
        return -path.slope_at(distance_m) * closing_mps
    return (
        path.slope_at(distance_m) * turn.its_mps(closing_mps, oncoming)
        - path.heading_rad * turn.own_mps
        - turn.rate_radps(path) * distance_m
    )
