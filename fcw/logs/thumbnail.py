"""A picture of a drive made small, for lists."""

import cv2
import numpy as np
from numpy.typing import NDArray

THUMBNAIL_PX, THUMBNAIL_QUALITY = (294, 165), 72


def thumbnail_jpeg(image: NDArray[np.uint8]) -> bytes:
    """A picture that covers the size of a thumbnail, as JPEG.

    Args:
        image: (height, width, 3) BGR.
    """
    width_px, height_px = THUMBNAIL_PX
    scale = max(width_px / image.shape[1], height_px / image.shape[0])
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, THUMBNAIL_QUALITY])
    return data.tobytes()
