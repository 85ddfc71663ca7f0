"""Pictures of others: how large they say they are is looked at before they are decoded.

Of what starts like none of these formats nothing is known, and OpenCV is not asked to guess.
"""

import struct
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.bounded.files import MalformedError, read_bytes
from fcw.errors import UserError

MOST_FILE_BYTES = 128 << 20
MOST_PIXELS = 48 << 20
"""Of one that stands for itself, decoded 150 MB; cameras of phones have 50 to 200 million only when asked to.
"""
MOST_DRIVE_PIXELS = 16 << 20
"""Of each of a drive's, of which several are under way at once; action cameras have 5312x2988."""
LONGEST_SIDE_PX = 16384
SHORTEST_SIDE_PX = 8
"""Of a drive's pictures: smaller ones have no room for a corner to follow."""
_PNG = b"\x89PNG\r\n\x1a\n"
DECODER_OPTIONS = {"max_pixels": str(MOST_DRIVE_PIXELS)}
"""With these FFmpeg's decoders refuse a larger picture before they make room for it."""


def read_picture(path: Path) -> NDArray[np.uint8] | None:
    """A picture file as (height, width, 3), BGR; None where it cannot be read, see `decode_picture`."""
    try:
        data = read_bytes(path, MOST_FILE_BYTES)
    except (OSError, MalformedError):
        return None
    return decode_picture(data)


def decode_picture(data: bytes) -> NDArray[np.uint8] | None:
    """An encoded picture as (height, width, 3) uint8, BGR, turned as its Exif says.

    None where it is damaged, of no format that is known here, or larger than any camera's.
    """
    size = picture_size(data)
    if size is None or not within_bounds(*size) or (data.startswith(_PNG) and not _png_chunks_end(data)):
        return None
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    return None if image is None else np.asarray(image, np.uint8)


def within_bounds(width: int, height: int, most_pixels: int = MOST_PIXELS) -> bool:
    """Whether a picture has any pixels, and no more of them than it may."""
    return min(width, height) > 0 and max(width, height) <= LONGEST_SIDE_PX and width * height <= most_pixels


def check_drive_size(drive: object, width: int, height: int) -> None:
    """See that a drive's pictures are not too large to have several of them under way, nor next to nothing.

    Args:
        drive: for the message.
        width: of its pictures.
        height: of its pictures.

    Raises:
        UserError: they are.
    """
    if min(width, height) < SHORTEST_SIDE_PX:
        raise UserError(
            f"{drive}: pictures of {width}x{height}; expected sides of at least {SHORTEST_SIDE_PX} pixels: "
            "in these nothing can be seen"
        )
    if not within_bounds(width, height, MOST_DRIVE_PIXELS):
        raise UserError(
            f"{drive}: pictures of {width}x{height}; expected at most {MOST_DRIVE_PIXELS:,} pixels "
            f"(5312x2988 has 15,872,256), and sides of at most {LONGEST_SIDE_PX}; make them smaller first, "
            "a video for instance with `ffmpeg -i IN -vf scale=1920:-2 OUT.mp4`"
        )


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Width and height that a picture's header states; None where there is none of a format known here.

    PNG (ISO 15948), JPEG (ITU-T T.81, B.2.2), BMP, WebP (RFC 9649).
    """
    try:
        if data.startswith(_PNG) and data[12:16] == b"IHDR":
            return struct.unpack_from(">II", data, 16)
        if data.startswith(b"\xff\xd8"):
            return _jpeg_size(data)
        if data.startswith(b"BM"):
            width, height = struct.unpack_from("<ii", data, 18)
            return width, abs(height)
        if data.startswith(b"RIFF") and data[8:12] == b"WEBP":
            return _webp_size(data)
    except (struct.error, IndexError):
        return None
    return None


def _png_chunks_end(data: bytes) -> bool:
    """Whether all chunks end within the data: OpenCV makes room for whatever a chunk says it holds."""
    at, kind = len(_PNG), b""
    while at + 8 <= len(data) and kind != b"IEND":
        kind = data[at + 4 : at + 8]
        at += 12 + int.from_bytes(data[at : at + 4], "big")  # length, kind and check sum
    return at <= len(data)


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            at += 1
            continue
        marker = data[at + 1]
        if marker in (0xFF, 0x00, 0x01) or 0xD0 <= marker <= 0xD8:
            at += 1 if marker == 0xFF else 2
        elif 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        elif marker == 0xDA:
            return None
        else:
            at += 2 + struct.unpack_from(">H", data, at + 2)[0]
    return None


def _webp_size(data: bytes) -> tuple[int, int] | None:
    kind = data[12:16]
    if kind == b"VP8X":
        return (
            1 + int.from_bytes(data[24:27], "little"),
            1 + int.from_bytes(data[27:30], "little"),
        )
    if kind == b"VP8L":
        bits = int.from_bytes(data[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if kind == b"VP8 ":
        width, height = struct.unpack_from("<HH", data, 26)
        return width & 0x3FFF, height & 0x3FFF
    return None
