"""Pictures without the black bars, or another frame, around them.

A telephone's upright picture is often put into a wide one, and a wide one into a higher one, with black, or
a blurred copy of it, beside or above and below it. A detector takes the edges of the bars for those of
vehicles that fill the picture, and what the bars cut off for a whole vehicle; and what is known of cameras
is known of their own pictures. So bars are cut off before anything looks.
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
"""No pixel of a bar is brighter, of 256: an encoder rings beside the picture's edge."""
MEAN_BLACK = 6.0
"""Nor is a row or column of a bar in the mean; a camera's own black at night has noise and lamps."""
LOOKS = 6
"""Pictures over the drive that must all have the bars: one alone may be dark, or fade in."""


class CutSource(ForwardingSource):
    """A part of another source's pictures.

    Args:
        source: the whole pictures.
        part: from them to the part.

    Attributes:
        part: as given.
    """

    def __init__(self, source: Source, part: PixelMap) -> None:
        super().__init__(source)
        self.part = part

    @property
    def image_size(self) -> ImageSize:
        """The part's."""
        return self.part.size

    @property
    def whole_size(self) -> ImageSize:
        """Of the whole pictures."""
        return super().image_size

    @property
    def relays_video(self) -> bool:
        """Never: the packets hold the whole pictures."""
        return False

    @property
    def coded_anew(self) -> str:
        """Why there are no packets."""
        return super().coded_anew or "bars around them are cut off"

    @property
    def notes(self) -> tuple[str, ...]:
        """The source's, and what was cut off."""
        sides = [name for name, px in (("beside", self.part.left_px), ("above", self.part.top_px)) if px]
        where = " and ".join("above and below" if side == "above" else side for side in sides)
        return (
            *super().notes,
            f"{self.name}: the bars {where} the picture are cut off, which leaves {self.part.size} of "
            f"{self.whole_size}",
        )

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        """The source's, cut."""
        left, top, size = self.part.left_px, self.part.top_px, self.part.size
        for frame in super().frames(start_ns):
            image = np.ascontiguousarray(frame.image[top : top + size.height, left : left + size.width])
            yield replace(frame, image=image, packets=())


def without_bars(source: Source) -> tuple[Source, PixelMap | None]:
    """A source without the bars around its pictures, and the map to what is left; None where it has none.

    What has no known length, such as a camera, is left as it is.
    """
    part = _picture_in(source)
    return (source, None) if part is None else (CutSource(source, part), part)


def for_pictures(calibration: Calibration, source: Source) -> Calibration:
    """A calibration for a source's pictures; also one of them with their bars, or of what bars leave of them.

    Raises:
        UserError: it is of pictures of another shape.
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
    """The part of the pictures that is not always black, or a frame; None where it is all of them."""
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
    """Pictures spread over a drive, the first one first; none of one without a known length."""
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
    """Black columns left and right, and black rows above and below; 0 of sides that are not as wide."""
    peak = image.max(axis=2)
    margins = np.zeros(4, np.int64)
    for axis in (0, 1):
        black = (peak.max(axis=axis) <= BLACK) & (peak.mean(axis=axis) <= MEAN_BLACK)
        first, last = int(np.argmin(black)), int(np.argmin(black[::-1]))
        if min(first, last) >= LEAST_PART * len(black) and abs(first - last) <= UNEVEN_PART * len(black):
            margins[2 * axis : 2 * axis + 2] = first, last
    return margins


def _without(size: ImageSize, margins: NDArray[np.int64]) -> PixelMap:
    """The map to what margins leave: of even width and height, as video is encoded."""
    left, right, top, bottom = (int(px) for px in margins)
    width, height = size.width - left - right, size.height - top - bottom
    return PixelMap(ImageSize(width - width % 2, height - height % 2), left_px=left, top_px=top)
