"""From light to the picture a small camera gives: blur, fall-off towards the corners, noise."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.frame import ImageSize
from fcw.kernels.jit import kernel
from fcw.simulation.picture.canvas import FloatImage

BLUR_SIGMA_PX = 0.7
"""Of the lens and the demosaicing: an edge takes about two pixels."""
VIGNETTING = 0.16
"""Light lost in the corners."""
NOISE_SIGMA = 1.2
"""Grey levels, before compression smooths them."""
NOISE_COUNT = 1 << 20
CONTRAST = 1.06


class Lens:
    """Turns painted light into pixels.

    Args:
        image_size: of the pictures.
        generator: of the noise.
    """

    def __init__(self, image_size: ImageSize, generator: np.random.Generator) -> None:
        rows, columns = image_size.height, image_size.width
        y = (np.arange(rows) - (rows - 1) / 2) / (rows / 2)
        x = (np.arange(columns) - (columns - 1) / 2) / (columns / 2)
        radius2 = (y[:, None] ** 2 * (rows / columns) ** 2 + x[None, :] ** 2) / (1 + (rows / columns) ** 2)
        self._gain = (1 - VIGNETTING * radius2**1.2).astype(np.float32)
        self._noise = (NOISE_SIGMA * generator.standard_normal(NOISE_COUNT)).astype(np.float32)

    def expose(self, light: FloatImage, frame_seed: int) -> NDArray[np.uint8]:
        """The picture.

        Args:
            light: (rows, columns, 3) BGR; overwritten.
            frame_seed: of this picture's noise.

        Returns:
            (rows, columns, 3) uint8 BGR.
        """
        blurred = cv2.GaussianBlur(light, (3, 3), BLUR_SIGMA_PX)
        picture = np.empty(light.shape, np.uint8)
        starts = np.random.default_rng(frame_seed).integers(0, NOISE_COUNT, light.shape[0])
        _develop(blurred, self._gain, self._noise, starts, picture)
        return picture


@kernel()
def _develop(light: NDArray, gain: NDArray, noise: NDArray, starts: NDArray, picture: NDArray) -> None:
    rows, columns = light.shape[0], light.shape[1]
    mask = noise.shape[0] - 1
    for y in range(rows):
        at = starts[y]
        for x in range(columns):
            for k in range(3):
                value = light[y, x, k] * gain[y, x]
                # A gentle S: shadows deepen, lights roll off instead of clipping.
                value = np.float32(112.0) + (value - np.float32(112.0)) * np.float32(CONTRAST)
                if value > 205:
                    value = np.float32(205.0) + (value - 205) * np.float32(50.0) / (value - 205 + 50)
                value += noise[at & mask] + np.float32(0.5)
                at += 1
                picture[y, x, k] = np.uint8(min(max(value, 0.0), 255.0))
