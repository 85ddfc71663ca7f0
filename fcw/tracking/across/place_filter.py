"""A Kalman filter of a position and its rate in which a jump does not count as motion.

The acceleration is white noise (Bar-Shalom, Li & Kirubarajan 2001, section 6.3.2).
"""

JUMP_SIGMAS = 6.0
"""A measurement this far from the prediction is a jump, not motion: another part of the vehicle was boxed, or
another vehicle. Chosen of 3, 4 and 6 by the lateral speed alone, whichever sequence of KITTI tracking was
left out (`benchmarks/tracking/lateral_gates.py`), before our turning became an input; since then 4 is as
good."""
SETTLING_S = 0.25
"""Time after which the rate of a new vehicle is settled. Until then, a measurement far off counts as motion.
Chosen of 0.25, 0.5 and 1 s in the same way."""


class PlaceFilter:
    """Estimate of a position and its rate with their covariance; subclasses add the prediction.

    Args:
        place: first position, in any unit.
        sigma: 1-sigma of the position.
        rate: first rate.
        rate_sigma: 1-sigma of the rate.
    """

    def __init__(self, place: float, sigma: float, rate: float, rate_sigma: float) -> None:
        self._place, self._rate = place, rate
        self._place_variance, self._shared = sigma**2, 0.0
        self._rate_variance = self._first_variance = rate_sigma**2
        self._settled_s = 0.0
        """How long the rate has been estimated."""
        self._jumped = False

    @property
    def _settled(self) -> bool:
        """Whether the rate has been estimated for long enough."""
        return self._settled_s >= SETTLING_S

    def _widen(self, dt_s: float, density: float, grows: float = 1.0) -> None:
        """Widen the covariance for a prediction.

        Args:
            dt_s: time that has passed.
            density: spectral density of the acceleration.
            grows: factor by which the rate and its error have grown meanwhile.
        """
        self._settled_s += dt_s
        by_rate = 2 * dt_s * self._shared + dt_s**2 * self._rate_variance
        self._place_variance += by_rate + density * dt_s**3 / 3
        self._shared = (self._shared + dt_s * self._rate_variance) * grows + density * dt_s**2 / 2
        self._rate_variance = self._rate_variance * grows**2 + density * dt_s

    def displace(self, place: float, sigma: float) -> None:
        """Set the position and its 1-sigma; the change is no motion, as when another part is seen."""
        self._place, self._place_variance, self._shared = place, sigma**2, 0.0

    def correct(self, place: float, sigma: float) -> None:
        """Update with a measured position and its 1-sigma.

        One jump leaves the rate as it is. After two in a row, the rate is as uncertain as at the start.
        """
        total, off = self._place_variance + sigma**2, place - self._place
        if self._settled and off**2 > JUMP_SIGMAS**2 * total:
            if self._jumped:
                self._rate_variance, self._settled_s = self._first_variance, 0.0
            self._jumped = True
            self.displace(place, sigma)
            return
        self._jumped = False
        gain, rate_gain = self._place_variance / total, self._shared / total
        self._place += gain * off
        self._rate += rate_gain * off
        self._rate_variance -= rate_gain * self._shared
        self._shared *= 1 - gain
        self._place_variance *= 1 - gain
