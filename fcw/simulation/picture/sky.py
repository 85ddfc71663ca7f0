"""What is too far away to move: sky, clouds, hills and woods on the horizon."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.kernels.jit import kernel
from fcw.simulation.picture.canvas import FloatImage, mixed
from fcw.simulation.picture.light import Daylight

PANORAMA_WIDTH = 4096
"""It repeats after this many pixels, 235 degrees at a focal length of 1000 px."""
ABOVE_PX, BELOW_PX = 760, 64
RANGES = ((9000, 54, 160), (4000, 32, 90), (1500, 20, 28), (600, 25, 12))
"""Hills and woods, from far to near: distance in metres, height and width of their shapes in pixels."""
HIGHEST = 2.2
"""Of a shape, in heights."""
FILLED_BELOW_PX = 220
"""Rows of the panorama above and below the horizon."""


class Sky:
    """Paints everything beyond the ground.

    Args:
        camera: as calibrated.
        generator: of clouds and hills.
        light: of the drive.
    """

    def __init__(self, camera: GroundPlaneCamera, generator: np.random.Generator, light: Daylight) -> None:
        self._focal_px, self._column_px = camera.focal_y_px, camera.principal_column_px
        self._panorama = _panorama(generator, light)

    def paint(self, image: FloatImage, horizon_row_px: float, heading_rad: float) -> None:
        """Paint everything above the horizon and a little below it.

        Args:
            image: (rows, columns, 3) float32 BGR, painted on.
            horizon_row_px: where the level horizon is.
            heading_rad: of the camera in the world, positive to the left.
        """
        first_column = -self._column_px - self._focal_px * heading_rad
        # The ground covers what is below; beyond its last section there are a few rows at most.
        rows = int(np.clip(horizon_row_px + FILLED_BELOW_PX, 1, image.shape[0]))
        _shifted(image[:rows], self._panorama, ABOVE_PX - horizon_row_px, first_column % PANORAMA_WIDTH)


@kernel()
def _shifted(image: NDArray, panorama: NDArray, first_row: float, first_column: float) -> None:
    rows, columns = panorama.shape[0], panorama.shape[1]
    left = int(first_column)
    fx = np.float32(first_column - left)
    for y in range(image.shape[0]):
        row = min(max(y + first_row, 0.0), rows - 1.001)
        i = int(row)
        fy = np.float32(row - i)
        a, b, c, d = (1 - fy) * (1 - fx), (1 - fy) * fx, fy * (1 - fx), fy * fx
        for x in range(image.shape[1]):
            j = (left + x) % columns
            j2 = j + 1 if j + 1 < columns else 0
            for k in range(3):
                image[y, x, k] = (
                    a * panorama[i, j, k]
                    + b * panorama[i, j2, k]
                    + c * panorama[i + 1, j, k]
                    + d * panorama[i + 1, j2, k]
                )


def _panorama(generator: np.random.Generator, light: Daylight) -> FloatImage:
    rows = ABOVE_PX + BELOW_PX
    above = np.clip((ABOVE_PX - np.arange(rows, dtype=np.float32)) / ABOVE_PX, 0, 1)[:, None, None]
    haze, zenith = np.array(light.haze, np.float32), np.array(light.zenith, np.float32)
    image = haze + (zenith - haze) * np.minimum(above * 1.9, 1.0) ** 0.7
    image = np.repeat(image, PANORAMA_WIDTH, axis=1)
    clouds = sum(
        weight * _cyclic_noise(generator, sigma) for sigma, weight in ((90, 0.6), (30, 0.35), (10, 0.2))
    )
    # Clouds lie in flat layers: the nearer the horizon, the more of them in a degree.
    cover = np.clip(clouds - 0.9 + 1.7 * light.cloudiness, 0, 1)[..., None] * np.minimum(above * 6, 1)
    white = np.array(mixed((246, 244, 240), (204, 200, 196), light.cloudiness), np.float32)
    body = white * (1 - 0.13 * np.clip(clouds, 0, 1.5))[..., None]
    image += (body - image) * cover * 0.85
    for distance_m, height_px, sigma_px in RANGES:
        ridge = _cyclic_noise(generator, sigma_px, row=True)
        rough = 0.2 * _cyclic_noise(generator, 2.0, row=True) if distance_m < 3000 else 0.0
        tops = ABOVE_PX - height_px * np.clip(0.6 + 0.45 * ridge + rough, 0.05, HIGHEST)
        first = ABOVE_PX - math.ceil(HIGHEST * height_px)
        inside = np.clip(np.arange(first, rows)[:, None] - tops[None, :], 0, 1)[..., None]
        clarity = float(np.exp(-distance_m / (5 * light.visibility_m)))
        tint = np.array(mixed(light.foliage, light.dry_grass, 0.25 if distance_m < 3000 else 0.5), np.float32)
        speckle = 1 + 0.15 * _cyclic_noise(generator, 1.5)[first:, :, None] * min(1.0, 2000 / distance_m)
        color = tint * speckle * clarity + haze * np.array((1.0, 0.93, 0.86), np.float32) * (1 - clarity)
        image[first:] += (color - image[first:]) * inside
    return np.ascontiguousarray(image, np.float32)


def _cyclic_noise(generator: np.random.Generator, sigma_px: float, row: bool = False) -> FloatImage:
    """Noise of unit variance that repeats across: (rows, columns), flatter than wide, or one row."""
    step = max(1, int(sigma_px / 3))
    columns = PANORAMA_WIDTH // step
    rows = 1 if row else (ABOVE_PX + BELOW_PX) // max(1, step // 3) + 1
    field = generator.standard_normal((rows, columns)).astype(np.float32)
    margin = min(columns, int(sigma_px / step * 4) + 2)
    padded = cv2.copyMakeBorder(field, 0, 0, margin, margin, cv2.BORDER_WRAP)
    sigma = sigma_px / step
    blurred = cv2.GaussianBlur(padded, (0, 0), sigmaX=sigma, sigmaY=max(sigma * (0.01 if row else 0.9), 0.01))
    inner = blurred[:, margin : margin + columns]
    full = cv2.resize(
        inner, (PANORAMA_WIDTH, 1 if row else ABOVE_PX + BELOW_PX), interpolation=cv2.INTER_LINEAR
    )
    full = full / full.std()
    return np.asarray(full[0] if row else full, np.float32)
