"""Whether the picture is still the same as a second ago.

From one picture to the next, a heavily compressed video may repeat nearly everything while we drive, and
drops on the windscreen are stationary at any speed. But a second later, most of the codec's blocks have been
updated, and everything beside the drops has changed. If we stand, the picture stays the same for long.

The limits were set while looking at four clips of standing cameras, six of driving ones that were degraded
until they seemed to stand, and one through drops. A second later, a median of 59 to 85 % of the corners of
the standing ones were in place, 1 to 33 % of the degraded ones, and 58 % of those with drops; but with drops
90 % of the cells had changed, compared with 26 to 37 % of the standing ones.
"""

from collections import deque

from fcw.camera.ground_plane import FloatArray
from fcw.motion.flow.points import PointFollower, SmallPicture

AGO_NS, SOON_NS = 1_000_000_000, 300_000_000
"""The picture is compared with one a second ago or, if there is none yet, with one at least `SOON_NS` ago."""
KEPT_NS = 200_000_000
"""Time between two stored pictures, and between two comparisons."""
IN_PLACE_PART, SOON_IN_PLACE_PART = 0.5, 0.9
"""Least fraction of corners in place for a picture to be still; the second is for less than a second."""
CHANGED_PART, SOON_CHANGED_PART = 0.65, 0.25
"""Largest fraction of cells that may have changed; the second is for less than a second."""


class Stillness:
    """Tells whether the picture has been still for a second.

    Args:
        follower: tracks the points of the pictures.
    """

    def __init__(self, follower: PointFollower) -> None:
        self._follower = follower
        self._kept: deque[SmallPicture] = deque()
        self._moved_ns = self._compared_ns = -AGO_NS
        self._lasts = False

    def keep(self, picture: SmallPicture, moves: bool) -> None:
        """Update with a picture; `moves` tells whether we are known to drive."""
        if moves:
            self._kept.clear()
            self._moved_ns = picture.time_ns
        elif not self._kept or picture.time_ns - self._kept[-1].time_ns >= KEPT_NS:
            self._kept.append(picture)
            while len(self._kept) > 1 and picture.time_ns - self._kept[1].time_ns >= AGO_NS:
                self._kept.popleft()

    def lasts(self, picture: SmallPicture, mean: FloatArray) -> bool:
        """Whether a picture is still the same as a second ago.

        True without a comparison if we were known to drive then. False if the drive has only just begun.

        Args:
            picture: the present picture.
            mean: (8,) expected unknowns of `fcw.motion.solver`.
        """
        if picture.time_ns - self._moved_ns < AGO_NS:
            return True
        if picture.time_ns - self._compared_ns >= KEPT_NS:
            self._compared_ns = picture.time_ns
            self._lasts = bool(self._kept) and self._is_still(self._kept[0], picture, mean)
        return self._lasts

    def _is_still(self, ago: SmallPicture, now: SmallPicture, mean: FloatArray) -> bool:
        passed_ns = now.time_ns - ago.time_ns
        if passed_ns < SOON_NS:
            return False
        least, most = IN_PLACE_PART, CHANGED_PART
        if passed_ns < AGO_NS:
            least, most = SOON_IN_PLACE_PART, SOON_CHANGED_PART
        follower = self._follower
        return follower.part_in_place(ago, now, mean) >= least and follower.part_changed(ago, now) <= most
