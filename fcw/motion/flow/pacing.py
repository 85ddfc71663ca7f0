"""When the pictures of a video were taken, if it repeats some of them.

A video of 30 pictures a second made from one of 25 shows every fifth picture twice. Its new pictures are
shown 33 or 67 ms apart but were taken every 40 ms, so that an even speed would seem to go up and down.
"""

from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

REPEATED_CHANGE = 0.25
"""A repeated picture's grey values change by less in the mean: by 0.02 to 0.2 in the clips looked at that
repeat theirs. Pictures of driving changed by 0.5 and more in the others, the least by night."""
WINDOW_S = 1.0
"""So much of the video tells its pace,"""
FEWEST_NEW, FEWEST_REPEATED = 6, 2
"""if so many pictures in it are new, and so many are not."""
LARGEST_SHIFT = 0.75
"""Of the time between two shown pictures: an even pace never shows one later than that, or earlier. What
does was not evenly taken, as where a recorder stalled; then it counts when it was shown."""


@dataclass(frozen=True, slots=True)
class _Shown:
    time_s: float
    is_new: bool


class Pacing:
    """Tells repeated pictures of a video from new ones, and when the new ones were taken."""

    def __init__(self) -> None:
        self._last: NDArray[np.uint8] | None = None
        self._shown: deque[_Shown] = deque()

    def is_new(self, time_s: float, grey: NDArray[np.uint8]) -> bool:
        """Take the next picture that is shown.

        Args:
            time_s: at which it is shown; must rise.
            grey: (height, width) of it.
        """
        last, self._last = self._last, grey
        is_new = last is None or cv2.norm(grey, last, cv2.NORM_L1) >= REPEATED_CHANGE * grey.size
        self._shown.append(_Shown(time_s, is_new))
        while self._shown[0].time_s < time_s - WINDOW_S:
            self._shown.popleft()
        return is_new

    @property
    def taken_s(self) -> float:
        """When the picture that was shown last was taken, by the even pace of the new ones before it.

        It is the time at which it is shown if none is repeated or they have no even pace.
        """
        shown = np.array([picture.time_s for picture in self._shown])
        new = np.array([picture.is_new for picture in self._shown])
        if new.sum() < FEWEST_NEW or (~new).sum() < FEWEST_REPEATED or not new[-1]:
            return float(shown[-1])
        numbers, times = np.arange(new.sum()), shown[new]
        pace_s, first_s = np.polyfit(numbers, times, 1)
        shifts_s = times - (first_s + pace_s * numbers)
        if np.abs(shifts_s).max() > LARGEST_SHIFT * np.diff(shown).min():
            return float(shown[-1])
        return float(shown[-1] - shifts_s[-1])
