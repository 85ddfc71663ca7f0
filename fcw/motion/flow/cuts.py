"""Where a clip is cut, as one that was edited, or goes on with another camera.

What finds the cuts of films goes by brightness and colour (FFmpeg's `scdet`, PySceneDetect). Drives have sky
above and road below on both sides of a cut; details tell them apart. Small grey pictures without their
shading are compared as they are and, where these differ because we turn or something passes, part by part,
each where it fits best nearby. Neither minds how bright a picture is.

A picture that is unlike the one before may come after a cut, or may be a flash or a broken one. The next one
tells: after a cut it is like the one in question, after a flash like those before. Where it was no cut, as of
wipers in heavy rain, there is no question again for a second.
"""

from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 64, 36
"""Of the small pictures."""
SAMPLES = 4
"""Along each side of what becomes one of their pixels."""
SHADING_PX = 4.0
"""Sigma of what is taken for shading."""
PART_WIDTH, PART_HEIGHT, NEARBY_PX = 16, 12, 4
"""Of the parts, and how far they are looked for, up, down and to the sides."""
LEAST_DETAIL = 1.0
"""Standard deviation, in grey values, of a picture or a part that can be compared."""
FEWEST_PARTS = 3
SURELY_ALIKE = 0.5
"""Correlation of two pictures whose parts need not be looked at."""
ALIKE = 0.95
"""Least sum of the pictures' correlation and the middle one of their parts'.

Chosen on ten real clips, two drives of KITTI and the shipped one (`benchmarks/motion/clip_cuts.py`). Of
10,242 steps of up to 150 ms none has less than 1.01, of 5,598 of up to 210 ms 24 have less than 0.95. So do
99 % of pairs from two cameras, 86 % of pairs from two drives of one, and 49 % of pairs from one view, 3 s and
more apart: there the road may look the same.
"""
LONGEST_STEP_NS = 150_000_000
"""After a longer time, pictures of one drive may differ as much."""
RESTLESS_NS = 1_000_000_000


class Follows(Enum):
    """How a picture follows the one before."""

    SAME_VIEW = "same view"
    UNLIKE = "unlike"
    """The next one tells whether it was a cut."""
    AFTER_CUT = "after a cut"
    """The picture before was the first of another view, and this one goes on with it."""


class CutWatch:
    """Finds the cuts of a drive."""

    def __init__(self) -> None:
        self._last: NDArray[np.float32] | None = None
        self._unlike: NDArray[np.float32] | None = None
        self._time_ns = 0
        self._restless_ns = -RESTLESS_NS
        """When a picture was last unlike the one before and there was no cut."""

    def see(self, time_ns: int, image: NDArray[np.uint8]) -> Follows:
        """Take the next picture.

        Args:
            time_ns: of it.
            image: (height, width, 3) BGR.
        """
        now, since_ns = details(image), time_ns - self._time_ns
        if now.std() < LEAST_DETAIL:
            return Follows.SAME_VIEW  # nothing can be seen: what comes afterwards tells
        last, unlike, self._time_ns = self._last, self._unlike, time_ns
        self._unlike = None
        is_unlike = last is not None and since_ns <= LONGEST_STEP_NS and not _alike(last, now)
        if is_unlike and unlike is None and time_ns - self._restless_ns >= RESTLESS_NS:
            self._unlike = now
            return Follows.UNLIKE
        self._last = now
        if unlike is None:
            return Follows.SAME_VIEW
        if is_unlike and _alike(unlike, now):
            return Follows.AFTER_CUT
        self._restless_ns = time_ns
        return Follows.SAME_VIEW


def details(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(HEIGHT, WIDTH) of a picture: its green, which is most of the brightness, without shading."""
    height, width = image.shape[:2]
    down, across = max(height // (SAMPLES * HEIGHT), 1), max(width // (SAMPLES * WIDTH), 1)
    sampled = np.ascontiguousarray(image[down // 2 :: down, across // 2 :: across, 1])
    small = cv2.resize(sampled, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)
    return small - cv2.GaussianBlur(small, (0, 0), SHADING_PX)


def _alike(before: NDArray[np.float32], now: NDArray[np.float32]) -> bool:
    """Whether two pictures are of one view, or do not tell."""
    whole = correlation(before, now)
    return whole >= SURELY_ALIKE or whole + correlation_of_parts(before, now) >= ALIKE


def correlation(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Of two small pictures as they are."""
    return float(cv2.matchTemplate(before, now, cv2.TM_CCOEFF_NORMED)[0, 0])


def correlation_of_parts(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Median over the parts of the earlier picture, each where it fits best in the later one.

    It is 1 where too few have details.
    """
    correlations = []
    for top in range(NEARBY_PX, HEIGHT - PART_HEIGHT - NEARBY_PX + 1, PART_HEIGHT):
        for left in range(NEARBY_PX, WIDTH - PART_WIDTH - NEARBY_PX + 1, PART_WIDTH):
            part = before[top : top + PART_HEIGHT, left : left + PART_WIDTH]
            if part.std() < LEAST_DETAIL:
                continue
            around = now[
                top - NEARBY_PX : top + PART_HEIGHT + NEARBY_PX,
                left - NEARBY_PX : left + PART_WIDTH + NEARBY_PX,
            ]
            correlations.append(float(cv2.matchTemplate(around, part, cv2.TM_CCOEFF_NORMED).max()))
    return float(np.median(correlations)) if len(correlations) >= FEWEST_PARTS else 1.0
