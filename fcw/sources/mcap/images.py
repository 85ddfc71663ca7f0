"""Reads single pictures from an MCAP file, encoded or raw."""

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.sources.mcap.file import Clock, Logged, McapFile, Topic, stray_notes
from fcw.sources.mcap.pictures import PICTURE_READERS, Image, UnknownPictureError
from fcw.sources.mcap.video import counted, frame_rate_hz

RATE_PICTURES = 32
"""Number of pictures at the beginning from which the rate is computed."""


class McapImageSource:
    """Reads pictures that are encoded one by one, or raw.

    Attributes:
        image_size: size of every picture.
        frame_rate_hz: rate from the median step at the beginning.
        relays_video: False, because there are no packets.
    """

    relays_video = False

    def __init__(self, file: McapFile, topic: Topic) -> None:
        """Decode the first picture.

        Raises:
            UserError: there is none, or the pictures have a form that cannot be read.
        """
        self._file, self._topic = file, topic
        self._label = f"{file.path}: {topic}"
        self._clock = Clock.of(file, topic.name)
        self._read: Callable[[Any], Image | None] = PICTURE_READERS[topic.type]
        self._notes: tuple[str, ...] = ()
        self._table_ns: NDArray[np.int64] | None = None
        beginning: list[int] = []
        size: ImageSize | None = None
        stated = ""
        for message, time_ns, _ in islice(self._clock.timed(file.messages([topic.name])), RATE_PICTURES):
            beginning.append(time_ns)
            stated = stated or message.read(lambda content: str(content.format)) or ""
            if size is None and (image := self._image(message)) is not None:
                size = _size(image)
        if size is None:
            raise UserError(
                f"{self._label}: none of its first {RATE_PICTURES} pictures can be decoded"
                + (f" (they state the format {stated[:40]!r})" if stated else "")
                + "; expected pictures such as JPEG, PNG or WebP"
            )
        self.image_size = size
        self.frame_rate_hz = frame_rate_hz(np.unique(np.maximum.accumulate(np.array(beginning, np.int64))))

    @property
    def name(self) -> str:
        """The file's name."""
        return self._file.path.name

    @property
    def frame_count(self) -> int | None:
        """Number of messages, if the file states it."""
        return self._topic.count

    @property
    def times_ns(self) -> NDArray[np.int64]:
        """Times of all pictures, ascending, found in one pass over the file without decoding pictures."""
        if self._table_ns is None:
            messages = self._clock.timed(self._file.messages([self._topic.name]))
            times = [time_ns for _, time_ns, _ in messages]
            self._table_ns = np.unique(np.maximum.accumulate(np.array(times, np.int64)))
        return self._table_ns

    @property
    def notes(self) -> tuple[str, ...]:
        """After iteration, what could not be read."""
        return self._notes + self._file.notes

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """Frames from the first one at or after `start_ns`."""
        self._notes = ()
        undecodable, late, strays, index = 0, 0, 0, 0
        last_ns: int | None = None
        search_ns: int | None = None
        if start_ns is not None and start_ns > self.times_ns[0]:
            search_ns = self._clock.search_ns(start_ns)
        messages = self._file.messages([self._topic.name], search_ns)
        for message, time_ns, stray in self._clock.timed(messages):
            if last_ns is None and search_ns is not None:
                index = int(np.searchsorted(self.times_ns, time_ns))
            if last_ns is not None and time_ns <= last_ns:
                late += 1
                continue
            last_ns = time_ns
            strays += stray
            if start_ns is None or time_ns >= start_ns:
                image = self._image(message)
                if image is None:
                    undecodable += 1
                    continue
                if _size(image) != self.image_size:
                    self._notes = (
                        f"{self._label}: the picture size changes from {self.image_size} to {_size(image)}; "
                        "the rest is left out",
                    )
                    return
                yield Frame(index, time_ns, image)
            index += 1
        if undecodable:
            self._notes += (f"{self._label}: {counted(undecodable)} that cannot be decoded, left out",)
        self._notes += stray_notes(self._label, strays, "picture")
        if late:
            self._notes += (f"{self._label}: {counted(late)} with a time not after the one before, left out",)

    def _image(self, message: Logged) -> Image | None:
        try:
            return message.read(self._read)
        except UnknownPictureError as error:
            raise UserError(f"{self._label}: {error}") from None


def _size(image: Image) -> ImageSize:
    return ImageSize(image.shape[1], image.shape[0])
