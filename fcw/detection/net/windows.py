"""What the net sees: windows of a picture, each at its own scale.

A window is measured in units: a vehicle of sqrt(w h) = `VEHICLE_UNITS` stands in its middle, the bottom edge
`BOTTOM_UNITS` below its top, as in the cascade's windows (`fcw.detection.model.Window`).
"""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

WINDOW_UNITS = 64.0
VEHICLE_UNITS = 40.0
BOTTOM_UNITS = 52.0
INPUT_PX = 48
"""Side of what the net is given: 0.75 px a unit."""
SMALLEST_REGION_PX = 8


def cut_window(
    picture: NDArray[np.uint8],
    placement: NDArray[np.float64],
    side_units: float = WINDOW_UNITS,
    side_px: int = INPUT_PX,
) -> NDArray[np.uint8]:
    """A window, or more or less of the picture around its middle; beyond the picture its edges are repeated.

    Args:
        picture: (height, width, 3) BGR.
        placement: (3,) of the vehicle that the window expects: middle, bottom, sqrt(w h), px.
        side_units: how much is cut.
        side_px: side of the result.

    Returns:
        (side_px, side_px, 3) uint8.
    """
    middle, bottom, size = placement
    unit = size / VEHICLE_UNITS
    side = side_units * unit
    # Coordinates have their origin in the middle of the first pixel, cuts at its edge.
    left = middle + 0.5 - side / 2
    top = bottom + 0.5 - (BOTTOM_UNITS - WINDOW_UNITS / 2) * unit - side / 2
    first_x, first_y = max(math.floor(left), 0), max(math.floor(top), 0)
    region = picture[
        min(first_y, len(picture) - 1) : max(math.ceil(top + side), first_y + 1),
        min(first_x, picture.shape[1] - 1) : max(math.ceil(left + side), first_x + 1),
    ]
    by_x = by_y = 1.0
    halvings = math.floor(math.log2(side / side_px)) if side > 2 * side_px else 0
    if halvings and min(region.shape[:2]) > SMALLEST_REGION_PX:
        # Averaged down first, so that nothing is skipped; then one exact placement.
        columns, rows = (max(1, round(region.shape[axis] / 2**halvings)) for axis in (1, 0))
        by_x, by_y = columns / region.shape[1], rows / region.shape[0]
        region = cv2.resize(region, (columns, rows), interpolation=cv2.INTER_AREA)
    step_x, step_y = side * by_x / side_px, side * by_y / side_px
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


def boxes_of(placements: NDArray[np.float64], offsets: NDArray[np.floating]) -> NDArray[np.float64]:
    """(N, 4) x, y, w, h of vehicles, from where windows expect them and how they stand there.

    Args:
        placements: (N, 3) middle, bottom and size.
        offsets: (N, 4) of middle and bottom, in sizes; of width and height, the logarithm to the size.
    """
    middles, bottoms, sizes = placements.T
    widths, heights = sizes * np.exp(np.clip(offsets[:, 2:].T.astype(np.float64), -1.0, 1.0))
    middles, bottoms = middles + offsets[:, 0] * sizes, bottoms + offsets[:, 1] * sizes
    return np.column_stack([middles - widths / 2, bottoms - heights, widths, heights])
