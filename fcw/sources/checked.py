"""Checks the frames of a source that the user plugs in."""

from collections.abc import Iterator

import numpy as np

from fcw.errors import UserError
from fcw.frame import DatedSource, Frame
from fcw.sources.forwarding import ForwardingSource


class CheckedSource(ForwardingSource):
    """Gives another source's frames and checks that they are what `Frame` promises.

    Without the check, pictures of another size or with a fourth channel would give wrong distances.
    """

    @property
    def zero_utc_ns(self) -> int | None:
        """The source's, if it has one."""
        return self._source.zero_utc_ns if isinstance(self._source, DatedSource) else None

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's frames.

        Raises:
            UserError: a picture has a wrong shape or type, or a time is not a whole number or is earlier than
                the time of the frame before.
        """
        size = self.image_size
        shape = (size.height, size.width, 3)
        last_ns: int | None = None
        for frame in super().frames(start_ns):
            image: object = frame.image
            if not isinstance(image, np.ndarray):
                raise self._wrong(frame, f"a picture of the type {type(image).__name__}", "an array of NumPy")
            if image.shape != shape or image.dtype != np.uint8:
                expected = f"{shape} of uint8, which is BGR of the source's image_size {size}"
                raise self._wrong(frame, f"a picture of the shape {image.shape} of {image.dtype}", expected)
            if not isinstance(frame.time_ns, int | np.integer):
                raise self._wrong(frame, f"the time {frame.time_ns!r:.80}", "nanoseconds in a whole number")
            if last_ns is not None and frame.time_ns < last_ns:
                expected = f"{last_ns}, as of the frame before, or later"
                raise self._wrong(frame, f"the time {frame.time_ns} ns", expected)
            last_ns = frame.time_ns
            yield frame

    def _wrong(self, frame: Frame, what: str, expected: str) -> UserError:
        return UserError(f"source {self.name!r}, frame {frame.index}: {what}; expected {expected}")
