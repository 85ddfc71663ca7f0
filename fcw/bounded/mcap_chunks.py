"""Chunks of an MCAP file: how large they unpack to is looked at before anything is unpacked.

MCAP specification 0x00: a record is an opcode, the length of its content, and the content; a chunk's begins
with start and end time, the size of what it unpacks to, a checksum, and the name of its compression.
"""

import struct
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import BinaryIO

import zstandard

from fcw.errors import UserError

MOST_UNPACKED_BYTES = 256 << 20
"""Of one chunk; writers make them of 1 to 16 MB, or of one raw picture."""
MOST_TIMES_PACKED = 100
"""Of a whole file; raw pictures of the road pack to a half or a tenth, encoded ones hardly."""
ALWAYS_UNPACKED_BYTES = 1 << 30
"""What a small file may unpack to in any case, of black pictures for instance."""
_FOOTER, _CHUNK, _ATTACHMENT, _METADATA = 0x02, 0x06, 0x09, 0x0C
_INDEXES = {0x08: (_CHUNK, 16), 0x0A: (_ATTACHMENT, 0), 0x0D: (_METADATA, 0)}
"""Opcodes of index records: what they lead to, and where in them its offset stands."""
_MAGIC = b"\x89MCAP0\r\n"
_FOOTER_BYTES = 9 + 20 + len(_MAGIC)
"""Its record, and the magic at the end of the file."""
_HEAD = struct.Struct("<BQ")
CHUNK_HEAD = struct.Struct("<QQQII")
"""Of a chunk's record: both times, size, checksum, and length of the compression's name."""
_FRAME_BYTES = 18  # RFC 8878: the longest header of a zstd frame
_LZ4_MAGIC = 0x184D2204
_LZ4_BLOCK = struct.Struct("<I")
_LZ4_STORED = 1 << 31
_LZ4_MOST_TIMES = 255
"""A byte of an LZ4 block stands for at most so many."""


def check_chunks(path: Path, file: BinaryIO) -> None:
    """See that neither a chunk nor all together unpack to more than they may.

    An index may lead readers to what does not stand in the row of the records, but inside another one. Where
    the file is torn or no MCAP nothing is said.

    Args:
        path: for the message.
        file: opened; it stands at its beginning again afterwards.

    Raises:
        UserError: a chunk does, or all do.
    """
    end = file.seek(0, 2)
    seen: set[int] = set()
    led_to: set[tuple[int, int]] = set()
    unpacked = 0
    for at, opcode, length in chain(_records(file, len(_MAGIC)), _records(file, _summary_start(file))):
        if opcode == _CHUNK and at not in seen:
            seen.add(at)
            unpacked += _checked(path, file, at, length)
        elif opcode in _INDEXES and at + _HEAD.size + length <= end:
            wanted, offset_at = _INDEXES[opcode]
            file.seek(at + _HEAD.size + offset_at)
            led_to.add((wanted, int.from_bytes(file.read(8), "little")))
    for wanted, at in led_to:
        if at not in seen and at + _HEAD.size <= end:
            file.seek(at)
            opcode, length = _HEAD.unpack(file.read(_HEAD.size))
            if _CHUNK in (wanted, opcode):  # a chunk's index is taken at its word, others are not
                unpacked += _checked(path, file, at, length)
    if unpacked > max(ALWAYS_UNPACKED_BYTES, MOST_TIMES_PACKED * end):
        raise UserError(
            f"{path}: its {end >> 10} kB unpack to {unpacked >> 20} MB; expected a drive's messages, which "
            f"pack to no less than a {MOST_TIMES_PACKED}th"
        )
    file.seek(0)


def _records(file: BinaryIO, at: int) -> Iterator[tuple[int, int, int]]:
    """Offset, opcode and length of the records that stand in a row from an offset on."""
    end = file.seek(0, 2)
    while at + _HEAD.size <= end:
        file.seek(at)
        opcode, length = _HEAD.unpack(file.read(_HEAD.size))
        yield at, opcode, length
        at += _HEAD.size + length


def _summary_start(file: BinaryIO) -> int:
    """Where the footer says that the summary begins; the file's end where it says nothing."""
    end = file.seek(0, 2)
    if end < _FOOTER_BYTES:
        return end
    file.seek(end - _FOOTER_BYTES)
    footer = file.read(_FOOTER_BYTES)
    if footer[0] != _FOOTER or not footer.endswith(_MAGIC):
        return end
    return int.from_bytes(footer[_HEAD.size :][:8], "little") or end


def _checked(path: Path, file: BinaryIO, at: int, length: int) -> int:
    """What a chunk unpacks to."""
    end = file.seek(0, 2)
    file.seek(at + _HEAD.size)
    unpacked = _unpacked_bytes(file, min(at + _HEAD.size + length, end))
    if unpacked > MOST_UNPACKED_BYTES:
        raise UserError(
            f"{path}: the chunk at byte {at} unpacks to more than {MOST_UNPACKED_BYTES >> 20} MB; "
            "expected a drive's messages in chunks of a few"
        )
    return unpacked


def _unpacked_bytes(file: BinaryIO, end: int) -> int:
    """The larger of what the chunk that the file stands at states, and of what its packed data do."""
    start = file.tell()
    head = file.read(128)
    if len(head) < CHUNK_HEAD.size:
        return 0
    _, _, stated, _, name_length = CHUNK_HEAD.unpack_from(head)
    data = CHUNK_HEAD.size + name_length + 8
    name = head[CHUNK_HEAD.size : data - 8]
    if name == b"lz4":
        return max(stated, _lz4_bytes(file, start + data, end))
    if name != b"zstd":
        return stated
    try:
        return max(stated, zstandard.frame_content_size(head[data:][:_FRAME_BYTES]))
    except zstandard.ZstdError:
        return stated


def _lz4_bytes(file: BinaryIO, at: int, end: int) -> int:
    """The most that an LZ4 frame can unpack to (LZ4 frame format 1.6), by the sizes of its blocks.

    A frame need not state it, and what it states is not what its reader goes by.
    """
    file.seek(at)
    head = file.read(6)
    if len(head) < 6 or _LZ4_BLOCK.unpack_from(head)[0] != _LZ4_MAGIC:
        return 0
    flags, largest = head[4], 1 << 8 + 2 * (head[5] >> 4 & 7)  # 4 to 7: 64 kB to 4 MB
    checksum = 4 if flags & 0x10 else 0
    at += 7 + (8 if flags & 0x08 else 0) + (4 if flags & 0x01 else 0)
    most = 0
    while at + _LZ4_BLOCK.size <= end and most <= MOST_UNPACKED_BYTES:
        file.seek(at)
        word = _LZ4_BLOCK.unpack(file.read(_LZ4_BLOCK.size))[0]
        if word == 0:
            break
        size = word & ~_LZ4_STORED
        most += size if word & _LZ4_STORED else min(largest, _LZ4_MOST_TIMES * size)
        at += _LZ4_BLOCK.size + size + checksum
    return most
