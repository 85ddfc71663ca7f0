"""Where a vehicle is across the road, and how fast it moves there.

The farther it is, the more metres the noise of its box is, and the longer must be averaged: the gain of a
Kalman filter follows from both.
"""

import math

from fcw.tracking.across.place_filter import PlaceFilter

RATE_SIGMA_MPS = 1.5
"""1-sigma of the rate of a vehicle just found: a change of lane, or what stands beside a road that bends."""
WRONG_BEFORE_PART = 0.75
"""The part of the error of a distance (of its logarithm) that it had before; the rest came with the closing
speed since. Of 0.5, 0.75, 0.85 and 1 chosen as `JUMP_SIGMAS` was (`fcw/tracking/across/place_filter.py`);
since then 0.5 is chosen with seven of eleven sequences left out, and is better by 0.6 %."""
SLOWING_S = 0.35
"""A rate slows if it is smaller than its mean over this time: that somebody brakes at a crossing must be
known before he stands. Of 0.35 and 0.5 s chosen on simulated cars that do (docs/figures/warning.md, "Who
stops at a crossing")."""
JERKINESS_M2PS3 = 0.3
"""Spectral density of the acceleration across the road: a change of lane reaches 1 m/s^2 for half a second,
and so does our own turning, where it is not known, for vehicles ahead."""


class LateralFilter(PlaceFilter):
    """One vehicle's lateral position and its rate.

    While we turn, what is ahead sweeps across the picture, the faster the farther it is, and stops as soon as
    we do. No filter of its motion could follow that. So the filter is told this sweep, and learns only the
    rest of the rate.

    Args:
        lateral_m: by its first box, positive to the left.
        sigma_m: 1-sigma of that.
        sweep_mps: rate at which a thing at this distance that keeps its place beside our path moves to the
            left because we turn; None where it is not known.
    """

    def __init__(self, lateral_m: float, sigma_m: float, sweep_mps: float | None = None) -> None:
        super().__init__(lateral_m, sigma_m, sweep_mps or 0.0, RATE_SIGMA_MPS)
        self._sweep_mps = sweep_mps
        self._mean_mps = 0.0
        """Its own rate, the sweep aside, in the mean of the last `SLOWING_S`."""

    @property
    def lateral_m(self) -> float:
        """The position, positive to the left."""
        return self._place

    @property
    def rate_mps(self) -> float:
        """The rate, our turning included."""
        return self._rate

    @property
    def own_mps(self) -> float:
        """Its own rate, as far as we know how we turn."""
        return self.rate_mps - (self._sweep_mps or 0.0)

    @property
    def slowing_mps2(self) -> float:
        """How fast its own rate slows at least (by 1 sigma); 0 where our turning may be the cause."""
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
        """Move on by dt, with the present sweep; one that was not known before stays part of the rate."""
        gain = 1.0
        if sweep_mps is not None and self._sweep_mps is not None:
            self._rate += sweep_mps - self._sweep_mps
            gain = 1 - math.exp(-dt_s / SLOWING_S) if self._settled else 1.0
        self._sweep_mps = sweep_mps
        self._mean_mps += gain * (self.own_mps - self._mean_mps)
        self._place += self._rate * dt_s
        self._widen(dt_s, JERKINESS_M2PS3)

    def scale(self, factor: float) -> None:
        """Scale the position in part, where the distance turns out to be `factor` times the expected one.

        This is no motion: without it, an error of the distance would pass for one. The rest of the factor
        comes from a wrong closing speed; applied as well, it would seem to move what stands beside our path.
        """
        self._place *= factor**WRONG_BEFORE_PART
