"""How fast the bearing of a vehicle changes.

A vehicle that comes nearer at a constant bearing is on a collision course. An error of the distance shifts
the lateral position, and for a vehicle far to the side that looks like motion. The bearing does not depend on
the distance. Modified polar coordinates: Aidala & Hammel 1983, "Utilization of modified polar coordinates for
bearings-only tracking".
"""

import math

from fcw.tracking.across.place_filter import PlaceFilter

ACROSS_SIGMA_MPS = 3.0
"""1-sigma of the speed of a newly found vehicle across the line of sight."""
JERKINESS_M2PS3 = 0.9
"""Spectral density of its acceleration across the line of sight. For this and the sigma above, no other
values were tried."""


class BearingFilter(PlaceFilter):
    """Filter of one vehicle's bearing and its rate, without our own turning.

    Args:
        bearing: bearing of its first box, as lateral position over distance, positive to the left.
        sigma: 1-sigma of the bearing.
        distance_m: distance of the vehicle from the camera.
        turn_radps: our yaw rate, positive to the left; None when unknown.
    """

    def __init__(
        self, bearing: float, sigma: float, distance_m: float, turn_radps: float | None = None
    ) -> None:
        super().__init__(bearing, sigma, 0.0, ACROSS_SIGMA_MPS / distance_m)
        self._distance_m, self._turn_radps = distance_m, turn_radps

    @property
    def across_sigma_mps(self) -> float:
        """1-sigma of `across_mps`, if distance and closing speed are right."""
        return math.sqrt(max(self._rate_variance, 0.0)) * self._distance_m

    def across_mps(self, lateral_m: float, closing_mps: float, distance_m: float) -> float | None:
        """Lateral speed to the left as seen by the camera, including our turning; None if that is unknown.

        At a constant bearing, the lateral position shrinks in proportion to the distance.

        Args:
            lateral_m: its lateral position, positive to the left.
            closing_mps: its closing speed.
            distance_m: its distance from the camera.
        """
        if self._turn_radps is None:
            return None
        return (self._rate - self._turn_radps) * distance_m - lateral_m * closing_mps / distance_m

    def predict(self, dt_s: float, turn_radps: float | None, closing_mps: float, distance_m: float) -> None:
        """Predict the bearing at the next frame.

        If lateral position and distance change at constant speeds, the bearing changes faster the nearer the
        vehicle is.

        Args:
            dt_s: time since the last frame.
            turn_radps: our yaw rate, positive to the left; None when unknown. While it is unknown, the
                filtered rate includes it: the last known value is added, and the next known one subtracted.
            closing_mps: closing speed of the vehicle.
            distance_m: its distance from the camera.
        """
        if (turn_radps is None) != (self._turn_radps is None):
            self._rate += (turn_radps or 0.0) - (self._turn_radps or 0.0)
        self._distance_m, self._turn_radps = distance_m, turn_radps
        grows = 1 + 2 * dt_s * max(closing_mps, 0.0) / distance_m
        self._place += (self._rate - (turn_radps or 0.0)) * dt_s
        self._rate *= grows
        self._widen(dt_s, JERKINESS_M2PS3 / distance_m**2, grows)
