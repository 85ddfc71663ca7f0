"""Setting pictures upright as the container's display matrix asks."""

from collections.abc import Callable

import numpy as np
from av.video.frame import VideoFrame
from numpy.typing import NDArray

Orient = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]


def orientation(picture: VideoFrame) -> tuple[Orient, str]:
    """How to set a decoded picture upright, and that in words; empty words where it is upright.

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

    # Mirroring left and right first leaves a pure turn: by 90 or 270 degrees where x and y are exchanged.
    mirrored = transposed ^ flip_x ^ flip_y
    degrees = (90 if flip_x ^ mirrored else 270) if transposed else (180 if flip_y else 0)
    words = ["mirrored"] if mirrored else []
    if degrees:
        words.append(f"turned by {degrees} degrees clockwise")
    return orient, " and ".join(words)


def _as_is(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return image
