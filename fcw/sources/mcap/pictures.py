"""Decodes pictures in the messages of Foxglove and ROS 2."""

from collections.abc import Callable
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.bounded.pictures import decode_picture, within_bounds

Image = NDArray[np.uint8]
VIDEO_CODECS = {"h264": "h264", "h265": "hevc", "vp9": "vp9", "av1": "av1"}
"""FFmpeg's decoders by the formats of foxglove.CompressedVideo."""
_RAW_FORMS: dict[str, tuple[int, int | None]] = {
    "bgr8": (3, None),
    "8uc3": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR),
    "mono8": (1, cv2.COLOR_GRAY2BGR),
    "8uc1": (1, cv2.COLOR_GRAY2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "uyvy": (2, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422": (2, cv2.COLOR_YUV2BGR_UYVY),
    "yuyv": (2, cv2.COLOR_YUV2BGR_YUYV),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2BGR_YUYV),
    "bayer_rggb8": (1, cv2.COLOR_BayerRGGB2BGR),
    "bayer_grbg8": (1, cv2.COLOR_BayerGRBG2BGR),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGBRG2BGR),
    "bayer_bggr8": (1, cv2.COLOR_BayerBGGR2BGR),
}
"""Bytes per pixel and OpenCV's conversion to BGR for each encoding of foxglove.RawImage and ROS 2."""


class CompressedMessage(Protocol):
    """What Foxglove's and ROS 2's encoded pictures have in common."""

    data: bytes
    format: str


class RawMessage(Protocol):
    """What Foxglove's and ROS 2's raw pictures have in common."""

    width: int
    height: int
    encoding: str
    step: int
    data: bytes


class UnknownPictureError(Exception):
    """A picture has a form that cannot be read; the text names it and the known ones."""


def compressed_image(message: CompressedMessage) -> Image | None:
    """foxglove.CompressedImage or sensor_msgs/CompressedImage as BGR; None if it is damaged."""
    if "compressedDepth" in message.format:
        raise UnknownPictureError(f"pictures of the form {message.format!r}; expected JPEG, PNG or WebP")
    return decode_picture(message.data)


def raw_image(message: RawMessage) -> Image | None:
    """foxglove.RawImage or sensor_msgs/Image as BGR.

    None if it has fewer bytes than its size needs, or is larger than that of any camera.
    """
    form = _RAW_FORMS.get(message.encoding.lower())
    if form is None:
        raise UnknownPictureError(
            f"pictures with the encoding {message.encoding!r}; expected one of "
            f"{', '.join(_RAW_FORMS)}, or compressed pictures"
        )
    channels, conversion = form
    height, width, step = message.height, message.width, message.step or message.width * channels
    data = np.frombuffer(message.data, np.uint8)
    if not within_bounds(width, height) or step < width * channels or data.size < height * step:
        return None
    pixels = data[: height * step].reshape(height, step)[:, : width * channels]
    pixels = np.ascontiguousarray(pixels.reshape(height, width, channels))
    try:
        return pixels if conversion is None else np.asarray(cv2.cvtColor(pixels, conversion), np.uint8)
    except cv2.error:  # two pixels share a colour in some forms, and the width is odd
        return None


PICTURE_READERS: dict[str, Callable[[Any], Image | None]] = {
    "foxglove.CompressedImage": compressed_image,
    "foxglove_msgs/CompressedImage": compressed_image,
    "sensor_msgs/CompressedImage": compressed_image,
    "foxglove.RawImage": raw_image,
    "foxglove_msgs/RawImage": raw_image,
    "sensor_msgs/Image": raw_image,
}
"""By the names of their schemas."""
VIDEO_TYPES = ("foxglove.CompressedVideo", "foxglove_msgs/CompressedVideo")
PICTURE_TYPES = (*PICTURE_READERS, *VIDEO_TYPES)
