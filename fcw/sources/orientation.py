"""Turns pictures upright and makes their pixels square, as the file states."""

from collections.abc import Callable
from fractions import Fraction

import cv2
import numpy as np
from av.video.frame import VideoFrame
from av.video.stream import VideoStream
from numpy.typing import NDArray

Orient = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]

SQUARE_WITHIN = 0.01
"""Pixels this near to square count as square: 854x480 is only nearly 16:9, and states that."""
WIDEST_PIXEL = 4.0
"""A file that states wider pixels, or narrower ones than its inverse, is wrong."""


def squaring(stream: VideoStream, picture: VideoFrame) -> tuple[Orient, str]:
    """How to make the pixels of a decoded picture square, and a description; empty if they are square.

    Anamorphic pictures (1440x1080 for 16:9) are stored narrower than they are shown, by the ratio of a
    pixel's sides (ISO/IEC 14496-10, E.2.1). Only with square pixels does one focal length hold for both
    directions.
    """
    ratio = stream.sample_aspect_ratio or Fraction(1)
    if abs(ratio - 1) < SQUARE_WITHIN or not 1 / WIDEST_PIXEL <= ratio <= WIDEST_PIXEL:
        return _as_is, ""
    width = max(round(picture.width * ratio), 1)

    def square(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        wider = width > image.shape[1]
        resized = cv2.resize(
            image, (width, image.shape[0]), interpolation=cv2.INTER_LINEAR if wider else cv2.INTER_AREA
        )
        return np.asarray(resized, np.uint8).reshape(image.shape[0], width, -1)

    return square, f"resized from {picture.width}x{picture.height} to {width}x{picture.height}"


def orientation(picture: VideoFrame) -> tuple[Orient, str]:
    """How to turn a decoded picture upright, and a description; empty if it is upright.

    The display matrix (ISO/IEC 14496-12, 6.2.2) maps picture (x, y) to (a x + c y, b x + d y). Cameras turn
    by quarters and mirror, so only the signs count.
    """
    matrix = picture.side_data.get("DISPLAYMATRIX")
    if matrix is None:
        return _as_is, ""
    a, b, _, c, d = np.frombuffer(bytes(matrix), np.int32)[:5].tolist()
    transposed = abs(b) > abs(a)
    flip_x, flip_y = (c < 0, b < 0) if transposed else (a < 0, d < 0)
    if not (transposed or flip_x or flip_y):
        return _as_is, ""

    def orient(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        turned = image.swapaxes(0, 1) if transposed else image
        return np.ascontiguousarray(turned[:: -1 if flip_y else 1, :: -1 if flip_x else 1])

    # After mirroring left and right, a pure turn remains; by 90 or 270 degrees if x and y are exchanged.
    mirrored = transposed ^ flip_x ^ flip_y
    degrees = (90 if flip_x ^ mirrored else 270) if transposed else (180 if flip_y else 0)
    words = ["mirrored"] if mirrored else []
    if degrees:
        words.append(f"turned by {degrees} degrees clockwise")
    return orient, " and ".join(words)


def _as_is(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return image
