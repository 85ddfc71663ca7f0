"""Looking at something else in the scene than the picture, which is kept small meanwhile."""

import json
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

SMALL_WIDTH_PX, SMALL_QUALITY = 480, 75
"""Of a picture that is looked at beside something else."""


@dataclass(frozen=True, slots=True)
class Orbit:
    """How the camera looks at another place of the scene than the picture; all in the scene's units and axes.

    Attributes:
        position: of the camera at first.
        look_at: what it turns about.
        distances: the nearest and the farthest that it goes.
        depths: from where to where something is drawn.
        lowest_rad: as far as it sinks, from straight above.
    """

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    distances: tuple[float, float]
    depths: tuple[float, float]
    lowest_rad: float

    def script_arguments(self) -> str:
        """Those of `leavePicture` in picture_away.js."""
        arguments = (self.position, self.look_at, self.distances, self.depths, self.lowest_rad)
        return ", ".join(map(json.dumps, arguments))


def small_jpeg(image_bgr: NDArray[np.uint8]) -> bytes:
    """A picture reduced to what is seen beside something else."""
    scale = min(SMALL_WIDTH_PX / image_bgr.shape[1], 1.0)
    small = cv2.resize(image_bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, encoded = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, SMALL_QUALITY])
    return encoded.tobytes()
