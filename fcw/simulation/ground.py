"""The ground under a moving camera: one texture from above, sampled through the ground-plane camera."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.simulation.textures import FloatImage, ground_texture
from fcw.sources.frame import ImageSize

PERIOD_M = 96.0
"""The ground repeats after this: a multiple of the lane markings' period."""
HALF_WIDTH_M = 40.0
CELLS = 2048
"""Cells along and across: 4.7 and 3.9 cm, about a pixel 7 m away. A power of two, to be halved."""
HAZE_M = 420.0
"""Contrast falls to 1/e over this distance."""
HAZE = np.array((214.0, 203.0, 194.0), np.float32)
"""Colour of the air, BGR."""


@dataclass(frozen=True, slots=True, eq=False)
class _GroundBand:
    """Rows of the picture that look at the ground in one resolution.

    Attributes:
        top: the first row of the picture; the band ends where the next one begins.
        texture: (rows along, columns across, 3), the last row the farthest.
        along_m: (n,) distance of each row of the picture.
        column_map: (n, width) column of the texture for each pixel.
        clarity: (n, 1, 1) what the haze leaves.
    """

    top: int
    texture: NDArray[np.uint8]
    along_m: NDArray[np.float64]
    column_map: NDArray[np.float32]
    clarity: FloatImage


class Ground:
    """Grass, asphalt and markings (see `ground_texture`), straight ahead of the camera.

    Args:
        camera: the true camera.
        image_size: of the pictures.
        generator: of the surfaces.
    """

    def __init__(
        self, camera: GroundPlaneCamera, image_size: ImageSize, generator: np.random.Generator
    ) -> None:
        self._camera, self._size = camera, image_size
        self._bands = self._split(ground_texture(CELLS, PERIOD_M, HALF_WIDTH_M, generator))

    def paint(self, image: FloatImage, travelled_m: float) -> None:
        """Paint every row below the horizon, after a distance travelled."""
        for band in self._bands:
            along = (band.along_m + travelled_m) / PERIOD_M % 1.0 * band.texture.shape[0] - 0.5
            row_map = np.repeat(along.astype(np.float32)[:, None], band.column_map.shape[1], axis=1)
            ground = cv2.remap(
                band.texture, band.column_map, row_map, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
            )
            image[band.top : band.top + len(along)] = ground * band.clarity + HAZE * (1 - band.clarity)

    def _split(self, texture: NDArray[np.uint8]) -> list[_GroundBand]:
        """Split the rows below the horizon by the size of their pixels on the ground."""
        camera, width = self._camera, self._size.width
        rows = np.arange(math.floor(camera.horizon_row_px) + 1, self._size.height, dtype=np.float64)
        along_m = camera.distance_at(rows)
        across_px_m = camera.height_m / (rows - camera.horizon_row_px)
        along_px_m = np.abs(np.gradient(along_m))
        cell_m = np.array((PERIOD_M, 2 * HALF_WIDTH_M)) / CELLS
        limit = int(math.log2(CELLS)) - 1
        levels = [
            tuple(
                int(np.clip(math.ceil(math.log2(px / cell)), 0, limit))
                for px, cell in zip(pixel, cell_m, strict=True)
            )
            for pixel in zip(along_px_m, across_px_m, strict=True)
        ]
        columns = np.arange(width, dtype=np.float64)
        bands: list[_GroundBand] = []
        first = 0
        for last in range(1, len(rows) + 1):
            if last < len(rows) and levels[last] == levels[first]:
                continue
            size = (CELLS >> levels[first][1], CELLS >> levels[first][0])
            lateral_m = camera.lateral_at(columns[None, :], rows[first:last, None])
            column_map = (0.5 - lateral_m / (2 * HALF_WIDTH_M)) * size[0] - 0.5
            bands.append(
                _GroundBand(
                    int(rows[first]),
                    np.asarray(cv2.resize(texture, size, interpolation=cv2.INTER_AREA), np.uint8),
                    along_m[first:last],
                    np.clip(column_map, 0, size[0] - 1).astype(np.float32),
                    np.exp(-along_m[first:last] / HAZE_M).astype(np.float32)[:, None, None],
                )
            )
            first = last
        return bands
