"""Lateral position and lateral speed of a vehicle.

The noise of its box, in metres, grows with the distance, so a far vehicle needs more averaging. The gain of a
Kalman filter takes care of that.
"""

import math

from fcw.tracking.across.place_filter import PlaceFilter

RATE_SIGMA_MPS = 1.5
"""1-sigma of the lateral speed of a newly found vehicle: a lane change, or a standing object beside a
bend."""
WRONG_BEFORE_PART = 0.75
"""When the log distance is corrected, this fraction of the correction is taken as an old error; the rest came
from a wrong closing speed since. Chosen of 0.5, 0.75, 0.85 and 1 like `JUMP_SIGMAS`
(`fcw/tracking/across/place_filter.py`). Since then, 0.5 is chosen with seven of eleven sequences left out,
and is better by 0.6 %."""
SLOWING_S = 0.35
"""A rate slows down if it is smaller than its mean over this time. It is short, because a vehicle that brakes
at a crossing must be recognised before it stands. Chosen of 0.35 and 0.5 s on simulated cars that do so
(docs/figures/warning.md, "Who stops at a crossing")."""
JERKINESS_M2PS3 = 0.3
"""Spectral density of the lateral acceleration. A lane change reaches 1 m/s^2 for half a second, and so does
our own turning, if it is unknown, for vehicles ahead."""


class LateralFilter(PlaceFilter):
    """Filter of one vehicle's lateral position and its rate.

    While we turn, everything ahead sweeps across the picture, faster the farther away it is, and stops as
    soon as we stop turning. No filter of the vehicle's motion could follow that. So the sweep is an input,
    and the filter estimates only the rest of the rate.

    Args:
        lateral_m: lateral position by its first box, positive to the left.
        sigma_m: 1-sigma of that.
        sweep_mps: rate at which an object at this distance seems to move to the left because we turn; None
            when unknown.
    """

    def __init__(self, lateral_m: float, sigma_m: float, sweep_mps: float | None = None) -> None:
        super().__init__(lateral_m, sigma_m, sweep_mps or 0.0, RATE_SIGMA_MPS)
        self._sweep_mps = sweep_mps
        self._mean_mps = 0.0
        """Mean of its own rate, without the sweep, over the last `SLOWING_S`."""

    @property
    def lateral_m(self) -> float:
        """Lateral position, positive to the left."""
        return self._place

    @property
    def rate_mps(self) -> float:
        """Lateral speed, including the effect of our turning."""
        return self._rate

    @property
    def own_mps(self) -> float:
        """Its own lateral speed, without the effect of our turning if that is known."""
        return self.rate_mps - (self._sweep_mps or 0.0)

    @property
    def slowing_mps2(self) -> float:
        """Lower bound (1 sigma) of its own lateral deceleration; 0 if our turning may be the cause."""
        if self._sweep_mps is None:
            return 0.0
        slower_mps = math.copysign(1.0, self.own_mps) * (self._mean_mps - self.own_mps)
        return max(slower_mps - self.rate_sigma_mps, 0.0) / SLOWING_S

    @property
    def sigma_m(self) -> float:
        """1-sigma of the position."""
        return math.sqrt(self._place_variance)

    @property
    def rate_sigma_mps(self) -> float:
        """1-sigma of the rate."""
        return math.sqrt(self._rate_variance)

    def predict(self, dt_s: float, sweep_mps: float | None = None) -> None:
        """Predict the next frame with its sweep. A sweep that was unknown before remains part of the rate."""
        gain = 1.0
        if sweep_mps is not None and self._sweep_mps is not None:
            self._rate += sweep_mps - self._sweep_mps
            gain = 1 - math.exp(-dt_s / SLOWING_S) if self._settled else 1.0
        self._sweep_mps = sweep_mps
        self._mean_mps += gain * (self.own_mps - self._mean_mps)
        self._place += self._rate * dt_s
        self._widen(dt_s, JERKINESS_M2PS3)

    def scale(self, factor: float) -> None:
        """Scale the position when the distance turns out to be `factor` times the predicted one.

        Otherwise the correction of the distance would look like lateral motion. Only a part of it is applied
        (`WRONG_BEFORE_PART`): the rest is due to a wrong closing speed, and would seem to move standing
        objects beside our path.
        """
        self._place *= factor**WRONG_BEFORE_PART
