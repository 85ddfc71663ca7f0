"""Drawing in metres: polygons with shading, smoothed by supersampling."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.float32]
Bgr = tuple[float, float, float]
Point = tuple[float, float]
Shade = Sequence[tuple[float, float]]
"""Factors of brightness at ascending heights in metres, interpolated between them."""

PIXELS_PER_METRE = 160
"""As fine as the picture of a 1000 px camera shows a vehicle 6 m away."""
SUPERSAMPLING = 2
CORNER_CUTS = 2
"""A right angle becomes four edges."""
_SHIFT = 4
"""Bits behind the point of the corners that OpenCV fills between."""


class Canvas:
    """A (rows, columns, 4) BGRA picture, alpha 0 to 1, addressed in metres: x from the middle, y up.

    Args:
        width_m: of the picture.
        height_m: of the picture.
        pixels_per_metre: of the finished picture.
    """

    def __init__(self, width_m: float, height_m: float, pixels_per_metre: float = PIXELS_PER_METRE) -> None:
        self._finished = (
            max(round(width_m * pixels_per_metre), 2),
            max(round(height_m * pixels_per_metre), 2),
        )
        columns, rows = self._finished[0] * SUPERSAMPLING, self._finished[1] * SUPERSAMPLING
        self._scale_x, self._scale_y = columns / width_m, rows / height_m
        self.image: FloatImage = np.zeros((rows, columns, 4), np.float32)

    def fill(
        self,
        points_m: Sequence[Point],
        color: Bgr,
        shade: Shade = (),
        alpha: float = 1.0,
        rounding_m: float = 0.0,
    ) -> None:
        """Fill a polygon.

        Args:
            points_m: its corners.
            color: BGR, 0 to 255.
            shade: brightness by height; none: the plain colour.
            alpha: what it covers, 0 to 1.
            rounding_m: how far from its corners the outline begins to turn.
        """
        rows, columns = self.image.shape[:2]
        points = np.array(points_m, np.float64)
        for _ in range(CORNER_CUTS if rounding_m else 0):
            points = _cut_corners(points, rounding_m)
        # Pixel centres are whole numbers, so the edge of the picture is at -0.5.
        pixels = np.column_stack(
            (points[:, 0] * self._scale_x + columns / 2, rows - points[:, 1] * self._scale_y)
        )
        pixels -= 0.5
        left, top = np.clip(np.floor(pixels.min(axis=0)).astype(int) - 1, 0, (columns, rows))
        right, bottom = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + 2, 0, (columns, rows))
        if right <= left or bottom <= top:
            return
        mask = np.zeros((bottom - top, right - left), np.uint8)
        corners = np.round((pixels - (left, top)) * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(mask, [corners], 255, cv2.LINE_AA, _SHIFT)
        cover = mask.astype(np.float32)[..., None] * (alpha / 255)
        paint = np.ones((bottom - top, 1, 4), np.float32)
        paint[..., :3] = color
        if shade:
            heights_m = (rows - 0.5 - np.arange(top, bottom)) / self._scale_y
            factors = np.interp(heights_m, [y for y, _ in shade], [factor for _, factor in shade])
            paint[:, 0, :3] *= factors.astype(np.float32)[:, None]
        region = self.image[top:bottom, left:right]
        region += (paint - region) * cover

    def mirrored(
        self,
        points_m: Sequence[Point],
        color: Bgr,
        shade: Shade = (),
        alpha: float = 1.0,
        rounding_m: float = 0.0,
    ) -> None:
        """Fill a polygon and its mirror image about the middle."""
        self.fill(points_m, color, shade, alpha, rounding_m)
        self.fill([(-x, y) for x, y in points_m], color, shade, alpha, rounding_m)

    def rectangle(
        self,
        left_m: float,
        low_m: float,
        right_m: float,
        high_m: float,
        color: Bgr,
        shade: Shade = (),
        alpha: float = 1.0,
    ) -> None:
        """Fill a rectangle."""
        points = [(left_m, low_m), (right_m, low_m), (right_m, high_m), (left_m, high_m)]
        self.fill(points, color, shade, alpha)

    def disc(self, x_m: float, y_m: float, radius_m: float, color: Bgr, alpha: float = 1.0) -> None:
        """Fill a disc."""
        angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
        self.fill(
            [(x_m + radius_m * np.cos(a), y_m + radius_m * np.sin(a)) for a in angles], color, (), alpha
        )

    def finished(self) -> FloatImage:
        """The picture at its final resolution, colours multiplied by alpha."""
        # Painting over what is clear has left every colour multiplied by what it covers.
        return np.asarray(cv2.resize(self.image, self._finished, interpolation=cv2.INTER_AREA), np.float32)


def mixed(color: Bgr, other: Bgr, part: float) -> Bgr:
    """A colour with a part of another one."""
    b, g, r = (one + (two - one) * part for one, two in zip(color, other, strict=True))
    return b, g, r


def _cut_corners(points: NDArray[np.float64], length_m: float) -> NDArray[np.float64]:
    """Replace each corner by two points at most `length_m` from it, never beyond a third of its edges."""
    towards = np.roll(points, -1, axis=0) - points
    lengths = np.maximum(np.hypot(*towards.T), 1e-9)
    part = np.minimum(length_m / lengths, 1 / 3)[:, None]
    starts, ends = points + part * towards, points + (1 - part) * towards
    return np.stack((starts, ends), axis=1).reshape(-1, 2)
