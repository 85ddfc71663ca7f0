"""The parts of a recorded clip that is cut, as by editing: each is of one camera, the whole may not be."""

from collections.abc import Callable, Iterator

from fcw.frame import Frame, Source
from fcw.motion.flow.cuts import CutWatch, Follows

LONGEST_S = 40.0
"""So much of a clip is looked at."""
WHOLE_CLIP_S = (0.0, LONGEST_S)
BEFORE_CUT_S = 0.2
"""A cut is known by the second picture after it."""


class ClipParts:
    """Finds the parts while the pictures go by.

    Args:
        piece_s: from when to when the clip is looked at, in seconds since it began.
    """

    def __init__(self, piece_s: tuple[float, float] = WHOLE_CLIP_S) -> None:
        self._cuts = CutWatch()
        self._parts_s = [piece_s]
        self._last_s = piece_s[0]

    def see(self, time_s: float, frame: Frame) -> None:
        """Take the next picture."""
        if self._cuts.see(frame.time_ns, frame.image) is Follows.AFTER_CUT:
            begin_s, end_s = self._parts_s[-1]
            self._parts_s[-1] = begin_s, time_s - BEFORE_CUT_S
            self._parts_s.append((time_s, end_s))
        self._last_s = time_s

    @property
    def parts_s(self) -> tuple[tuple[float, float], ...]:
        """From when to when each part is; the whole piece where there is no cut."""
        if len(self._parts_s) == 1:
            return tuple(self._parts_s)
        *before_s, (begin_s, _) = self._parts_s
        return (*before_s, (begin_s, self._last_s))


def longest_of(parts_s: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    """The longest part; of equal ones the first."""
    return max(parts_s, key=lambda part_s: part_s[1] - part_s[0])


def longest_part_s(
    source: Source, longest_s: float = LONGEST_S, going_on: Callable[[], bool] = lambda: True
) -> tuple[float, float]:
    """From when to when the longest part of a clip is; all that is looked at where the clip is not cut.

    Args:
        source: its pictures.
        longest_s: how much of the clip is looked at.
        going_on: whether somebody still wants to know.
    """
    parts = ClipParts((0.0, longest_s))
    for time_s, frame in pictures_of(source, (0.0, longest_s)):
        if not going_on():
            break
        parts.see(time_s, frame)
    return longest_of(parts.parts_s)


def pictures_of(source: Source, piece_s: tuple[float, float]) -> Iterator[tuple[float, Frame]]:
    """Pictures of a piece, each with its time since the clip began."""
    first_ns = None
    for frame in source.frames():
        first_ns = frame.time_ns if first_ns is None else first_ns
        time_s = (frame.time_ns - first_ns) / 1e9
        if time_s > piece_s[1]:
            return
        if time_s >= piece_s[0]:
            yield time_s, frame


def piece_words(piece_s: tuple[float, float]) -> str:
    """From when to when, as people say it."""
    begin_s, end_s = piece_s
    if end_s >= LONGEST_S:
        return f"from {begin_s:.0f} s on"
    return f"from {begin_s:.0f} s to {end_s:.0f} s" if begin_s else f"until {end_s:.0f} s"
