"""Whether the picture is still that of a second ago.

From one picture to the next a heavily compressed video may repeat nearly all of it while we drive, and drops
on the windscreen stand at any speed. A second later most of the codec's blocks have been drawn anew, and
beside the drops all is another. What stands, stands for long.

The limits were set while looking at four clips of standing cameras, six of driving ones made so poor that
they seemed to stand, and one through drops. A second later 59 to 85 % of the corners of the first were in
their place, in the median, and of the poor ones 1 to 33 %; of the drops' 58 %, but there 90 % of the cells
had changed, of the standing ones' 26 to 37 %.
"""

from collections import deque

from fcw.camera.ground_plane import FloatArray
from fcw.motion.flow.points import PointFollower, SmallPicture

AGO_NS, SOON_NS = 1_000_000_000, 300_000_000
"""The picture is compared with one of a second ago, or with a later one if there is none yet."""
KEPT_NS = 200_000_000
"""Time between two pictures that are kept, and between two comparisons."""
IN_PLACE_PART, SOON_IN_PLACE_PART = 0.5, 0.9
"""A picture stands if at least this part of its corners is in place; the second part is for a picture of less
than a second ago."""
CHANGED_PART, SOON_CHANGED_PART = 0.65, 0.25
"""Largest part of its cells that may have changed, likewise."""


class Stillness:
    """Tells whether pictures stand for a second.

    Args:
        follower: of their points.
    """

    def __init__(self, follower: PointFollower) -> None:
        self._follower = follower
        self._kept: deque[SmallPicture] = deque()
        self._moved_ns = self._compared_ns = -AGO_NS
        self._lasts = False

    def keep(self, picture: SmallPicture, moves: bool) -> None:
        """Take a picture; `moves` where it is known that we drive."""
        if moves:
            self._kept.clear()
            self._moved_ns = picture.time_ns
        elif not self._kept or picture.time_ns - self._kept[-1].time_ns >= KEPT_NS:
            self._kept.append(picture)
            while len(self._kept) > 1 and picture.time_ns - self._kept[1].time_ns >= AGO_NS:
                self._kept.popleft()

    def lasts(self, picture: SmallPicture, mean: FloatArray) -> bool:
        """Whether a picture after those that were kept is still that of a second ago.

        Where it was known then that we drove it is not asked; where the drive had not begun it is not known.

        Args:
            picture: that one.
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
