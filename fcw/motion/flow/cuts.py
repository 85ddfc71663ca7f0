"""Detects cuts in a clip that was edited, or that continues with another camera.

Detectors for cuts in films use brightness and colour (FFmpeg's `scdet`, PySceneDetect). Drives have sky above
and road below on both sides of a cut, so only details tell them apart. Small grey pictures without their
shading are compared part by part, each where it fits best nearby. So brightness does not matter, nor turning,
nor something that passes or wipes over some of the parts. In snow and in the dark, pictures are always less
alike. So a cut is a drop in likeness below the whole last second.

A picture that is unlike the previous one may be the first after a cut, or a flash or a damaged one. The next
picture
decides: after a cut, it is like the picture in question.
"""

from collections import deque
from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 64, 36
"""Size of the small pictures."""
SAMPLES = 3
"""Number of samples along each side of the area that becomes one of their pixels."""
SHADING_PX = 4.0
"""Sigma of the Gaussian filter whose result is taken as shading."""
PART_WIDTH, PART_HEIGHT, NEARBY_PX = 12, 9, 4
"""Size of the parts, and how far they are searched in each direction."""
LEAST_DETAIL = 2.0
"""Least standard deviation, in grey values, of a picture or part that can be compared."""
FEWEST_PARTS = 3
SURELY_ALIKE = 0.8
"""Correlation of two pictures from which their parts need not be compared."""
ALIKE, ALIKE_SOON = 0.55, 0.75
"""Least likeness of consecutive pictures; the second applies up to `SOON_NS` after the last new picture.

Chosen on ten real clips, two drives of KITTI and the shipped one (`benchmarks/motion/clip_cuts.py`), and such
that wipers drawn into the clips are no cuts.
"""
SOON_NS, LONGEST_STEP_NS = 50_000_000, 150_000_000
"""After more than `LONGEST_STEP_NS`, pictures of one drive may differ as much as any two."""
DROP, LATELY_NS, FEWEST_STEPS = 0.1, 1_000_000_000, 5
"""A cut's likeness is by `DROP` below that of all steps in the last `LATELY_NS`, of which there are at least
`FEWEST_STEPS`."""
REPEATED = 0.999
"""Two pictures with a higher correlation may be the same one, shown twice."""


class Follows(Enum):
    """How a picture follows the previous one."""

    SAME_VIEW = "same view"
    UNLIKE = "unlike"
    """It is unlike the previous picture; the next one tells whether there was a cut."""
    AFTER_CUT = "after a cut"
    """The previous picture was the first of another view, and this one continues it."""


class CutWatch:
    """Finds the cuts of a drive."""

    def __init__(self) -> None:
        self._last: NDArray[np.float32] | None = None
        self._unlike: NDArray[np.float32] | None = None
        self._time_ns = self._new_ns = 0
        """Times of the last picture, and of the last one that did not repeat its predecessor."""
        self._lately: deque[tuple[float, int]] = deque()
        """Likenesses and times of the steps in the last second."""

    def see(self, time_ns: int, image: NDArray[np.uint8]) -> Follows:
        """Update with the next picture.

        Args:
            time_ns: time of the picture.
            image: (height, width, 3) BGR.
        """
        now, since_ns = details(image), time_ns - self._time_ns
        if cv2.norm(now) < LEAST_DETAIL * now.size**0.5:
            return Follows.SAME_VIEW  # nothing can be seen; later pictures will tell
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
    """(HEIGHT, WIDTH) small picture of the green, which is most of the brightness, without shading."""
    height, width = image.shape[:2]
    down, across = max(height // (SAMPLES * HEIGHT), 1), max(width // (SAMPLES * WIDTH), 1)
    sampled = np.ascontiguousarray(image[down // 2 :: down, across // 2 :: across, 1])
    small = cv2.resize(sampled, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    shading = cv2.GaussianBlur(small, (0, 0), SHADING_PX)
    return small.astype(np.float32) - shading


def correlation(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Correlation of two small pictures without a shift. Without shading, their means are 0."""
    length = cv2.norm(before) * cv2.norm(now)
    return float(np.vdot(before, now)) / length if length else 0.0


def likeness(before: NDArray[np.float32], now: NDArray[np.float32]) -> float:
    """Median correlation of the parts of the earlier picture, each where it fits best in the later one.

    1 if too few parts have details.
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
