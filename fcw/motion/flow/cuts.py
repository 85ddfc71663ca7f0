"""Where a clip is cut, as one that was edited, or goes on with another camera.

What finds the cuts of films goes by brightness and colour (FFmpeg's `scdet`, PySceneDetect). Drives have sky
above and road below on both sides of a cut; details tell them apart. Small grey pictures without their
shading are compared part by part, each where it fits best nearby: how bright they are does not matter, nor
that we turn, nor what passes or wipes over some of the parts. In snow and in the dark pictures are less alike
all the time: a cut is a drop below all of the last second.

A picture that is unlike the one before may come after a cut, or may be a flash or a broken one. The next one
tells: after a cut it is like the one in question.
"""

from collections import deque
from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 64, 36
"""Of the small pictures."""
SAMPLES = 3
"""Along each side of what becomes one of their pixels."""
SHADING_PX = 4.0
"""Sigma of what is taken for shading."""
PART_WIDTH, PART_HEIGHT, NEARBY_PX = 12, 9, 4
"""Of the parts, and how far they are looked for, up, down and to the sides."""
LEAST_DETAIL = 2.0
"""Standard deviation, in grey values, of a picture or a part that can be compared."""
FEWEST_PARTS = 3
SURELY_ALIKE = 0.8
"""Correlation of two pictures whose parts need not be looked at."""
ALIKE, ALIKE_SOON = 0.55, 0.75
"""Least likeness of pictures that follow each other; the second up to `SOON_NS` after the last new one.

Chosen on ten real clips, two drives of KITTI and the shipped one (`benchmarks/motion/clip_cuts.py`), and so
that wipers drawn into the clips are no cuts.
"""
SOON_NS, LONGEST_STEP_NS = 50_000_000, 150_000_000
"""After a longer time than the second, pictures of one drive may differ as much as any."""
DROP, LATELY_NS, FEWEST_STEPS = 0.1, 1_000_000_000, 5
"""By so much a cut is less alike than all steps of so long before; so many must be known."""
REPEATED = 0.999
"""Pictures with a higher correlation may be one and the same, shown twice."""


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
        self._time_ns = self._new_ns = 0
        """Of the last picture, and of the last one that was no repeated one."""
        self._lately: deque[tuple[float, int]] = deque()
        """Likenesses and times of the steps of the last second."""

    def see(self, time_ns: int, image: NDArray[np.uint8]) -> Follows:
        """Take the next picture.

        Args:
            time_ns: of it.
            image: (height, width, 3) BGR.
        """
        now, since_ns = details(image), time_ns - self._time_ns
        if cv2.norm(now) < LEAST_DETAIL * now.size**0.5:
            return Follows.SAME_VIEW  # nothing can be seen: what comes afterwards tells
        last, unlike, self._time_ns = self._last, self._unlike, time_ns
        if last is None or since_ns > LONGEST_STEP_NS:
            return self._go_on(now, time_ns)
        whole = correlation(last, now)
        alike = 1.0 if whole >= SURELY_ALIKE else likeness(last, now)
        least = ALIKE_SOON if time_ns - self._new_ns <= SOON_NS else ALIKE
        while self._lately and self._lately[0][1] < time_ns - LATELY_NS:
            self._lately.popleft()
        if unlike is not None:
            anew = likeness(unlike, now)
            if anew >= least and anew > alike and alike < SURELY_ALIKE:
                self._lately.clear()
                return self._go_on(now, time_ns, Follows.AFTER_CUT)
        elif len(self._lately) >= FEWEST_STEPS and alike < min(least, min(self._lately)[0] - DROP):
            self._lately.append((alike, time_ns))
            self._unlike = now
            return Follows.UNLIKE
        self._lately.append((alike, time_ns))
        return self._go_on(now, self._new_ns if whole >= REPEATED else time_ns)

    def _go_on(self, now: NDArray[np.float32], new_ns: int, follows: Follows = Follows.SAME_VIEW) -> Follows:
        self._last, self._unlike, self._new_ns = now, None, new_ns
        return follows


def details(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(HEIGHT, WIDTH) of a picture: its green, which is most of the brightness, without shading."""
    height, width = image.shape[:2]
    down, across = max(height // (SAMPLES * HEIGHT), 1), max(width // (SAMPLES * WIDTH), 1)
    sampled = np.ascontiguousarray(image[down // 2 :: down, across // 2 :: across, 1])
    small = cv2.resize(sampled, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    shading = cv2.GaussianBlur(small, (0, 0), SHADING_PX)
    return small.astype(np.float32) - shading


def correlation(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Correlation of two small pictures in place; as their shading is gone, the mean of each is 0."""
    length = cv2.norm(before) * cv2.norm(now)
    return float(np.vdot(before, now)) / length if length else 0.0


def likeness(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Median correlation of the parts of the earlier picture, each where it fits best in the later one.

    It is 1 where too few parts have details.
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
