"""Encoding pictures for the logs, where a source's own video cannot be relayed."""

from fractions import Fraction

import cv2
import numpy as np
from av.codec.context import CodecContext
from av.error import FFmpegError
from av.video.codeccontext import VideoCodecContext
from av.video.frame import PictureType, VideoFrame
from av.video.reformatter import ColorRange, Colorspace

from fcw.errors import UserError
from fcw.frame import FALLBACK_RATE_HZ, Frame, ImageSize, VideoPacket

KEYFRAME_INTERVAL_NS = 1_000_000_000
"""Viewers that jump decode a second at most."""
_PRESET = "superfast"
"""At 1280x720 veryfast takes half again the time, ultrafast half again the bytes."""
_QUALITY = "23"
"""x264's own default constant rate factor."""
_SRGB_PRIMARIES = 1
"""ITU-T H.273: BT.709, whose primaries are sRGB's, and its transfer."""


class VideoEncoder:
    """H.264 in Annex B form: one packet for each frame at once, no B frames, a keyframe each second.

    H.264 halves the colour's resolution and so needs even sizes: an odd picture gets its last column or row
    a second time, which leaves all pixel coordinates as they are.
    """

    def __init__(self, image_size: ImageSize, frame_rate_hz: float) -> None:
        """Prepare for pictures of one size; the rate only steers the encoder, not the times.

        Raises:
            UserError: the encoder cannot be started for pictures of that size, or with the memory there is.
        """
        self._pad_rows, self._pad_columns = image_size.height % 2, image_size.width % 2
        codec = CodecContext.create("libx264", "w")
        assert isinstance(codec, VideoCodecContext)
        codec.width = image_size.width + self._pad_columns
        codec.height = image_size.height + self._pad_rows
        codec.pix_fmt = "yuv420p"
        codec.colorspace = Colorspace.ITU601
        codec.color_range = ColorRange.MPEG
        codec.color_primaries = codec.color_trc = _SRGB_PRIMARIES  # unsaid, a browser guesses others
        rate = Fraction(frame_rate_hz).limit_denominator(1001) or Fraction(FALLBACK_RATE_HZ)
        codec.framerate, codec.time_base = rate, 1 / rate
        codec.max_b_frames = 0
        # Keyframes are asked for by time, so that varying rates get one each second too.
        codec.gop_size = 1_000_000
        codec.options = {"preset": _PRESET, "tune": "zerolatency", "crf": _QUALITY, "forced-idr": "1"}
        try:
            codec.open()
        except (FFmpegError, MemoryError) as error:
            raise UserError(
                f"pictures of {image_size}: the encoder of the log's video cannot be started "
                f"({getattr(error, 'strerror', None) or error}); make the pictures smaller, or allow more "
                "memory (ulimit -v) and threads (ulimit -u)"
            ) from error
        self._codec = codec
        self._encoded = 0
        self._keyframe_ns: int | None = None

    def encode(self, frame: Frame) -> tuple[VideoPacket, ...]:
        """The one packet of a frame; call it with the frames in order."""
        image = frame.image
        if self._pad_rows or self._pad_columns:
            image = cv2.copyMakeBorder(image, 0, self._pad_rows, 0, self._pad_columns, cv2.BORDER_REPLICATE)
        planes = cv2.cvtColor(image, cv2.COLOR_BGR2YUV_I420)  # BT.601 in video range, as declared above
        picture = VideoFrame.from_ndarray(np.asarray(planes, np.uint8), format="yuv420p")
        picture.pts = self._encoded
        keyframe = self._keyframe_ns is None or frame.time_ns - self._keyframe_ns >= KEYFRAME_INTERVAL_NS
        picture.pict_type = PictureType.I if keyframe else PictureType.NONE
        packets = self._codec.encode(picture)
        if len(packets) != 1:
            raise RuntimeError(f"the encoder gave {len(packets)} packets for frame {frame.index}, expected 1")
        self._encoded += 1
        if keyframe:
            self._keyframe_ns = frame.time_ns
        return (VideoPacket(bytes(packets[0]), frame.time_ns, packets[0].is_keyframe, shown=True),)

    def close(self) -> None:
        """Let the encoder go; packets never wait in it."""
        self._codec.encode(None)
