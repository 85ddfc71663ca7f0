"""How the bend grows: who steers into a bend will be farther in it in a moment.

Roads are laid out, and driven, so that the curvature grows steadily along them (clothoids). The way ahead is
then no parabola; the one that fits it at the farthest point that counts has the curvature that is reached
after a third of the way, as y''' x^3 / 6 says.
"""

import math

from fcw.motion.bend.turn import USUAL_MPS

JERK_MPS3 = 0.5
"""1-sigma of the jerk across the road while a bend begins or ends: felt, and still comfortable."""
SLOWEST_MPS = 5.0
"""Slower, nobody turns more quickly than at this speed."""
LASTS_S = 1.0
"""How long it lasts (Singer 1970)."""
ERRORS_LAST_S = 0.3
"""Correlation time of the errors of the yaw rate."""
AHEAD_S = 0.8
"""A third of the time in which a warning is due, 2 to 3 s."""
LONGEST_STEP_S = 2.0
"""After a longer gap all begins anew."""


def growth_sigma_per_m2(speed_mps: float | None) -> float:
    """1-sigma of how the curvature of a road grows along it, by our speed on it; None when unknown."""
    return JERK_MPS3 / max(USUAL_MPS if speed_mps is None else speed_mps, SLOWEST_MPS) ** 3


class Turning:
    """The change of the yaw rate of one drive: a Kalman filter."""

    def __init__(self) -> None:
        self._time_ns: int | None = None
        self._rate_radps = self._change_radps2 = 0.0
        self._rr = self._rc = self._cc = 0.0

    def update(self, time_ns: int, speed_mps: float | None, rate_radps: float | None, sigma: float) -> float:
        """Take speed and yaw rate at a time, None where unknown, and the 1-sigma of the yaw rate, rad/s.

        Returns:
            By how much the yaw rate will have changed in `AHEAD_S`, in rad/s; 0 where nothing is known.
        """
        if speed_mps is None or rate_radps is None:
            self._time_ns, self._change_radps2 = None, 0.0
            return 0.0
        dt_s = math.inf if self._time_ns is None else (time_ns - self._time_ns) / 1e9
        if dt_s > 0:
            self._time_ns = time_ns
            self._take(dt_s, rate_radps, sigma, JERK_MPS3 / max(speed_mps, SLOWEST_MPS))
        return self._change_radps2 * AHEAD_S

    def _take(self, dt_s: float, rate_radps: float, sigma: float, change_sigma: float) -> None:
        if dt_s > LONGEST_STEP_S:
            self._rate_radps, self._change_radps2 = rate_radps, 0.0
            self._rr, self._rc, self._cc = sigma**2, 0.0, change_sigma**2
            return
        lasting = math.exp(-dt_s / LASTS_S)
        rr = self._rr + 2 * dt_s * self._rc + dt_s**2 * self._cc
        rc = lasting * (self._rc + dt_s * self._cc)
        cc = lasting**2 * self._cc + change_sigma**2 * (1 - lasting**2)
        total = rr + sigma**2 * max(1.0, 2 * ERRORS_LAST_S / dt_s)
        predicted_radps = self._rate_radps + self._change_radps2 * dt_s
        off_radps = rate_radps - predicted_radps
        self._rate_radps = predicted_radps + rr / total * off_radps
        self._change_radps2 = lasting * self._change_radps2 + rc / total * off_radps
        self._rr, self._rc, self._cc = rr * (1 - rr / total), rc * (1 - rr / total), cc - rc**2 / total
