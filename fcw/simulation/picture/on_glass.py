"""What a camera sees of its own car: the bonnet, and a logo that it burns into its pictures."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

BONNET_PART = 0.07
"""How much of the picture's height the bonnet takes at its middle."""
BONNET_BGR, BONNET_EDGE_BGR = (46.0, 42.0, 40.0), (120.0, 112.0, 104.0)
LOGO_PARTS = 0.80, 0.62, 0.14, 0.10
"""Left edge, top edge, width and height, as parts of the picture: below the horizon, where vehicles are."""
LOGO_BGR, LOGO_GROUND_BGR = (235.0, 235.0, 235.0), (30.0, 30.0, 30.0)


def paint_on_glass(image: NDArray[np.float32], things: Sequence[str]) -> None:
    """Paint over the picture, in place.

    Args:
        image: (height, width, 3) BGR.
        things: of `fcw.simulation.world.scenario.ON_GLASS`.
    """
    height, width = image.shape[:2]
    if "bonnet" in things:
        top = height * (1 - BONNET_PART)
        middle, axes = (width // 2, round(top + height)), (round(width * 0.75), height)
        cv2.ellipse(image, middle, axes, 0, 180, 360, BONNET_BGR, -1)
        cv2.ellipse(image, middle, axes, 0, 180, 360, BONNET_EDGE_BGR, 3)
    if "logo" in things:
        left, top, w, h = (
            round(part * size) for part, size in zip(LOGO_PARTS, (width, height) * 2, strict=True)
        )
        # Text is drawn into pictures of bytes only.
        plate = np.full((h, w, 3), LOGO_GROUND_BGR, np.uint8)
        place, size, thickness = (w // 12, round(0.7 * h)), h / 45, max(h // 18, 1)
        cv2.putText(plate, "CAM 1", place, cv2.FONT_HERSHEY_SIMPLEX, size, LOGO_BGR, thickness)
        image[top : top + h, left : left + w] = plate
