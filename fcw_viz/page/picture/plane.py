"""Where pixels of a picture are in viser's scene: a plane that the camera looks at squarely.

Scene axes: x to the right, y away from the eye, z up; the picture's middle is the origin.
"""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.frame import ImageSize

FIELD_OF_VIEW_RAD = math.radians(30)
"""Of the scene's camera, vertical."""
FACING_WXYZ = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
"""Orientation of an image node that faces the eye (viser's image: x right, y down), as of a level camera."""

_EXTENT = 10.0  # scene units along the picture's longer side; the depth's resolution goes with it
_LAYER_SPACING = 2e-5  # scene units: resolved by depth, yet no visible parallax


class PicturePlane:
    """The plane of a picture of one size.

    Attributes:
        size: of the picture.
        scale: scene units along an image pixel.
    """

    def __init__(self, size: ImageSize) -> None:
        self.size = size
        self.scale = _EXTENT / max(size.width, size.height)

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the picture in scene units."""
        return self.size.width * self.scale, self.size.height * self.scale

    @property
    def middle_px(self) -> tuple[float, float]:
        """Column and row of the picture's middle."""
        return (self.size.width - 1) / 2, (self.size.height - 1) / 2

    def world(self, column_px: float, row_px: float, layer: int = 0) -> tuple[float, float, float]:
        """The scene position of a pixel; higher layers are nearer to the eye."""
        middle_column_px, middle_row_px = self.middle_px
        x, z = (column_px - middle_column_px) * self.scale, (middle_row_px - row_px) * self.scale
        return x, -layer * _LAYER_SPACING, z

    def pixel(self, position: NDArray[np.float64]) -> tuple[float, float]:
        """The (column, row) straight behind a scene position."""
        middle_column_px, middle_row_px = self.middle_px
        x, _, z = (float(value) for value in position)
        return middle_column_px + x / self.scale, middle_row_px - z / self.scale

    def pixel_under(self, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> tuple[float, float]:
        """The (column, row) where a ray of the scene meets the plane."""
        return self.pixel(origin - origin[1] / direction[1] * direction)

    def pixels_per_screen_pixel(self, distance: float, screen_height_px: int) -> float:
        """Image pixels that a CSS pixel covers, seen from a distance in a window of that height."""
        return 2 * distance * math.tan(FIELD_OF_VIEW_RAD / 2) / self.scale / screen_height_px

    def distance(self, pixels_per_screen_pixel: float, screen_height_px: int) -> float:
        """How far away a CSS pixel covers that many image pixels."""
        return pixels_per_screen_pixel / self.pixels_per_screen_pixel(1, screen_height_px)

    def is_inside(self, column_px: float, row_px: float) -> bool:
        """Whether a position is on the picture."""
        return -0.5 <= column_px <= self.size.width - 0.5 and -0.5 <= row_px <= self.size.height - 0.5


def layer_offset(layers: int) -> tuple[float, float, float]:
    """What moves a node of the scene that many layers nearer to the eye."""
    return 0.0, -layers * _LAYER_SPACING, 0.0
