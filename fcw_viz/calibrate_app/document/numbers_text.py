"""Distances, intervals and gains as the page writes them: no digit that the uncertainty does not carry."""

import math
import re

from fcw.units import FEET_PER_METRE

EN_DASH = "–"
WIDE_INTERVAL = 5.0
"""An interval of more units than this needs no decimals."""
NARROW_INTERVAL = 0.5
"""One of fewer units than this needs two."""
HALVES = ((0.29, "would cut the error to a quarter"), (0.4, "would cut the error to a third"))
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_METRES = re.compile(rf"({_NUMBER.pattern}(?: (?:±|by|to) {_NUMBER.pattern})*) m\b")
"""Also `1.3 ± 0.03 m`, `2.5 by 5 m` and `2.1 to 2.4 m`, whose unit is that of each number."""
HALF = 0.6
"""A ratio of errors up to this is called half."""


def unit_name(imperial: bool) -> str:
    """`ft` or `m`."""
    return "ft" if imperial else "m"


def in_units(distance_m: float, imperial: bool) -> float:
    """A distance in feet or metres."""
    return distance_m * FEET_PER_METRE if imperial else distance_m


def typed_text(distance_m: float, imperial: bool) -> str:
    """A distance as somebody typed it, with its unit."""
    return f"{in_units(distance_m, imperial):.4g} {unit_name(imperial)}"


def row_distance_text(distance_m: float, imperial: bool) -> str:
    """A round distance with its unit."""
    return f"{in_units(distance_m, imperial):.3g} {unit_name(imperial)}"


def with_lengths(text: str, imperial: bool) -> str:
    """A sentence of the library, which writes metres, in the units of the page."""
    if not imperial:
        return text

    def feet(number: re.Match[str]) -> str:
        return f"{in_units(float(number[0]), True):.3g}"

    return _METRES.sub(lambda found: f"{_NUMBER.sub(feet, found[1])} ft", text)


def about_text(distance_m: float, imperial: bool) -> str:
    """A distance that need not be met exactly."""
    return f"at about {in_units(distance_m, imperial):.0f} {unit_name(imperial)}"


def interval_text(low_m: float, high_m: float, imperial: bool, dash: str = EN_DASH) -> str:
    """An interval without its unit, with the decimals that its width carries.

    An unbounded one is `45 and beyond`.
    """
    low, high = in_units(low_m, imperial), in_units(high_m, imperial)
    if not math.isfinite(low):
        return "beyond the horizon"
    if not math.isfinite(high):
        return f"{max(low, 0.0):.0f} and beyond"
    width = high - low
    decimals = 0 if width > WIDE_INTERVAL else 2 if width < NARROW_INTERVAL else 1
    return f"{low:.{decimals}f}{dash}{high:.{decimals}f}"


def percent_text(part: float) -> str:
    """A part in percent: one decimal below ten."""
    return f"{part:.0%}" if part >= 0.0995 else f"{part:.1%}"


def gain_text(error_before: float, error_after: float) -> str:
    """What a fall of the error is called."""
    ratio = error_after / error_before
    for limit, words in HALVES:
        if ratio <= limit:
            return words
    if ratio <= HALF:
        return "would halve the error"
    return f"would cut the error by {1 - ratio:.0%}"
