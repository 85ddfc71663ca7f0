"""Units: their sizes, and how distances, speeds and pitches are written for a person, metric or imperial."""

import math
import re

NS_PER_S = 1_000_000_000
FEET_PER_METRE = 1 / 0.3048
MPH_PER_MPS = 3600 / 1609.344
KMH_PER_MPS = 3.6
STANDARD_GRAVITY_MPS2 = 9.80665
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")
"""A number as half of the world writes it; here it is written with a point."""


def distance_text(distance_m: float, imperial: bool = False) -> str:
    """A distance with its unit: one decimal below 20 m, none beyond; feet always whole."""
    if imperial:
        return f"{distance_m * FEET_PER_METRE:.0f} ft"
    return f"{distance_m:.1f} m" if distance_m < 19.95 else f"{distance_m:.0f} m"


def speed_text(speed_mps: float, imperial: bool = False) -> str:
    """A speed with its unit, whole km/h or mph."""
    return f"{speed_mps * MPH_PER_MPS:.0f} mph" if imperial else f"{speed_mps * KMH_PER_MPS:.0f} km/h"


def pitch_text(pitch_rad: float, sigma_rad: float | None = None) -> str:
    """A pitch, positive down, with its standard deviation where it is given: "2.86 ± 0.30 degrees up"."""
    error = "" if sigma_rad is None else f" ± {math.degrees(sigma_rad):.2f}"
    degrees = math.degrees(pitch_rad)
    return f"{abs(degrees):.2f}{error} degrees {'up' if degrees <= -0.005 else 'down'}"
