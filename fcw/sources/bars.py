"""Cuts off the black bars, or another frame, around the pictures of a drive.

The upright picture of a phone is often put into a wide one, and a wide picture into a higher one, with black
or a blurred copy of the picture beside it, or above and below it. A detector mistakes the edges of the bars
for a vehicle that fills the picture, and a vehicle that a bar cuts off for a whole one. What is known of the
kinds of camera also holds only for their own pictures. So the bars are cut off before anything else.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.camera.lens.pixel_map import PixelMap
from fcw.frame import Frame, ImageSize, Source, nothing_seen
from fcw.sources.borders import LEAST_PART, UNEVEN_PART, Borders
from fcw.sources.forwarding import ForwardingSource
from fcw.units import NS_PER_S

BLACK = 24
"""No pixel of a bar is brighter than this, of 255. It is not 0 because encoders ring at the picture's
edge."""
MEAN_BLACK = 6.0
"""The mean of a bar's row or column is not above this; a picture's own black at night has noise and lamps."""
LOOKS = 6
"""So many pictures over the drive must all have the bars: a single picture may be dark, or fade in."""


class CutSource(ForwardingSource):
    """Gives a part of another source's pictures.

    Args:
        source: the source of the whole pictures.
        part: the map from whole pictures to the part.

    Attributes:
        part: as given.
    """

    def __init__(self, source: Source, part: PixelMap) -> None:
        super().__init__(source)
        self.part = part

    @property
    def image_size(self) -> ImageSize:
        """The size of the part."""
        return self.part.size

    @property
    def whole_size(self) -> ImageSize:
        """The size of the whole pictures."""
        return super().image_size

    @property
    def relays_video(self) -> bool:
        """Always False: the packets contain the whole pictures."""
        return False

    @property
    def coded_anew(self) -> str:
        """Why frames carry no packets."""
        return super().coded_anew or "bars around them are cut off"

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's notes, and what was cut off."""
        sides = [name for name, px in (("beside", self.part.left_px), ("above", self.part.top_px)) if px]
        where = " and ".join("above and below" if side == "above" else side for side in sides)
        return (
            *super().notes,
            f"{self.name}: the bars {where} the picture are cut off, which leaves {self.part.size} of "
            f"{self.whole_size}",
        )

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's frames, cut to the part."""
        left, top, size = self.part.left_px, self.part.top_px, self.part.size
        for frame in super().frames(start_ns):
            image = np.ascontiguousarray(frame.image[top : top + size.height, left : left + size.width])
            yield replace(frame, image=image, packets=())


def without_bars(source: Source) -> tuple[Source, PixelMap | None]:
    """A source without the bars around its pictures, and the map to the rest; None if there are no bars.

    A source of unknown length, such as a camera, is returned as it is.
    """
    part = _picture_in(source)
    return (source, None) if part is None else (CutSource(source, part), part)


def for_pictures(calibration: Calibration, source: Source) -> Calibration:
    """Adapt a calibration to the pictures of a source.

    The calibration may be for these pictures, for the same pictures with their bars, or without them.

    Raises:
        UserError: the calibration is for pictures of another shape.
    """
    size = calibration.image_size
    if isinstance(source, CutSource):
        if size == source.whole_size:
            return calibration.through(source.part)
    elif size != source.image_size:
        _, part = without_bars(source)
        if part is not None and part.size == size:
            return calibration.through(part.back(source.image_size))
    return calibration.for_image_size(source.image_size)


def _picture_in(source: Source) -> PixelMap | None:
    """The part of the pictures without black bars or a frame; None if that is the whole picture."""
    least: NDArray[np.int64] | None = None
    borders = Borders()
    for image in _looks(source):
        if nothing_seen(image):
            continue
        margins = _margins(image)
        least = margins if least is None else np.minimum(least, margins)
        borders.see(image)
        if not least.any() and not borders.may_be:
            return None
    if least is None or not (margins := np.maximum(least, borders.margins)).any():
        return None
    return _without(source.image_size, margins)


def _looks(source: Source) -> Iterator[NDArray[np.uint8]]:
    """Pictures spread over a drive, beginning with the first; none if its length is unknown."""
    count, rate_hz = source.frame_count, source.frame_rate_hz
    if count is None:
        return
    first = next(source.frames(), None)
    if first is None:
        return
    yield first.image
    for look in range(1, LOOKS):
        start_ns = first.time_ns + round(look / LOOKS * count / rate_hz * NS_PER_S)
        if (frame := next(source.frames(start_ns), None)) is not None:
            yield frame.image


def _margins(image: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Numbers of black columns left and right, and of black rows above and below.

    They are 0 unless both of two opposite sides are about equally wide.
    """
    peak = image.max(axis=2)
    margins = np.zeros(4, np.int64)
    for axis in (0, 1):
        black = (peak.max(axis=axis) <= BLACK) & (peak.mean(axis=axis) <= MEAN_BLACK)
        first, last = int(np.argmin(black)), int(np.argmin(black[::-1]))
        if min(first, last) >= LEAST_PART * len(black) and abs(first - last) <= UNEVEN_PART * len(black):
            margins[2 * axis : 2 * axis + 2] = first, last
    return margins


def _without(size: ImageSize, margins: NDArray[np.int64]) -> PixelMap:
    """The map to the part within the margins, with even width and height as video encoders need."""
    left, right, top, bottom = (int(px) for px in margins)
    width, height = size.width - left - right, size.height - top - bottom
    return PixelMap(ImageSize(width - width % 2, height - height % 2), left_px=left, top_px=top)
