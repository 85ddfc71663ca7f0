"""Random access to the pictures of a drive: exactly those that iteration gives."""

import threading
from collections import OrderedDict, deque
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize, Source, TimedSource

CACHE_BYTES = 128 << 20
"""Nearly fifty pictures of 1280x720, so that stepping back and forth decodes nothing twice."""
READ_ON_FRAMES = 12
"""Up to so many frames ahead, reading on is faster than seeking to the keyframe before."""
READ_BACK_FRAMES = 8
"""When stepping back, so many pictures before the requested one are kept, since they are decoded anyway."""


class Pictures:
    """The frames of a source by number; thread-safe.

    The number counts the frames that the source announces; in an undamaged source it equals `Frame.index`.

    Attributes:
        source: the source.
        count: number of frames. If only decoding tells it (see `TimedSource`), it is an estimate until the
            last frame has been read.
    """

    def __init__(self, source: Source) -> None:
        """Read the times of the frames; a video is read through once for that, without decoding."""
        self.source = source
        self._times_ns = source.times_ns if isinstance(source, TimedSource) else None
        known = None if self._times_ns is None else len(self._times_ns)
        self.count = max(1, known or source.frame_count or 1)
        self._count_known = self._times_ns is not None
        self._lock = threading.Lock()
        self._cache: OrderedDict[int, Frame] = OrderedDict()
        size = source.image_size
        self._cache_size = max(READ_BACK_FRAMES, CACHE_BYTES // (3 * size.width * size.height))
        self._cursor: Iterator[Frame] = iter(())
        self._cursor_index = -1
        """Number of the frame that the cursor gave last; -1 if there is none."""
        self._last_read = -1

    @property
    def name(self) -> str:
        """The name of the source."""
        return self.source.name

    @property
    def image_size(self) -> ImageSize:
        """Size of every picture."""
        return self.source.image_size

    @property
    def frame_rate_hz(self) -> float:
        """Nominal frames per second."""
        return self.source.frame_rate_hz

    def read(self, index: int) -> Frame:
        """The frame with this number; `Frame.index` tells which one was returned.

        A number before the first or beyond the last gives the first or the last frame. For a damaged picture,
        the next one that can be decoded is returned, or at the end the one before. The image is shared: draw
        into a copy.

        Raises:
            UserError: the source can no longer be read, or a picture in it has another size.
        """
        with self._lock:
            index = max(0, min(index, self.count - 1) if self._count_known else index)
            frame = self._cache.get(index)
            if frame is None:
                frame = self._decode(index)
                self._keep(index, frame)
            else:
                self._cache.move_to_end(index)
            self._last_read = index
            return frame

    def play(self, start_index: int) -> Iterator[Frame]:
        """Frames from this number on, by a separate reader, so that `read` is not blocked.

        Raises:
            UserError: as `read`.
        """
        return self._frames_from(min(max(start_index, 0), self.count - 1))

    def _decode(self, index: int) -> Frame:
        """Decode a frame: by reading on if it is near, else from the keyframe before."""
        if not 0 <= self._cursor_index < index <= self._cursor_index + READ_ON_FRAMES:
            stepping_back = index == self._last_read - 1
            self._go_to(max(0, index - READ_BACK_FRAMES + 1) if stepping_back else index)
        for frame in self._cursor:
            self._cursor_index = frame.index
            self._keep(frame.index, frame)
            if frame.index >= index:
                return frame
        return self._last_before(index)

    def _last_before(self, index: int) -> Frame:
        """The last frame that can be decoded, if there is none from `index` on."""
        self._cursor, self._cursor_index = iter(()), -1
        back = READ_BACK_FRAMES
        while True:
            start = max(0, index - back) if self._times_ns is not None else 0
            last = next(iter(deque(self._frames_from(start), maxlen=1)), None)
            if last is not None:
                if not self._count_known:
                    self.count, self._count_known = last.index + 1, True
                return last
            if start == 0:
                raise UserError(
                    f"{self.name}: its pictures can no longer be read; check that the file is still there, "
                    "then open the page again"
                )
            back *= 4

    def _go_to(self, index: int) -> None:
        self._cursor, self._cursor_index = self._frames_from(index), -1

    def _frames_from(self, index: int) -> Iterator[Frame]:
        """Frames from a number on, each with its number and without packets."""
        if self._times_ns is None:
            for frame in self.source.frames():
                if frame.index >= index:
                    yield replace(frame, packets=())
            return
        for frame in self.source.frames(int(self._times_ns[index])):
            # A damaged picture has a number, but iteration does not count it.
            number = int(np.searchsorted(self._times_ns, frame.time_ns))
            yield replace(frame, index=number, packets=())

    def _keep(self, index: int, frame: Frame) -> None:
        self._cache[index] = frame
        self._cache.move_to_end(index)
        while len(self._cache) > self._cache_size:
            self._cache.popitem(last=False)
