"""Kalman filter for distance and closing speed of one vehicle.

An extended Kalman filter in modified polar coordinates (Aidala & Hammel 1983, made for ranging by angles
alone), here with size in place of angle. The state is

    l = log D          D: distance from the camera in metres
    r = V / D          V: closing speed; r is one over the time to contact with the camera
    c = log(D w)       w: width of the box in pixels; constant while the vehicle shows the same rear

so that the width measurement log w = c - l is linear, a change of scale gives r without any
calibration (Dagan et al. 2004), and the row measurement 1/D = exp(-l) has its own honest noise.
"""

import math
from dataclasses import dataclass

from fcw.tracking.ranging import BoxNoise, RowMeasurement


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionNoise:
    """What the filter believes of motion and of the camera's pitch.

    Attributes:
        acceleration_psd_m2ps3: white-noise intensity of the relative acceleration. Manoeuvres of 2.2 m/s^2
            (1 sigma; hard braking is 3) that last about a second have 2 sigma^2 tau = 10 (Singer 1970).
        initial_closing_sigma_mps: closing speed of a vehicle just found: 2 sigma is a standing one met
            at 108 km/h.
        width_drift_per_sqrt_s: relative drift in one second of the box's width that is no change of distance:
            another aspect, and the detector's liking for some scales.
        bounce_sigma_rad: pitch of the body on its springs, which averages out.
        bounce_correlation_s: how long one such deviation lasts.
        slope_sigma_rad: pitch against the road that stays, as load and slopes make it. No filter averages
            it out, so it is in the interval of the distance and not in the filter. Bounce and slope are what
            the best static row map leaves on KITTI's tracking sequences, 0.25 degrees.
    """

    acceleration_psd_m2ps3: float = 10.0
    initial_closing_sigma_mps: float = 15.0
    width_drift_per_sqrt_s: float = 0.06
    bounce_sigma_rad: float = math.radians(0.25)
    bounce_correlation_s: float = 0.3
    slope_sigma_rad: float = math.radians(0.25)


OUTLIER_SIGMAS = 3.0
"""A measurement farther off than this counts as if it were just this far off (Huber), so that one wild
box moves little and a persistent one still wins."""
STRONGEST_SHRINK = 0.2
"""One prediction step leaves at least this part of the distance: the gap never turns negative."""


def _white(variance: float, correlation_s: float, dt_s: float) -> float:
    """Variance of white noise at intervals dt that averages down as slowly as correlated noise does."""
    return variance * max(1.0, 2 * correlation_s / dt_s)


class RangeFilter:
    """Distance from the camera, closing speed and width constant of one vehicle."""

    def __init__(
        self,
        row: RowMeasurement,
        width_px: float,
        log_width_sigma: float,
        camera_height_m: float,
        box_noise: BoxNoise,
        motion: MotionNoise,
    ) -> None:
        self._box_noise = box_noise
        self._motion = motion
        self._camera_height_m = camera_height_m
        self._bounce_variance = (motion.bounce_sigma_rad / camera_height_m) ** 2
        inverse_variance = row.sigma_per_m**2 + self._bounce_variance
        # A row within 1 sigma of the horizon only says: that far at least.
        distance_m = 1 / max(row.inverse_distance_per_m, math.sqrt(inverse_variance))
        variance = inverse_variance * distance_m**2
        self._l = math.log(distance_m)
        self._r = 0.0
        self._c = math.log(width_px) + self._l
        # Covariance, upper triangle.
        self._ll, self._lr, self._lc = variance, 0.0, variance
        self._rr, self._rc = (motion.initial_closing_sigma_mps / distance_m) ** 2, 0.0
        self._cc = variance + log_width_sigma**2

    @property
    def distance_m(self) -> float:
        """Distance from the camera."""
        return math.exp(self._l)

    @property
    def log_distance_sigma(self) -> float:
        """1-sigma of the logarithm of the distance, that is of the distance in relative terms."""
        slope = self._motion.slope_sigma_rad / self._camera_height_m * self.distance_m
        return math.hypot(math.sqrt(self._ll), slope)

    @property
    def closing_speed_mps(self) -> float:
        """Rate at which the distance shrinks."""
        return self._r * self.distance_m

    def closing_speed_sigma_mps(self, log_distance_sigma: float) -> float:
        """1-sigma of the closing speed V = r D, given that of log D (the calibration's part included)."""
        relative = self._rr + 2 * self._r * self._lr + (self._r * log_distance_sigma) ** 2
        return self.distance_m * math.sqrt(max(relative, 0.0))

    def predict(self, dt_s: float) -> float:
        """Move on by dt at constant closing speed; returns the factor by which the picture of it grew."""
        shrink = max(1 - self._r * dt_s, STRONGEST_SHRINK)
        self._l += math.log(shrink)
        self._r /= shrink
        # Jacobian: dl'/dr = -dt / shrink, dr'/dr = 1 / shrink^2.
        a, b = -dt_s / shrink, shrink**-2
        noise = self._motion.acceleration_psd_m2ps3 * math.exp(-2 * self._l)
        self._ll += 2 * a * self._lr + a * a * self._rr + noise * dt_s**3 / 3
        self._lr = (self._lr + a * self._rr) * b - noise * dt_s**2 / 2
        self._lc += a * self._rc
        self._rr = b * b * self._rr + noise * dt_s
        self._rc *= b
        self._cc += self._motion.width_drift_per_sqrt_s**2 * dt_s
        return 1 / shrink

    def update_row(self, row: RowMeasurement, dt_s: float) -> None:
        """Take a row measurement, dt after the one before."""
        predicted = math.exp(-self._l)
        variance = _white(row.sigma_per_m**2, self._box_noise.correlation_s, dt_s)
        variance += _white(self._bounce_variance, self._motion.bounce_correlation_s, dt_s)
        self._update(-predicted, 0.0, row.inverse_distance_per_m - predicted, variance)

    def update_width(self, width_px: float, log_width_sigma: float, dt_s: float) -> None:
        """Take the width of the box, dt after the one before."""
        variance = _white(log_width_sigma**2, self._box_noise.correlation_s, dt_s)
        self._update(-1.0, 1.0, math.log(width_px) - (self._c - self._l), variance)

    def _update(self, h_l: float, h_c: float, residual: float, variance: float) -> None:
        """Scalar Kalman update for a measurement with the Jacobian (h_l, 0, h_c)."""
        ph_l = self._ll * h_l + self._lc * h_c
        ph_r = self._lr * h_l + self._rc * h_c
        ph_c = self._lc * h_l + self._cc * h_c
        s = max(h_l * ph_l + h_c * ph_c + variance, (residual / OUTLIER_SIGMAS) ** 2)
        gain = residual / s
        self._l += ph_l * gain
        self._r += ph_r * gain
        self._c += ph_c * gain
        self._ll -= ph_l * ph_l / s
        self._lr -= ph_l * ph_r / s
        self._lc -= ph_l * ph_c / s
        self._rr -= ph_r * ph_r / s
        self._rc -= ph_r * ph_c / s
        self._cc -= ph_c * ph_c / s
