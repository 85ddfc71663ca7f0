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
        """Count a frame as missed, until `find` says otherwise, so long after the one before."""
        fading = math.exp(-passed_s / self._time_constant_s)
        self._found *= fading
        self._missed = fading * self._missed + 1

    def find(self, faint: bool) -> None:
        """The last frame was none; one in which it was faint counts as neither."""
        self._missed -= 1
        self._found += not faint

    @property
    def part(self) -> float:
        """In how large a part of the frames it was found."""
        return self._found / (self._found + self._missed)
