"""What signals are measured in, as a person reads it: unit, digits, and the axis that fits values."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.charts.scale import multiples
from fcw.units import FEET_PER_METRE, KMH_PER_MPS, MPH_PER_MPS, STANDARD_GRAVITY_MPS2

MOST_STEPS = 4
"""An axis is divided in at most so many: a plot is seldom high."""
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a signal is measured in.

    Attributes:
        unit: of its axis; empty for a plain number.
        factor: of that unit by the SI unit.
        decimals: of a value in words.
        imperial_unit: empty where there is no other.
        imperial_factor: of that by the SI unit.
        imperial_decimals: of it.
    """

    unit: str
    factor: float = 1.0
    decimals: int = 1
    imperial_unit: str = ""
    imperial_factor: float = 1.0
    imperial_decimals: int = 0

    def in_units(self, imperial: bool) -> tuple[str, float, int]:
        """Unit, factor and decimals for a person."""
        if imperial and self.imperial_unit:
            return self.imperial_unit, self.imperial_factor, self.imperial_decimals
        return self.unit, self.factor, self.decimals


LENGTH = Quantity("m", 1.0, 1, "ft", FEET_PER_METRE, 0)
SPEED = Quantity("km/h", KMH_PER_MPS, 0, "mph", MPH_PER_MPS, 0)
SLOW_SPEED = Quantity("m/s", 1.0, 1, "ft/s", FEET_PER_METRE, 1)
TIME = Quantity("s")
BRAKING = Quantity("g", 1 / STANDARD_GRAVITY_MPS2, 2)
ACCELERATION = Quantity("m/s²")
ANGLE = Quantity("°", math.degrees(1), 2)
TURNING = Quantity("°/s", math.degrees(1), 1)
BENDING = Quantity("1/km", 1000.0, 1)
PIXELS = Quantity("px", 1.0, 0)
SHARE = Quantity("%", 100.0, 0)
SCORE = Quantity("", 1.0, 2)
COUNT = Quantity("", 1.0, 0)


@dataclass(frozen=True, slots=True)
class Span:
    """Which values an axis holds, in SI units.

    Attributes:
        low: it begins there at the latest; None where the values begin.
        high: it ends there at the earliest; None where the values end.
        lowest: values below are not drawn.
        highest: values above are not drawn.
    """

    low: float | None = 0.0
    high: float | None = None
    lowest: float = -math.inf
    highest: float = math.inf

    def axis(self, values: Sequence[NDArray[np.float64]], factor: float) -> tuple[float, float, float]:
        """Lower end, upper end and step of an axis, in the unit of the factor.

        Args:
            values: all that is drawn, in SI units; what is not finite is left out.
            factor: of the unit.
        """
        known = np.concatenate([np.ravel(part) for part in values]) if values else np.zeros(0)
        known = known[np.isfinite(known) & (known >= self.lowest) & (known <= self.highest)]
        ends = [float(known.min()), float(known.max())] if len(known) else []
        ends += [end for end in (self.low, self.high) if end is not None]
        low, high = (min(ends) * factor, max(ends) * factor) if ends else (0.0, 1.0)
        if high - low < 1e-6 * max(abs(low), abs(high), 1.0):
            # Of nothing, or of zeros only, the axis still begins where it has to.
            low, high = (low - 0.5, high + 0.5) if self.low is None else (low, low + 1.0)
        step = _step((high - low) / MOST_STEPS)
        bottom, top = math.floor(low / step + 1e-6) * step, math.ceil(high / step - 1e-6) * step
        return bottom, top, step


def ticks(bottom: float, top: float, step: float, most: int) -> list[float]:
    """The values that an axis names: its steps, fewer where there is no room for all."""
    for every in range(1, round((top - bottom) / step) + 1):
        values = multiples(step * every, bottom, top)
        if 2 <= len(values) <= most:
            return values
    return [bottom, top]


def tick_text(value: float) -> str:
    """A value on an axis."""
    return f"{round(value, 9):g}".replace("-", "−")


def _step(least: float) -> float:
    """The round number that is not less."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(step for step in (part * power for part in STEPS) if step >= least * (1 - 1e-9))
