"""How the yaw rate changes: a driver who steers into a bend will soon be farther in it.

Roads are laid out, and driven, so that the curvature changes linearly along them (clothoids). The path ahead
is then no parabola. A parabola that meets it at the farthest relevant point has the curvature that is reached
after a third of the way, as follows from y''' x^3 / 6.
"""

import math

from fcw.motion.bend.turn import USUAL_MPS

JERK_MPS3 = 0.5
"""1-sigma of the lateral jerk at the beginning or end of a bend: noticeable, but still comfortable."""
SLOWEST_MPS = 5.0
"""Below this speed, the curvature changes no faster than at this speed."""
LASTS_S = 1.0
"""Correlation time of the change of the yaw rate (Singer 1970)."""
ERRORS_LAST_S = 0.3
"""Correlation time of the errors of the yaw rate."""
AHEAD_S = 0.8
"""A third of the 2 to 3 s before contact in which a warning is due."""
LONGEST_STEP_S = 2.0
"""After a longer gap, the filter starts anew."""


def growth_sigma_per_m2(speed_mps: float | None) -> float:
    """1-sigma of the change of a road's curvature per metre, given our speed on it (None when unknown)."""
    return JERK_MPS3 / max(USUAL_MPS if speed_mps is None else speed_mps, SLOWEST_MPS) ** 3


class Turning:
    """Kalman filter of the yaw rate and its change over one drive."""

    def __init__(self) -> None:
        self._time_ns: int | None = None
        self._rate_radps = self._change_radps2 = 0.0
        self._rr = self._rc = self._cc = 0.0

    def update(self, time_ns: int, speed_mps: float | None, rate_radps: float | None, sigma: float) -> float:
        """Update with speed and yaw rate (None when unknown) and the 1-sigma of the yaw rate, rad/s.

        Returns:
            Predicted change of the yaw rate in `AHEAD_S`, in rad/s; 0 if unknown.
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
