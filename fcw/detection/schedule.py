"""Which pictures of a drive are searched for vehicles: enough of them, evenly in time."""

import math

from fcw.units import NS_PER_S

DEFAULT_SEARCH_HZ = 0.0
"""Every picture. With 12 a second a run takes a quarter less time, but that nothing is lost by it could not
be shown (docs/figures/speed.md, "Fewer searches")."""


class SearchSchedule:
    """Every picture of a slow drive, every second or third one of a fast drive.

    These are known before anything is followed, so that several can be searched at once. Where more are
    wanted, `Tracker.wants_search` says so once the frame before was followed.

    Time is cut into equal spans, each of a whole number of pictures at the nominal rate. The first picture in
    each is searched, so that what is searched follows from the times, wherever a piece of the drive begins.

    Args:
        frame_rate_hz: nominal rate of the drive's pictures.
        least_hz: least number of pictures a second that are searched, if there are as many; 0 searches all.

    Attributes:
        every: one picture in so many is searched, at the nominal rate.
    """

    def __init__(self, frame_rate_hz: float, least_hz: float) -> None:
        # A drive of 23.976 a second counts as one of 24.
        self.every = max(math.floor(1.01 * frame_rate_hz / least_hz), 1) if least_hz > 0 else 1
        self._frame_rate_hz = frame_rate_hz
        self._span: int | None = None

    def searches(self, time_ns: int) -> bool:
        """Whether the next picture is searched; asked once for each, in the order of their times."""
        if self.every == 1:
            return True
        number = time_ns / NS_PER_S * self._frame_rate_hz
        before, self._span = self._span, math.floor((number + 0.5) / self.every)
        return self._span != before
