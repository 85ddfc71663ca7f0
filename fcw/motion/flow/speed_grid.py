"""A grid of speeds that gathers what pairs of pictures tell of one.

A histogram filter (Thrun, Burgard & Fox 2005, "Probabilistic Robotics", section 4.1).
"""

import math

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray

SPEEDS_MPS = np.arange(0.0, 52.0, 0.5)
FASTEST_MPS = 47.0
"""Faster is the end of the grid."""
ACCELERATION_MPS2 = 3.0
WALK_MPS = 0.7
"""1-sigma of the change of a speed in the root of a second: it grows alike at every rate of the pairs.

As much as it was at 12 to 15 pairs a second when it hung on the rate and the settings here were chosen.
"""
WEIGHT_PER_S = 400.0
"""Of a correlation of 1, in the logarithm of the odds."""
REMEMBERED_S = 1.0
LEAST_CORRELATION = 0.2
"""In the mean over `REMEMBERED_S`. Below are speeds found by chance."""
SURE_PART, SURE_MPS = 0.08, 0.4
"""The grid tells a speed while its 1-sigma is less than this part of it, or less than this."""
LASTS_S = 0.6
"""Time for which it must have told a speed before that is believed."""


class SpeedGrid:
    """What is believed of a speed.

    Args:
        slowest_mps: a slower one is not told.
    """

    def __init__(self, slowest_mps: float) -> None:
        self._slowest_mps = slowest_mps
        self._log_odds = np.zeros(len(SPEEDS_MPS))
        self._correlation = np.zeros(len(SPEEDS_MPS))
        self._lasted_s = 0.0

    def update(self, correlation: FloatArray, dt_s: float) -> Gaussian | None:
        """Take what a pair of pictures tells, and say what is believed then; None where that is not sure.

        Args:
            correlation: (speeds,) of the two pictures if we drive so fast, at most 1.
            dt_s: since the pair before.
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
    """What is believed of the speed after it may have changed by so much.

    The kernel is the discrete Gaussian (Lindeberg 1990), made from its Fourier transform: its variance is
    right however narrow it is.
    """
    reach, step_mps = 4, SPEEDS_MPS[1] - SPEEDS_MPS[0]
    waves = np.linspace(0.0, math.pi, 4 * reach + 1)
    transform = np.exp((sigma_mps / step_mps) ** 2 * (np.cos(waves) - 1))
    kernel = np.fft.irfft(transform)[np.arange(-reach, reach + 1)]
    odds = np.exp(log_odds - log_odds.max())
    spread = np.convolve(np.pad(odds, reach, mode="edge"), kernel / kernel.sum(), "valid")
    return np.log(spread + 1e-12)
