"""How often the detector found a vehicle of late."""

import math


class Lately:
    """Frames in which a vehicle was found and missed; old ones count less and less.

    Args:
        time_constant_s: after so long a frame counts 1/e.
    """

    def __init__(self, time_constant_s: float) -> None:
        self._time_constant_s = time_constant_s
        self._found, self._missed = 1.0, 0.0

    def miss(self, passed_s: float) -> None:
        """Count a frame as missed until `find` says otherwise; `passed_s` since the frame before."""
        fading = math.exp(-passed_s / self._time_constant_s)
        self._found *= fading
        self._missed = fading * self._missed + 1

    def find(self, faint: bool) -> None:
        """The vehicle was found in the last frame; a faint box counts as neither found nor missed."""
        self._missed -= 1
        self._found += not faint

    @property
    def part(self) -> float:
        """The part of the recent frames in which it was found, from 0 to 1."""
        return self._found / (self._found + self._missed)
