"""A source that passes on what another source gives."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fcw.frame import CameraLike, Frame, ImageSize, Source, TimedSource, VideoLike, is_recorded


class ForwardingSource:
    """Passes on everything of another source; a subclass changes what it needs to."""

    def __init__(self, source: Source) -> None:
        self._source = source

    @property
    def name(self) -> str:
        """The source's."""
        return self._source.name

    @property
    def image_size(self) -> ImageSize:
        """The source's."""
        return self._source.image_size

    @property
    def frame_count(self) -> int | None:
        """The source's."""
        return self._source.frame_count

    @property
    def frame_rate_hz(self) -> float:
        """The source's."""
        return self._source.frame_rate_hz

    @property
    def times_ns(self) -> NDArray[np.int64] | None:
        """Times of all frames, if the source knows them before decoding; else None."""
        return self._source.times_ns if isinstance(self._source, TimedSource) else None

    @property
    def relays_video(self) -> bool:
        """The source's."""
        return self._source.relays_video

    @property
    def coded_anew(self) -> str:
        """Why the frames carry no packets, if the source is a video; else empty."""
        return self._source.coded_anew if isinstance(self._source, VideoLike) else ""

    @property
    def recorded(self) -> bool:
        """Whether the drive is a recording; all sources except cameras are."""
        return is_recorded(self._source)

    @property
    def trouble(self) -> str:
        """Why a camera gives no picture now; empty while pictures come, and for a recording."""
        return self._source.trouble if isinstance(self._source, CameraLike) else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's."""
        return self._source.notes

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's."""
        return self._source.frames(start_ns)
