"""What a source yields: decoded pictures, each with its time and the encoded packets behind it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

FALLBACK_RATE_HZ = 25.0
"""Of a video, a camera or a log that states no possible rate; frames keep their own times all the same."""
LEAST_RANGE = 10
"""Of 256: the darkest of 200 night pictures of BDD100K has 27, a covered sensor with a noise of 2 has 7."""
GRID = 32
"""Number of places of a row, and of a column, that are looked at."""
STRAY_PART = 20
"""The darkest and the brightest one of this many places do not count: recorders write the time into black."""


@dataclass(frozen=True, slots=True)
class ImageSize:
    """Width and height of a picture in pixels."""

    width: int
    height: int

    def __str__(self) -> str:
        return f"{self.width}x{self.height}"


@dataclass(frozen=True, slots=True)
class VideoPacket:
    """One encoded picture: H.264 in Annex B form, with everything needed to decode exactly one picture.

    Attributes:
        data: the access unit; a keyframe carries its SPS and PPS.
        time_ns: presentation time on the source's clock; may be negative for packets that only feed
            the decoder before the first shown frame (edit lists leave such packets).
        keyframe: whether decoding can start here.
        shown: False for packets whose picture is not part of the drive.
    """

    data: bytes
    time_ns: int
    keyframe: bool
    shown: bool


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One shown picture of a drive.

    Attributes:
        index: 0-based number among the shown frames.
        time_ns: presentation time on the source's clock, in nanoseconds.
        image: (height, width, 3) uint8, BGR, upright (rotation metadata already applied). It must stay as it
            is once the frame was given: up to eight frames are searched, followed and written at once, so a
            source has an array of its own for each.
        packets: where the source's own video can be relayed, the packets in decoding order since
            the previous frame, the last one being this frame's own; empty otherwise.
    """

    index: int
    time_ns: int
    image: NDArray[np.uint8]
    packets: tuple[VideoPacket, ...] = ()


def nothing_seen(image: NDArray[np.uint8]) -> bool:
    """Whether a picture, (height, width, 3) BGR, is of one brightness nearly everywhere."""
    height, width = image.shape[:2]
    down, across = max(height // GRID, 1), max(width // GRID, 1)
    # Green is most of what the eye takes for brightness.
    values = np.sort(image[down // 2 :: down, across // 2 :: across, 1], axis=None)
    stray = len(values) // STRAY_PART
    return int(values[-1 - stray]) - int(values[stray]) < LEAST_RANGE


class Source(Protocol):
    """Frames of one drive in the order of their times."""

    @property
    def name(self) -> str:
        """What a person calls it: the file's or the folder's name."""
        ...

    @property
    def image_size(self) -> ImageSize:
        """Size of every picture, after rotation."""
        ...

    @property
    def frame_count(self) -> int | None:
        """Estimated number of frames for a progress bar; None where unknown."""
        ...

    @property
    def frame_rate_hz(self) -> float:
        """Nominal frames per second; the frames' own times are what counts."""
        ...

    @property
    def relays_video(self) -> bool:
        """Whether the frames carry packets that a log can hold as they are."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of this source, complete once iteration has ended.

        For instance an applied rotation, or how much of a damaged file could be read.
        """
        ...

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns` (None: from the beginning).

        Each has an array that nobody writes to any more; see `Frame.image`.
        """
        ...


@runtime_checkable
class DatedSource(Protocol):
    """A source that may know when its drive was."""

    @property
    def zero_utc_ns(self) -> int | None:
        """What time 0 of its clock is in UTC, in nanoseconds since 1970; None where it does not know."""
        ...


@runtime_checkable
class VideoLike(Protocol):
    """A source that is a video, or stands before one, and can say why its packets cannot be relayed."""

    @property
    def coded_anew(self) -> str:
        """Why frames carry no packets, so that a log holds the pictures coded anew; empty where they do."""
        ...


@runtime_checkable
class TimedSource(Protocol):
    """A source that knows the times of its frames before it decodes them."""

    @property
    def times_ns(self) -> NDArray[np.int64] | None:
        """Times of all frames, ascending; None where only decoding tells."""
        ...


@runtime_checkable
class CameraLike(Protocol):
    """A source that is a camera, or stands before one: what it shows happens now."""

    @property
    def recorded(self) -> bool:
        """Whether it is a recording after all, given as if it happened now."""
        ...

    @property
    def trouble(self) -> str:
        """Why no picture comes at present, or any more; empty while they come."""
        ...


def is_recorded(source: Source) -> bool:
    """Whether a drive is a recording, as all are but those of cameras."""
    return source.recorded if isinstance(source, CameraLike) else True
