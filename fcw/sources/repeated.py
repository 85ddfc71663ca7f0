"""Finds pictures that a video repeats, for example 25 pictures a second stored at 30, or a stalled recorder.

In each repeated picture all vehicles would seem to stop, and in the next new one to leap.
"""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.frame import Frame

ROWS = 90
"""About so many rows of a picture are compared, and columns at the same spacing."""
PARTS = (16, 9)
"""Columns and rows of the parts into which a picture is divided."""
MOST_CHANGE = 2.5
"""Largest change of a repeated picture, in grey values: the mean over the part that changes most. In four
clips each picture was shown two or four times, or every fifth one twice, and encoded again: 99 of 100
repeated pictures changed by less than 2.6, in most clips by less than 2, and by day 99 of 100 new pictures
changed by more than 5."""
FEWEST_NEW, NEW_RATIO, LEAST_NEW = 4, 4.0, 1.0
"""In the second before the last new picture, at least so many pictures changed so many times as much as this
one, and by so many grey values. At night new pictures change little, and repeated ones even less. While the
own car stands, all change little, except one or two a second that are encoded in full."""
LATELY_NS = 1_000_000_000
LONGEST_NS = 1_000_000_000
"""After this time a picture counts as new in any case: at a stop or in the dark, new pictures look repeated.

With 0.25 s, recorders that stalled for half a second on the move made false warnings in two clips, a real and
a rendered one; with 1 s and 2.5 s there were none.
"""


class RepeatedPictures:
    """Tells repeated pictures of a drive from new ones."""

    def __init__(self) -> None:
        self._last: NDArray[np.uint8] | None = None
        self._new_ns = 0
        self._lately: deque[tuple[int, float]] = deque()

    def is_repeated(self, frame: Frame) -> bool:
        """Whether the next frame repeats the picture before."""
        step = max(min(frame.image.shape[:2]) // ROWS, 1)
        # Green makes up most of the brightness.
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
