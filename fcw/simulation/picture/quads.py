"""Textures in space: flat quadrilaterals in perspective, each sampled at the size in which it is seen."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.kernels.jit import kernel
from fcw.simulation.picture.canvas import FloatImage

LEVELS_PER_OCTAVE = 2
"""Between 1 and 1.41 texels a pixel: sharp, and no level shows where it gives way to the next."""
SMALLEST_TEXELS = 2


class Texture:
    """A picture with alpha, kept in every size it was asked for; width and height shrink independently.

    Args:
        image: (rows, columns, 4) BGRA, colours 0 to 255 multiplied by alpha 0 to 1.
    """

    def __init__(self, image: FloatImage) -> None:
        self._image = image
        self._sizes: dict[tuple[int, int], FloatImage] = {}

    def at(self, columns_px: float, rows_px: float) -> FloatImage:
        """The texture with about as many texels as the pixels it fills, or all it has."""
        size = (_texels(self._image.shape[1], columns_px), _texels(self._image.shape[0], rows_px))
        if size not in self._sizes:
            resized = cv2.resize(self._image, size, interpolation=cv2.INTER_AREA)
            self._sizes[size] = np.ascontiguousarray(resized, np.float32)
        return self._sizes[size]


def _texels(full: int, wanted_px: float) -> int:
    octaves = math.log2(full / max(wanted_px, 1.0))
    halvings = max(math.floor(octaves * LEVELS_PER_OCTAVE), 0) / LEVELS_PER_OCTAVE
    return max(round(full / 2**halvings), min(SMALLEST_TEXELS, full))


def paint_quad(
    image: FloatImage,
    texture: Texture,
    corners_px: NDArray[np.float64],
    part: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    light: float = 1.0,
    clarity: float = 1.0,
    haze: tuple[float, float, float] = (0.0, 0.0, 0.0),
    lowest_row_px: float = math.inf,
) -> None:
    """Paint a part of a texture over a picture.

    Args:
        image: (rows, columns, 3) float32 BGR, painted on.
        texture: what is painted.
        corners_px: (4, 2) columns and rows: top left of the part, top right, bottom right, bottom left.
        part: left, top, right and bottom of what is painted, as fractions of the texture.
        light: factor of brightness.
        clarity: what the air leaves of the colour.
        haze: colour of the air, BGR.
        lowest_row_px: nothing is painted below this row.
    """
    top_left, top_right, bottom_right, bottom_left = corners_px
    low, high = np.floor(corners_px.min(axis=0)) - 1, np.ceil(corners_px.max(axis=0)) + 2
    left, top = max(int(low[0]), 0), max(int(low[1]), 0)
    right = min(int(high[0]), image.shape[1])
    bottom = min(int(min(high[1], lowest_row_px + 1)), image.shape[0])
    if right <= left or bottom <= top:
        return
    across = max(math.dist(top_left, top_right), math.dist(bottom_left, bottom_right))
    along = max(math.dist(top_left, bottom_left), math.dist(top_right, bottom_right))
    if min(across, along) < 1e-3:
        return
    texels = texture.at(across / (part[2] - part[0]), along / (part[3] - part[1]))
    x0, y0, x1, y1 = part
    source = np.array(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), np.float32)
    to_texture = _homography(corners_px - (left, top), source)
    if to_texture is None:
        return
    rows, columns = texels.shape[:2]
    inner = (x0 * columns, y0 * rows, x1 * columns, y1 * rows)
    _paint(image[top:bottom, left:right], texels, to_texture, inner, light * clarity, haze, 1.0 - clarity)


def _homography(source: NDArray[np.float64], target: NDArray[np.float32]) -> NDArray[np.float64] | None:
    """The map of four points onto four others; None where they are in a line."""
    matrix = np.zeros((8, 8))
    x, y = source.T
    u, v = target.T.astype(np.float64)
    matrix[:4, 0], matrix[:4, 1], matrix[:4, 2] = x, y, 1
    matrix[4:, 3], matrix[4:, 4], matrix[4:, 5] = x, y, 1
    matrix[:4, 6], matrix[:4, 7] = -x * u, -y * u
    matrix[4:, 6], matrix[4:, 7] = -x * v, -y * v
    try:
        solution = np.linalg.solve(matrix, np.concatenate((u, v)))
    except np.linalg.LinAlgError:
        return None
    return np.append(solution, 1.0).reshape(3, 3)


@kernel()
def _paint(
    image: NDArray,
    texels: NDArray,
    to_texture: NDArray,
    inner: tuple[float, float, float, float],
    gain: float,
    haze: tuple[float, float, float],
    haze_part: float,
) -> None:
    rows, columns = texels.shape[0], texels.shape[1]
    h = to_texture
    haze_b, haze_g, haze_r = haze[0] * haze_part, haze[1] * haze_part, haze[2] * haze_part
    gain_f = np.float32(gain)
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
            if w <= 0:  # behind the vanishing line of the quad's plane
                continue
            scale = 1.0 / w
            across = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) * scale * columns
            along = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) * scale * rows
            # Half a texel around the part: its edge is where the cover is a half.
            edge = min(min(across - inner[0], inner[2] - across), min(along - inner[1], inner[3] - along))
            if edge <= -0.5:
                continue
            cover = np.float32(min(edge + 0.5, 1.0))
            tx = min(max(across - 0.5, 0.0), columns - 1.0)
            ty = min(max(along - 0.5, 0.0), rows - 1.0)
            i, j = int(ty), int(tx)
            i2, j2 = min(i + 1, rows - 1), min(j + 1, columns - 1)
            fy, fx = np.float32(ty - i), np.float32(tx - j)
            w00, w01 = (1 - fy) * (1 - fx), (1 - fy) * fx
            w10, w11 = fy * (1 - fx), fy * fx
            alpha = cover * (
                w00 * texels[i, j, 3]
                + w01 * texels[i, j2, 3]
                + w10 * texels[i2, j, 3]
                + w11 * texels[i2, j2, 3]
            )
            if alpha <= 0.002:
                continue
            keep = 1 - alpha
            for c in range(3):
                color = (
                    w00 * texels[i, j, c]
                    + w01 * texels[i, j2, c]
                    + w10 * texels[i2, j, c]
                    + w11 * texels[i2, j2, c]
                )
                air = haze_b if c == 0 else (haze_g if c == 1 else haze_r)
                image[y, x, c] = image[y, x, c] * keep + color * cover * gain_f + np.float32(air) * alpha
