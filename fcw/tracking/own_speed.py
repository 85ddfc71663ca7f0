"""The own speed as the tracker takes it: what was given is exact, what the picture tells is smoothed first.

By how much we became faster goes straight into the closing speed of every vehicle. The picture's speed errs
by a few per cent, anew every half second (`fcw evaluate motion`): taken as it is, everything ahead would seem
to brake and to drive off.
"""

import math

ACCELERATION_SIGMA_MPS2 = 2.0
ACCELERATION_S = 2.0
"""Own acceleration and how long it lasts (Singer 1970)."""
ROUNDED_MPS = 0.15
"""Given speeds come in steps of about 1 km/h: our acceleration is learnt as if they were off by so much."""
ERRORS_LAST_S = 0.5
"""Correlation time of the picture's errors: a third is left after half a second on `kitti-odometry-03`."""
ROUGH_PART, ROUGH_MPS = 0.07, 0.7
"""A speed with a larger 1-sigma than this part of it, or this, tells no gain: its errors change by more than
the speed of a car does."""
HELD_MPS2 = 3.0
"""While no speed is told the last one is held, and becomes less sure at this rate."""
HELD_PART = 0.3
"""It is held until its 1-sigma is this part of it. If it were not held, what it says of other vehicles would
go at once, and their closing speeds would jump."""
JUMP_MPS = 3.0
"""A speed farther off than this and `JUMP_SIGMAS` is another one, and the old or the new one is wrong. About
the lag of the filter in the hardest braking (10 m/s^2)."""
JUMP_SIGMAS = 3.0
JUMPED_S = 0.5
"""Time for which another speed must be told before it is believed."""


class OwnSpeed:
    """Own speed and acceleration of one drive: a Kalman filter.

    Attributes:
        speed_mps: None when unknown.
        sigma_mps: 1-sigma; 0 where it was given.
        gain_sigma_mps: 1-sigma of by how much we became faster since the frame before; 0 where it was given.
    """

    def __init__(self) -> None:
        self.speed_mps: float | None = None
        self.sigma_mps = self.gain_sigma_mps = 0.0
        self._acceleration_mps2 = 0.0
        self._rough = False
        """Whether the speed is known roughly."""
        self._given = False
        """Whether the latest speed was given."""
        self._jumped_s = 0.0
        """For how long another speed has been told."""
        self._vv = self._va = 0.0
        self._aa = ACCELERATION_SIGMA_MPS2**2

    def update(self, dt_s: float, speed_mps: float | None, sigma_mps: float) -> float:
        """Take the own speed at a frame.

        A misread picture makes the speed jump. As a gain, the jump would enter the closing speeds of all
        vehicles; so it is left out until it has lasted, and the filter then starts anew from it. The same
        holds where a given speed follows the picture's, or the picture's a given one: the difference of their
        scales is no gain.

        Args:
            dt_s: since the frame before.
            speed_mps: None when unknown.
            sigma_mps: 1-sigma; 0 where it was given.

        Returns:
            By how much we became faster since the frame before, in m/s. Where that is unknown, as where the
            speed is known only roughly, the last acceleration fades out: dropped at once, it would pass for
            an acceleration of every vehicle.
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
            # By as much as the estimate was mended in this step its error changed.
            self.gain_sigma_mps = math.sqrt(max(vv - self._vv, 0.0))
        return self.speed_mps - before_mps

    def _hold(self, dt_s: float) -> None:
        """Nothing is told: the last speed becomes less sure, and is forgotten."""
        if self.speed_mps is None:
            return
        self._rough = True
        self.sigma_mps += HELD_MPS2 * dt_s
        if self.sigma_mps > HELD_PART * self.speed_mps:
            self.speed_mps = None

    def _begin(self, speed_mps: float, sigma_mps: float) -> None:
        """Know this speed and none of before; we became no faster by it."""
        self.speed_mps, self.sigma_mps = speed_mps, sigma_mps
        self._va = self._jumped_s = 0.0
        self._vv, self._aa = sigma_mps**2, ACCELERATION_SIGMA_MPS2**2
