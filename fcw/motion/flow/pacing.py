"""When the pictures of a video were taken, if it repeats some of them.

A video of 30 pictures a second made from one of 25 shows every fifth picture twice. Its new pictures are
shown 33 or 67 ms apart but were taken every 40 ms, so that an even speed would seem to go up and down.

Where a recorder lost a picture and repeats the one before instead, as converters to a constant rate do, the
new ones are shown as unevenly, and were taken so: the one after the lost one has changed by more.

Some videos, of screens that were recorded or of streams, repeat none but say of each when it arrived: 25 to
85 ms after the one before, of pictures that were taken every 50 ms. There the pictures tell: what is farther
apart in time has changed by more. If it has not, the times are those of a delay that varies.
"""

import math
from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray

REPEATED_CHANGE = 0.25
"""A repeated picture's grey values change by less in the mean: by 0.02 to 0.2 in the clips looked at that
repeat theirs. Pictures of driving changed by 0.5 and more in the others, the least by night."""
WINDOW_S = 1.0
"""The last part of the video, which tells its pace."""
FEWEST_NEW, FEWEST_REPEATED = 6, 2
"""New and repeated pictures that it needs."""
LARGEST_SHIFT = 0.75
"""Of the time between two shown pictures: an even pace never shows one later than that, or earlier. What
does was not evenly taken, as where a recorder stalled; then it counts when it was shown."""
DELAYS_WINDOW_S = 2.0
"""The last part of the video, which tells whether its times are those of a varying delay."""
FEWEST_STEPS = 12
"""Steps from one picture to the next that it needs."""
LEAST_UNEVENNESS = 0.2
"""Least standard deviation of these steps, as a part of their mean."""
LEAST_CHANGE = 1.0
"""Least change of the grey values in the mean of a step: what stands looks the same after any time."""
LARGEST_SLOPE = 0.15
"""Of the logarithm of the change over that of the step, with two of its sigmas. Seven clips of which one, two
or three pictures were taken by chance had 0.24 to 2.8 in each window, two with such delays -1.8 to -0.1."""


@dataclass(frozen=True, slots=True)
class _Shown:
    time_s: float
    change: float
    """Of the grey values in the mean, since the picture before."""

    @property
    def is_new(self) -> bool:
        return self.change >= REPEATED_CHANGE


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
        change = math.inf if last is None else cv2.norm(grey, last, cv2.NORM_L1) / grey.size
        self._shown.append(_Shown(time_s, change))
        while self._shown[0].time_s < time_s - DELAYS_WINDOW_S:
            self._shown.popleft()
        return self._shown[-1].is_new

    @property
    def taken_s(self) -> float:
        """When the picture that was shown last was taken, by the even pace of the new ones before it.

        It is the time at which it is shown if none is repeated or they have no even pace.
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
    """The evenly paced times that are nearest to these."""
    numbers = np.arange(len(times_s))
    pace_s, first_s = np.polyfit(numbers, times_s, 1)
    return first_s + pace_s * numbers.astype(np.float64)


def _is_delayed(times_s: FloatArray, changes: FloatArray) -> bool:
    """Whether pictures change as if they had been taken evenly, whatever their times (N,) say.

    Args:
        times_s: rising.
        changes: (N - 1,) of the grey values from each to the next.
    """
    slope = _slope(times_s, changes)
    return slope is not None and slope[0] + 2 * slope[1] < LARGEST_SLOPE


def _slope(times_s: FloatArray, changes: FloatArray) -> tuple[float, float] | None:
    """Of the logarithm of the change over that of the step, and its 1-sigma; None where it cannot be told."""
    steps_s = times_s[1:] - times_s[:-1]
    if len(steps_s) < FEWEST_STEPS:
        return None
    mean_s = (times_s[-1] - times_s[0]) / len(steps_s)
    off_s = steps_s - mean_s
    if off_s @ off_s < len(steps_s) * (LEAST_UNEVENNESS * mean_s) ** 2:
        return None
    if np.median(changes) < LEAST_CHANGE:
        return None
    # By what differs between neighbours: how fast all changes drifts with the scene.
    longer, more = np.diff(np.log(steps_s)), np.diff(np.log(changes))
    slope = (longer @ more) / (longer @ longer)
    sigma = math.sqrt(np.square(more - slope * longer).mean() / (longer @ longer))
    return float(slope), sigma
