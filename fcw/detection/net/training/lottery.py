"""Drawing by chance where some are drawn oftener than others."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class Lottery:
    """Draws an index, each in proportion to its weight; numpy's `choice` sums all weights at every draw."""

    def __init__(self, weights: Sequence[float] | NDArray[np.floating]) -> None:
        self._sums = np.cumsum(weights, dtype=np.float64)

    def draw(self, random: np.random.Generator) -> int:
        """One of the indices."""
        return int(np.searchsorted(self._sums, random.uniform(0.0, self._sums[-1]), side="right"))
