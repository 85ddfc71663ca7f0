"""Pictures that a video shows again: as one of 25 a second does when played at 30, or a stalled recorder.

With each of them all vehicles would seem to stop, and to leap with the next new one.
"""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.frame import Frame

ROWS = 90
"""About so many rows of a picture are looked at, and columns as far apart."""
PARTS = (16, 9)
"""Columns and rows of the parts into which a picture is cut."""
MOST_CHANGE = 2.5
"""Of the grey values in the mean of the part that changes most. Of four clips each picture was shown two or
four times, or every fifth one twice, and encoded anew: 99 of 100 repeated ones changed by less than 2.6, in
most clips by less than 2, and by day 99 of 100 new ones by more than 5."""
FEWEST_NEW, NEW_RATIO, LEAST_NEW = 4, 4.0, 1.0
"""So many pictures of the second before the last new one changed so many times as much, and by so much. By
night new ones change little, and repeated ones less; where we stand all change little, but for one or two a
second that are encoded afresh."""
LATELY_NS = 1_000_000_000
LONGEST_NS = 1_000_000_000
"""After that a picture counts as new, whatever it shows: where we stop, or in the dark, new ones may look so.

With 0.25 s recorders that stalled for half a second while we drove made false warnings of two clips, real and
rendered, and with 1 and 2.5 s none.
"""


class RepeatedPictures:
    """Tells the pictures of a drive that are shown again from new ones."""

    def __init__(self) -> None:
        self._last: NDArray[np.uint8] | None = None
        self._new_ns = 0
        self._lately: deque[tuple[int, float]] = deque()

    def is_repeated(self, frame: Frame) -> bool:
        """Whether the next frame shows the picture before once more."""
        step = max(min(frame.image.shape[:2]) // ROWS, 1)
        # Green is most of what the eye takes for brightness.
        now, last, time_ns = frame.image[::step, ::step, 1].copy(), self._last, frame.time_ns
        self._last = now
        if last is None:
            self._new_ns = time_ns
            return False
        changes = cv2.absdiff(now, last).astype(np.float32)
        change = float(cv2.resize(changes, PARTS, interpolation=cv2.INTER_AREA).max())
        while self._lately and self._lately[0][0] < self._new_ns - LATELY_NS:
            self._lately.popleft()
        new = sum(one > max(NEW_RATIO * change, LEAST_NEW) for _, one in self._lately)
        self._lately.append((time_ns, change))
        if change < MOST_CHANGE and new >= FEWEST_NEW and time_ns - self._new_ns <= LONGEST_NS:
            return True
        self._new_ns = time_ns
        return False
