"""How fast a vehicle's bearing changes: what keeps it and comes nearer is on a collision course.

A place across the road errs with the distance, and where the vehicle is far aside that looks like a motion;
its bearing does not hang on it. Modified polar coordinates: Aidala & Hammel 1983, "Utilization of modified
polar coordinates for bearings-only tracking".
"""

import math

from fcw.tracking.across.place_filter import PlaceFilter

ACROSS_SIGMA_MPS = 3.0
"""1-sigma of how a vehicle just found leaves its bearing, as a speed across its line of sight."""
JERKINESS_M2PS3 = 0.9
"""Spectral density of its acceleration across its line of sight. This and the sigma above were taken at once;
no other values were tried."""


class BearingFilter(PlaceFilter):
    """Filter of one vehicle's bearing and of its rate, with our own turning taken out.

    Args:
        bearing: of its first box, as lateral position over distance, positive to the left.
        sigma: 1-sigma of that.
        distance_m: of the vehicle from the camera.
        turn_radps: our yaw rate, positive to the left; None where it is not known.
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
        """Rate at which it moves to the left as we see it, our turning included; None if that is not known.

        A vehicle at a constant bearing comes nearer across the road in proportion to how it does along it.

        Args:
            lateral_m: its place, positive to the left.
            closing_mps: rate at which it comes nearer along the road.
            distance_m: of it from the camera.
        """
        if self._turn_radps is None:
            return None
        return (self._rate - self._turn_radps) * distance_m - lateral_m * closing_mps / distance_m

    def predict(self, dt_s: float, turn_radps: float | None, closing_mps: float, distance_m: float) -> None:
        """Move on by dt.

        Where lateral position and distance change steadily, their ratio changes the faster the nearer the
        vehicle is.

        Args:
            dt_s: time since the last frame.
            turn_radps: our yaw rate, positive to the left; None where it is not known. Then the filtered rate
                contains it: the last known value is put in, and the next known one is taken out.
            closing_mps: closing speed of the vehicle.
            distance_m: of it from the camera.
        """
        if (turn_radps is None) != (self._turn_radps is None):
            self._rate += (turn_radps or 0.0) - (self._turn_radps or 0.0)
        self._distance_m, self._turn_radps = distance_m, turn_radps
        grows = 1 + 2 * dt_s * max(closing_mps, 0.0) / distance_m
        self._place += (self._rate - (turn_radps or 0.0)) * dt_s
        self._rate *= grows
        self._widen(dt_s, JERKINESS_M2PS3 / distance_m**2, grows)
