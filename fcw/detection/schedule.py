"""Which pictures of a drive are searched for vehicles: enough of them, and evenly in time."""

import math

from fcw.units import NS_PER_S

DEFAULT_SEARCH_HZ = 0.0
"""Every picture. With 12 per second, a run takes a quarter less time, but it could not be shown that nothing
is lost (docs/figures/speed.md, "Fewer searches")."""


class SearchSchedule:
    """Selects every picture of a drive with a low frame rate, and every second or third one of a fast drive.

    The selection does not depend on the tracker, so that several pictures can be searched at once. If the
    tracker needs more, `Tracker.wants_search` says so after the previous frame.

    Time is divided into equal spans of a whole number of pictures at the nominal rate, and the first picture
    in each is searched. So the selection depends on the times alone, wherever a piece of the drive begins.

    Args:
        frame_rate_hz: nominal frame rate of the drive.
        least_hz: least number of pictures per second that are searched, if there are as many; 0 searches all.

    Attributes:
        every: number of pictures in a span, at the nominal rate.
    """

    def __init__(self, frame_rate_hz: float, least_hz: float) -> None:
        # 23.976 frames per second count as 24.
        self.every = max(math.floor(1.01 * frame_rate_hz / least_hz), 1) if least_hz > 0 else 1
        self._frame_rate_hz = frame_rate_hz
        self._span: int | None = None

    def searches(self, time_ns: int) -> bool:
        """Whether the next picture is searched. To be called once for each picture, in order of time."""
        if self.every == 1:
            return True
        number = time_ns / NS_PER_S * self._frame_rate_hz
        before, self._span = self._span, math.floor((number + 0.5) / self.every)
        return self._span != before
