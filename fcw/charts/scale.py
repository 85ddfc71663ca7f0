"""Where values stand along an axis, and which of them it names."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Scale:
    """Values along pixels.

    Attributes:
        low: value at `start_px`.
        high: value at `end_px`; larger.
        start_px: where the axis begins; more than `end_px` where values grow upwards.
        end_px: where it ends.
        logarithmic: equal ratios are equally long; `low` is more than 0.
    """

    low: float
    high: float
    start_px: float
    end_px: float
    logarithmic: bool = False

    def px(self, value: float) -> float:
        """Where a value stands; one beyond an end stands on it."""
        return float(self.places_px(np.array(value)))

    def places_px(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same for many; NaN stays NaN."""
        inside, low, high = np.clip(values, self.low, self.high), self.low, self.high
        if self.logarithmic:
            inside, low, high = np.log(inside), math.log(low), math.log(high)
        return self.start_px + (inside - low) / (high - low) * (self.end_px - self.start_px)


def round_values(low: float, high: float, most: int) -> list[float]:
    """Multiples of a round step, as many as there are from `low` to `high`, about `most` at the most."""
    step = 10.0 ** math.floor(math.log10((high - low) / most))
    step *= next(factor for factor in (1, 2, 5, 10) if (high - low) / (factor * step) <= most + 1e-9)
    return multiples(step, low, high)


def multiples(step: float, low: float, high: float) -> list[float]:
    """All multiples of a step from `low` to `high`."""
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
