"""How often the detector found a vehicle recently."""

import math


class Lately:
    """Counts the frames in which a vehicle was found and missed, with exponentially fading weights.

    Args:
        time_constant_s: time after which a frame's weight has dropped to 1/e.
    """

    def __init__(self, time_constant_s: float) -> None:
        self._time_constant_s = time_constant_s
        self._found, self._missed = 1.0, 0.0

    def miss(self, passed_s: float) -> None:
        """Count a frame as missed, until `find` corrects it; `passed_s` is since the previous frame."""
        fading = math.exp(-passed_s / self._time_constant_s)
        self._found *= fading
        self._missed = fading * self._missed + 1

    def find(self, faint: bool) -> None:
        """Count the last frame as found. If the box was faint, it counts as neither found nor missed."""
        self._missed -= 1
        self._found += not faint

    @property
    def part(self) -> float:
        """Fraction of the recent frames in which it was found, from 0 to 1."""
        return self._found / (self._found + self._missed)
