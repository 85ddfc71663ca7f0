"""A grid of speeds that accumulates the evidence of pairs of pictures.

A histogram filter (Thrun, Burgard & Fox 2005, "Probabilistic Robotics", section 4.1).
"""

import math

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray

SPEEDS_MPS = np.arange(0.0, 52.0, 0.5)
FASTEST_MPS = 47.0
"""Faster speeds are too close to the end of the grid."""
ACCELERATION_MPS2 = 3.0
WALK_MPS = 0.7
"""Random walk of the speed: 1-sigma after one second, whatever the rate of the pairs.

When the settings here were chosen it depended on the rate; this is its value at 12 to 15 pairs per second.
"""
WEIGHT_PER_S = 400.0
"""Log odds per second of a correlation of 1."""
REMEMBERED_S = 1.0
"""Time constant with which evidence is forgotten."""
LEAST_CORRELATION = 0.2
"""Least mean correlation over `REMEMBERED_S`. Below it, a speed may be found by chance."""
SURE_PART, SURE_MPS = 0.08, 0.4
"""The grid has found a speed while its 1-sigma is less than the first, as a fraction of it, or the second."""
LASTS_S = 0.6
"""A speed must have been found for this long before it is used."""


class SpeedGrid:
    """Probability distribution of a speed on a grid.

    Args:
        slowest_mps: slower speeds are not reported.
    """

    def __init__(self, slowest_mps: float) -> None:
        self._slowest_mps = slowest_mps
        self._log_odds = np.zeros(len(SPEEDS_MPS))
        self._correlation = np.zeros(len(SPEEDS_MPS))
        self._lasted_s = 0.0

    def update(self, correlation: FloatArray, dt_s: float) -> Gaussian | None:
        """Update with a pair of pictures, and return the speed; None if it is not certain.

        Args:
            correlation: (speeds,) correlation of the two pictures at each speed, at most 1.
            dt_s: time since the previous pair.
        """
        lasting = math.exp(-dt_s / REMEMBERED_S)
        self._log_odds = _spread(lasting * self._log_odds, WALK_MPS * math.sqrt(dt_s))
        self._log_odds += WEIGHT_PER_S * dt_s * np.maximum(correlation, 0.0)
        self._correlation = lasting * self._correlation + (1 - lasting) * correlation
        found = self._found()
        self._lasted_s = 0.0 if found is None else self._lasted_s + dt_s
        return found if self._lasted_s >= LASTS_S else None

    def _found(self) -> Gaussian | None:
        odds = np.exp(self._log_odds - self._log_odds.max())
        odds /= odds.sum()
        mean_mps = float(odds @ SPEEDS_MPS)
        sigma_mps = math.sqrt(float(odds @ (SPEEDS_MPS - mean_mps) ** 2))
        sure = sigma_mps < max(SURE_PART * mean_mps, SURE_MPS) and self._slowest_mps < mean_mps < FASTEST_MPS
        seen = float(np.interp(mean_mps, SPEEDS_MPS, self._correlation)) > LEAST_CORRELATION
        return Gaussian(mean_mps, sigma_mps) if sure and seen else None


def _spread(log_odds: FloatArray, sigma_mps: float) -> FloatArray:
    """The distribution after a random change of the speed.

    The kernel is the discrete Gaussian (Lindeberg 1990), made from its Fourier transform, whose variance is
    exact however narrow it is.
    """
    reach, step_mps = 4, SPEEDS_MPS[1] - SPEEDS_MPS[0]
    waves = np.linspace(0.0, math.pi, 4 * reach + 1)
    transform = np.exp((sigma_mps / step_mps) ** 2 * (np.cos(waves) - 1))
    kernel = np.fft.irfft(transform)[np.arange(-reach, reach + 1)]
    odds = np.exp(log_odds - log_odds.max())
    spread = np.convolve(np.pad(odds, reach, mode="edge"), kernel / kernel.sum(), "valid")
    return np.log(spread + 1e-12)
