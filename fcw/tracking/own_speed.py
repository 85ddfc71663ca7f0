"""The own speed as used by the tracker: a given one is exact, one estimated from the picture is smoothed.

Every change of our speed goes straight into the closing speed of every vehicle. The speed from the picture is
off by a few per cent, by another amount every half second (`fcw evaluate motion`). Without smoothing, all
vehicles ahead would seem to brake and to drive off.
"""

import math

ACCELERATION_SIGMA_MPS2 = 2.0
ACCELERATION_S = 2.0
"""1-sigma and correlation time of our acceleration (Singer 1970)."""
ROUNDED_MPS = 0.15
"""1-sigma assumed for given speeds when learning our acceleration, as they may be rounded to 1 km/h."""
ERRORS_LAST_S = 0.5
"""Correlation time of the errors from the picture: a third is left after half a second on
`kitti-odometry-03`."""
ROUGH_PART, ROUGH_MPS = 0.07, 0.7
"""A speed is rough if its 1-sigma exceeds this fraction of it, and this. Its changes are then not used, as
its error changes by more than the speed of a car does."""
HELD_MPS2 = 3.0
"""While no speed is known, the last one is held, and its 1-sigma grows at this rate."""
HELD_PART = 0.3
"""The last speed is held until its 1-sigma is this fraction of it. If it were dropped at once, the closing
speeds of other vehicles would jump."""
JUMP_MPS = 3.0
"""A speed that differs from the predicted one by more than this and `JUMP_SIGMAS` is a jump: the old or the
new one is wrong. This is about the lag of the filter in the hardest braking (10 m/s^2)."""
JUMP_SIGMAS = 3.0
JUMPED_S = 0.5
"""How long a jump must last before the new speed is used."""


class OwnSpeed:
    """Kalman filter of own speed and acceleration over one drive.

    Attributes:
        speed_mps: own speed; None when unknown.
        sigma_mps: 1-sigma of the speed; 0 if it was given.
        gain_sigma_mps: 1-sigma of the change of the speed since the previous frame; 0 if it was given.
    """

    def __init__(self) -> None:
        self.speed_mps: float | None = None
        self.sigma_mps = self.gain_sigma_mps = 0.0
        self._acceleration_mps2 = 0.0
        self._rough = False
        """Whether the latest speed is rough; see `ROUGH_PART`."""
        self._given = False
        """Whether the latest speed was given."""
        self._jumped_s = 0.0
        """How long the measured speed has differed by a jump."""
        self._vv = self._va = 0.0
        self._aa = ACCELERATION_SIGMA_MPS2**2

    def update(self, dt_s: float, speed_mps: float | None, sigma_mps: float) -> float:
        """Update with the own speed at a frame.

        A misread picture makes the speed jump, and the jump would enter the closing speeds of all vehicles.
        So it is ignored until it has lasted, and the filter then starts anew from the new speed. The filter
        also starts anew when a given speed replaces one from the picture or the other way round, as the
        difference of their scales is no acceleration.

        Args:
            dt_s: time since the previous frame.
            speed_mps: measured speed; None when unknown.
            sigma_mps: its 1-sigma; 0 if it was given.

        Returns:
            Change of our speed since the previous frame, in m/s. If that is unknown or only roughly known,
            the last acceleration fades out: dropped at once, it would look like an acceleration of every
            vehicle.
        """
        before_mps, self.gain_sigma_mps = self.speed_mps, 0.0
        lasting, coasted_mps = math.exp(-dt_s / ACCELERATION_S), self._acceleration_mps2 * dt_s
        self._acceleration_mps2 *= lasting
        if speed_mps is None:
            self._hold(dt_s)
            return coasted_mps
        was_rough, self._rough = self._rough, sigma_mps > max(ROUGH_PART * speed_mps, ROUGH_MPS)
        was_given, self._given = self._given, sigma_mps == 0
        if before_mps is None or self._rough or was_rough or self._given != was_given:
            self._begin(speed_mps, sigma_mps)
            return coasted_mps
        predicted_mps = before_mps + coasted_mps
        off_mps = speed_mps - predicted_mps
        near_mps = JUMP_MPS + JUMP_SIGMAS * math.hypot(self.sigma_mps, sigma_mps)
        jumped = sigma_mps > 0 and abs(off_mps) > near_mps
        self._jumped_s = self._jumped_s + dt_s if jumped else 0.0
        if self._jumped_s > JUMPED_S:
            self._begin(speed_mps, sigma_mps)
            return coasted_mps
        vv = self._vv + 2 * dt_s * self._va + dt_s**2 * self._aa
        va = lasting * (self._va + dt_s * self._aa)
        aa = lasting**2 * self._aa + ACCELERATION_SIGMA_MPS2**2 * (1 - lasting**2)
        noise = math.inf if jumped else sigma_mps**2 * max(1.0, 2 * ERRORS_LAST_S / max(dt_s, 1e-6))
        gain = vv / (vv + noise) if vv + noise > 0 else 1.0
        acceleration_gain = va / (vv + max(noise, ROUNDED_MPS**2))
        self.speed_mps = predicted_mps + gain * off_mps
        self._acceleration_mps2 += acceleration_gain * off_mps
        self._vv, self._va, self._aa = (1 - gain) * vv, (1 - gain) * va, aa - acceleration_gain * va
        self.sigma_mps = math.sqrt(max(self._vv, 0.0))
        if sigma_mps:
            # The error of the estimate changed by as much as this step corrected it.
            self.gain_sigma_mps = math.sqrt(max(vv - self._vv, 0.0))
        return self.speed_mps - before_mps

    def _hold(self, dt_s: float) -> None:
        """Without a measurement, the last speed becomes less certain and is finally forgotten."""
        if self.speed_mps is None:
            return
        self._rough = True
        self.sigma_mps += HELD_MPS2 * dt_s
        if self.sigma_mps > HELD_PART * self.speed_mps:
            self.speed_mps = None

    def _begin(self, speed_mps: float, sigma_mps: float) -> None:
        """Start anew from this speed. The difference to the last one is no acceleration."""
        self.speed_mps, self.sigma_mps = speed_mps, sigma_mps
        self._va = self._jumped_s = 0.0
        self._vv, self._aa = sigma_mps**2, ACCELERATION_SIGMA_MPS2**2
