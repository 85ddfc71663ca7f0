"""What the net sees: windows of a picture, each at its own scale.

A window is measured in units: a vehicle of sqrt(w h) = `VEHICLE_UNITS` stands in its middle, the bottom edge
`BOTTOM_UNITS` below its top, as in the cascade's windows (`fcw.detection.model.Window`).
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.cutting import cut_rectangle

WINDOW_UNITS = 64.0
VEHICLE_UNITS = 40.0
BOTTOM_UNITS = 52.0
INPUT_PX = 48
"""Side of what the net is given: 0.75 px a unit."""


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
    return cut_rectangle(picture, left, top, side, side, side_px)


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
