"""A place and its rate: a Kalman filter to which a jump is no motion.

The acceleration is white noise (Bar-Shalom, Li & Kirubarajan 2001, section 6.3.2).
"""

JUMP_SIGMAS = 6.0
"""What is this far from where it was expected has not moved there: another part of it was boxed, or another
vehicle. Of 3, 4 and 6 chosen by the lateral speed alone, whichever sequence of KITTI tracking was left out
(`benchmarks/tracking/lateral_gates.py`), before the filter was told how we turn; since then 4 is as good."""
SETTLING_S = 0.25
"""In so long the rate of a vehicle just found is learnt; until then what is far off has moved there. Of 0.25,
0.5 and 1 s chosen likewise."""


class PlaceFilter:
    """A place, its rate, and how well both are known; subclasses say how they go on.

    Args:
        place: the first one, in any unit.
        sigma: 1-sigma of it.
        rate: at which it changes.
        rate_sigma: 1-sigma of that.
    """

    def __init__(self, place: float, sigma: float, rate: float, rate_sigma: float) -> None:
        self._place, self._rate = place, rate
        self._place_variance, self._shared = sigma**2, 0.0
        self._rate_variance = self._first_variance = rate_sigma**2
        self._settled_s = 0.0
        """For how long the rate has been learnt."""
        self._jumped = False

    @property
    def _settled(self) -> bool:
        """Whether the rate has been learnt."""
        return self._settled_s >= SETTLING_S

    def _widen(self, dt_s: float, density: float, grows: float = 1.0) -> None:
        """Less is known after dt.

        Args:
            dt_s: time that has passed.
            density: spectral density of the acceleration.
            grows: factor by which the rate, and what is wrong with it, has grown meanwhile.
        """
        self._settled_s += dt_s
        by_rate = 2 * dt_s * self._shared + dt_s**2 * self._rate_variance
        self._place_variance += by_rate + density * dt_s**3 / 3
        self._shared = (self._shared + dt_s * self._rate_variance) * grows + density * dt_s**2 / 2
        self._rate_variance = self._rate_variance * grows**2 + density * dt_s

    def displace(self, place: float, sigma: float) -> None:
        """Take a place, with its 1-sigma, without any motion to it, as where another part is seen."""
        self._place, self._place_variance, self._shared = place, sigma**2, 0.0

    def correct(self, place: float, sigma: float) -> None:
        """Take a measured place and its 1-sigma.

        One jump leaves the rate as it is; after two in a row the rate is as uncertain as at first.
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
