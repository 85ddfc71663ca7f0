"""Chunks of an MCAP file: how large they unpack to is looked at before anything is unpacked.

MCAP specification 0x00: a record is an opcode, the length of its content, and the content; a chunk's begins
with start and end time, the size of what it unpacks to, a checksum, and the name of its compression.
"""

import struct
from pathlib import Path
from typing import BinaryIO

import zstandard

from fcw.errors import UserError

MOST_UNPACKED_BYTES = 256 << 20
"""Of one chunk; writers make them of 1 to 16 MB, or of one raw picture."""
_CHUNK = 0x06
_MAGIC_BYTES = 8
_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")  # times, size, checksum, length of the compression's name
_FRAME_BYTES = 18  # RFC 8878: the longest header of a zstd frame


def check_chunks(path: Path, file: BinaryIO) -> None:
    """See that no chunk unpacks to more than it may; where the file is torn or no MCAP nothing is said.

    Args:
        path: for the message.
        file: opened; it stands at its beginning again afterwards.

    Raises:
        UserError: a chunk does.
    """
    at = _MAGIC_BYTES
    end = file.seek(0, 2)
    while at + _HEAD.size <= end:
        file.seek(at)
        opcode, length = _HEAD.unpack(file.read(_HEAD.size))
        if opcode == _CHUNK and _unpacked_bytes(file.read(128)) > MOST_UNPACKED_BYTES:
            raise UserError(
                f"{path}: the chunk at byte {at} unpacks to more than {MOST_UNPACKED_BYTES >> 20} MB; "
                "expected a drive's messages in chunks of a few"
            )
        at += _HEAD.size + length
    file.seek(0)


def _unpacked_bytes(head: bytes) -> int:
    """The larger of what a chunk states, and of what its zstd frame states."""
    if len(head) < _CHUNK_HEAD.size:
        return 0
    _, _, stated, _, name_length = _CHUNK_HEAD.unpack_from(head)
    name = head[_CHUNK_HEAD.size : _CHUNK_HEAD.size + name_length]
    frame = head[_CHUNK_HEAD.size + name_length + 8 :][:_FRAME_BYTES]
    if name != b"zstd":
        return stated
    try:
        return max(stated, zstandard.frame_content_size(frame))
    except zstandard.ZstdError:
        return stated
