"""Rectangles cut out of pictures and resized, as windows are for training and for the net."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray


def cut_rectangle(
    picture: NDArray[np.uint8], left: float, top: float, width: float, height: float, side_px: int
) -> NDArray[np.uint8]:
    """A rectangle of a picture, the picture's edges repeated beyond it, resized to a square.

    Args:
        picture: (height, width, 3).
        left: of the rectangle, px, counted from the first pixel's edge, not its middle.
        top: likewise.
        width: px.
        height: px.
        side_px: side of the result.

    Returns:
        (side_px, side_px, 3) uint8.
    """
    first_x = min(max(math.floor(left), 0), picture.shape[1] - 1)
    first_y = min(max(math.floor(top), 0), len(picture) - 1)
    region = picture[
        first_y : max(math.ceil(top + height), first_y + 1),
        first_x : max(math.ceil(left + width), first_x + 1),
    ]
    # Halve while that loses nothing the result could hold, as a pyramid does; then one exact placement.
    halvings = max(0, math.floor(math.log2(min(width, height) / side_px)))
    by_x = by_y = 1.0
    if halvings:
        rows, columns = (math.ceil(side / 2**halvings) for side in region.shape[:2])
        by_x, by_y = columns / region.shape[1], rows / region.shape[0]
        region = cv2.resize(region, (columns, rows), interpolation=cv2.INTER_AREA)
    step_x, step_y = width * by_x / side_px, height * by_y / side_px
    # Output pixel i covers the part (i + 1/2) of the rectangle.
    to_source = np.array(
        [
            [step_x, 0.0, (left - first_x) * by_x + step_x / 2 - 0.5],
            [0.0, step_y, (top - first_y) * by_y + step_y / 2 - 0.5],
        ]
    )
    return np.asarray(
        cv2.warpAffine(
            region,
            to_source,
            (side_px, side_px),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        ),
        np.uint8,
    )
