"""When the pictures of a video were taken, if their timestamps do not tell.

A video with 30 frames per second made from one with 25 shows every fifth picture twice. Its new pictures are
33 or 67 ms apart, but were taken every 40 ms. A constant speed would seem to go up and down.

If a recorder lost a picture and repeats the previous one instead, as converters to a constant rate do, the
intervals are just as uneven, but right: the picture after the lost one has changed by more.

Some videos, of recorded screens or of streams, repeat none, but have the times at which pictures arrived: 25
to 85 ms apart for pictures that were taken every 50 ms. There, the change between pictures decides. With true
times, a longer interval comes with a larger change. If it does not, the times only show a varying delay.
"""

import math
from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray

REPEATED_CHANGE = 0.25
"""Mean change of grey values below which a picture is repeated: 0.02 to 0.2 in the clips looked at that
repeat pictures. In the others, pictures of driving changed by at least 0.5, least by night."""
WINDOW_S = 1.0
"""Time window for determining the pace."""
FEWEST_NEW, FEWEST_REPEATED = 6, 2
"""Least numbers of new and repeated pictures in it."""
LARGEST_SHIFT = 0.75
"""Largest shift of a picture from an even pace, as a fraction of the interval between frames. Pictures with a
larger one were not taken evenly, for example because a recorder stalled; their timestamps count."""
DELAYS_WINDOW_S = 2.0
"""Time window for determining whether the timestamps show a varying delay."""
FEWEST_STEPS = 12
"""Least number of intervals in it."""
LEAST_UNEVENNESS = 0.2
"""Least standard deviation of these intervals, as a fraction of their mean."""
LEAST_CHANGE = 1.0
"""Least median change of grey values, because at standstill pictures look the same after any interval."""
LARGEST_SLOPE = 0.15
"""Largest slope of log change over log interval, plus two sigmas, for a varying delay. Seven clips from which
one, two or three pictures were dropped at random had 0.24 to 2.8 in each window; two with such delays, -1.8
to -0.1."""


@dataclass(frozen=True, slots=True)
class _Shown:
    time_s: float
    change: float
    """Mean change of the grey values since the previous picture."""

    @property
    def is_new(self) -> bool:
        return self.change >= REPEATED_CHANGE


class Pacing:
    """Distinguishes repeated pictures from new ones, and tells when the new ones were taken."""

    def __init__(self) -> None:
        self._last: NDArray[np.uint8] | None = None
        self._shown: deque[_Shown] = deque()

    def is_new(self, time_s: float, grey: NDArray[np.uint8]) -> bool:
        """Update with the next frame; returns whether it shows a new picture.

        Args:
            time_s: its timestamp; must increase.
            grey: (height, width) the picture.
        """
        last, self._last = self._last, grey
        change = math.inf if last is None else cv2.norm(grey, last, cv2.NORM_L1) / grey.size
        self._shown.append(_Shown(time_s, change))
        while self._shown[0].time_s < time_s - DELAYS_WINDOW_S:
            self._shown.popleft()
        return self._shown[-1].is_new

    @property
    def taken_s(self) -> float:
        """When the last picture was taken, by the even pace of the new ones before it.

        This is its timestamp if there is no even pace, or no reason to doubt the timestamps.
        """
        shown = np.array([picture.time_s for picture in self._shown])
        changes = np.array([picture.change for picture in self._shown])
        new = changes >= REPEATED_CHANGE
        if new.all():
            return float(_even(shown)[-1] if _is_delayed(shown, changes[1:]) else shown[-1])
        lately = shown >= shown[-1] - WINDOW_S
        shown, new = shown[lately], new[lately]
        if new.sum() < FEWEST_NEW or (~new).sum() < FEWEST_REPEATED or not new[-1]:
            return float(shown[-1])
        times = _even(shown[new])
        if np.abs(shown[new] - times).max() > LARGEST_SHIFT * np.diff(shown).min():
            return float(shown[-1])
        slope = _slope(shown[new], changes[lately][new][1:])
        if slope is not None and slope[0] - slope[1] > LARGEST_SLOPE:
            return float(shown[-1])
        return float(times[-1])


def _even(times_s: FloatArray) -> FloatArray:
    """The evenly spaced times that fit these best."""
    numbers = np.arange(len(times_s))
    pace_s, first_s = np.polyfit(numbers, times_s, 1)
    return first_s + pace_s * numbers.astype(np.float64)


def _is_delayed(times_s: FloatArray, changes: FloatArray) -> bool:
    """Whether pictures change as if they had been taken evenly, whatever their timestamps.

    Args:
        times_s: (N,) timestamps, increasing.
        changes: (N - 1,) mean changes of the grey values from each picture to the next.
    """
    slope = _slope(times_s, changes)
    return slope is not None and slope[0] + 2 * slope[1] < LARGEST_SLOPE


def _slope(times_s: FloatArray, changes: FloatArray) -> tuple[float, float] | None:
    """Slope of log change over log interval, and its 1-sigma; None if it cannot be determined."""
    steps_s = times_s[1:] - times_s[:-1]
    if len(steps_s) < FEWEST_STEPS:
        return None
    mean_s = (times_s[-1] - times_s[0]) / len(steps_s)
    off_s = steps_s - mean_s
    if off_s @ off_s < len(steps_s) * (LEAST_UNEVENNESS * mean_s) ** 2:
        return None
    if np.median(changes) < LEAST_CHANGE:
        return None
    # By differences between neighbours, because the overall rate of change drifts with the scene.
    longer, more = np.diff(np.log(steps_s)), np.diff(np.log(changes))
    slope = (longer @ more) / (longer @ longer)
    sigma = math.sqrt(np.square(more - slope * longer).mean() / (longer @ longer))
    return float(slope), sigma
