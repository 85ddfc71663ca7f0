"""Where a drive is cut."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from fcw.errors import UserError
from fcw.frame import Frame, Source
from fcw.sources.forwarding import ForwardingSource
from fcw.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a drive; times on the source's clock.

    Attributes:
        number: 0-based.
        begins_ns: its first frame is at this time or after; None for the source's first.
        ends_ns: its last one is before; None for the source's last.
    """

    number: int
    begins_ns: int | None
    ends_ns: int | None


class PieceSource(ForwardingSource):
    """The frames of a piece: decoded from the keyframe before its first one on."""

    def __init__(self, source: Source, piece: Piece) -> None:
        super().__init__(source)
        self._piece = piece

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's, of this piece."""
        begins = [time_ns for time_ns in (start_ns, self._piece.begins_ns) if time_ns is not None]
        for frame in super().frames(max(begins, default=None)):
            if self._piece.ends_ns is not None and frame.time_ns >= self._piece.ends_ns:
                return
            yield frame


def plan_pieces(source: Source, piece_s: float) -> tuple[Piece, ...]:
    """Cut a drive into pieces of one length.

    Args:
        source: the drive; of one whose length is not known there is one piece.
        piece_s: about so long each is.

    Raises:
        UserError: that is no length of time, or the source cannot be read.
    """
    if not piece_s > 0:
        raise UserError(f"pieces of {piece_s:g} s: expected more than 0 s, e.g. 300")
    duration_s = (source.frame_count or 0) / source.frame_rate_hz
    count = max(round(duration_s / piece_s), 1)
    first = next(source.frames(), None)
    if first is None or count == 1:
        return (Piece(0, None, None),)
    cuts_ns = [first.time_ns + round(duration_s * NS_PER_S * number / count) for number in range(1, count)]
    return tuple(
        Piece(number, begins_ns, ends_ns)
        for number, (begins_ns, ends_ns) in enumerate(pairwise([None, *cuts_ns, None]))
    )
