"""Whether the lead will be beside the own path before contact.

Seen from a car that turns, parked and waiting vehicles sweep across the straight path ahead, and a lead that
turns off or changes lanes leaves it. What is on a collision course keeps its bearing.
"""

import math
from collections import deque

import numpy as np

from fcw.tracking.types import Track

WINDOW_S = 0.5
"""The sideways speed is the slope over so long: lane changes and turns take seconds."""
LEAST_SAMPLES = 4
"""A slope and its error need more samples than two."""
LONGEST_S = 4.0
"""Sideways motion is not extrapolated farther than ISO 15623's largest TTC of a warning."""
CLEARANCE_M = 1.8
"""Two cars 1.8 m wide pass each other when their middles are farther apart."""


class Course:
    """Follows the sideways motion of one lead after the other."""

    def __init__(self) -> None:
        self._track_id: int | None = None
        self._samples: deque[tuple[float, float]] = deque()

    def misses(self, time_ns: int, lead: Track | None) -> bool:
        """Whether the lead surely, by one sigma, is out of the way when its distance is used up.

        Call it at every frame. It is False for a lead that has been followed too briefly to tell.
        """
        if lead is None or lead.track_id != self._track_id:
            self._samples.clear()
            self._track_id = None if lead is None else lead.track_id
        if lead is None:
            return False
        time_s = time_ns / 1e9
        if not lead.coasting and math.isfinite(lead.lateral_m):
            self._samples.append((time_s, lead.lateral_m))
        while self._samples and self._samples[0][0] < time_s - WINDOW_S:
            self._samples.popleft()
        if len(self._samples) < LEAST_SAMPLES or lead.ttc_s is None:
            return False
        ahead_s = min(lead.ttc_s, LONGEST_S)
        lateral_m, sigma_m = _extrapolated(np.array(self._samples), time_s + ahead_s)
        return abs(lateral_m) - sigma_m > CLEARANCE_M


def _extrapolated(samples: np.ndarray, time_s: float) -> tuple[float, float]:
    """Value and sigma at a time, of the straight line through (N, 2) times and values."""
    times, values = samples.T
    middle = times.mean()
    spread = float(((times - middle) ** 2).sum())
    if spread == 0:
        return float(values.mean()), math.inf
    slope = float((times - middle) @ values) / spread
    residuals = values - values.mean() - slope * (times - middle)
    variance = float(residuals @ residuals) / (len(values) - 2)
    ahead = time_s - middle
    sigma = math.sqrt(variance * (1 / len(values) + ahead**2 / spread))
    return float(values.mean()) + slope * ahead, sigma
