"""Where the chunks of an MCAP file stand, by its index or, where its writer was killed, by going over it."""

import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, Message
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

DAMAGED = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, OverflowError)
"""What mcap's readers raise where a file ends inside a record, or holds other bytes than were written."""
_RECORD_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
_CHANNEL_ID = struct.Struct("<H")


@dataclass(frozen=True, slots=True)
class ChunkTable:
    """The chunks of a file in their order.

    Attributes:
        chunks: where they stand and what is in them; one without message indexes may hold any topic.
        channel_ids: the channel of each topic.
        end: offset behind the last record that is whole.
    """

    chunks: tuple[ChunkIndex, ...]
    channel_ids: dict[str, int]
    end: int

    def messages(
        self,
        file: BinaryIO,
        topics: Collection[str],
        start_ns: int | None = None,
        end_ns: int | None = None,
    ) -> Iterator[tuple[str, Message]]:
        """Messages of some topics, in the order in which they were written.

        They come from all chunks that hold log times in [start_ns, end_ns): some are earlier or later.
        """
        wanted = {self.channel_ids[topic]: topic for topic in topics if topic in self.channel_ids}
        for chunk in self.chunks:
            if start_ns is not None and chunk.message_end_time < start_ns:
                continue
            if end_ns is not None and chunk.message_start_time >= end_ns:
                continue
            if chunk.message_index_offsets and not wanted.keys() & chunk.message_index_offsets.keys():
                continue
            for record in _chunk_records(file, chunk):
                if isinstance(record, Message) and record.channel_id in wanted:
                    yield wanted[record.channel_id], record

    def last_ns(self, topic: str) -> int | None:
        """Latest log time in chunks that hold a topic, by their message indexes; None where there is none."""
        channel_id = self.channel_ids.get(topic)
        times = [c.message_end_time for c in self.chunks if channel_id in c.message_index_offsets]
        return max(times, default=None)


def indexed_chunks(file: BinaryIO) -> ChunkTable:
    """The chunks of a finished file."""
    file.seek(0)
    summary = SeekingReader(file).get_summary()
    if summary is None:
        return scanned_chunks(file)
    ids = {channel.topic: channel.id for channel in summary.channels.values()}
    chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    return ChunkTable(tuple(chunks), ids, file.seek(0, 2))


def scanned_chunks(file: BinaryIO) -> ChunkTable:
    """The whole chunks of a file without an index, by the heads of its records."""
    size, offset = file.seek(0, 2), len(MCAP0_MAGIC)
    chunks: list[ChunkIndex] = []
    while offset + _RECORD_HEAD.size <= size:
        file.seek(offset)
        opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
        end = offset + _RECORD_HEAD.size + length
        if opcode == 0 or end > size:  # no record has the code 0, which a power cut leaves
            break
        if opcode == Opcode.CHUNK:
            chunks.append(_chunk_index(file, offset, end - offset))
        elif opcode == Opcode.MESSAGE_INDEX and chunks:
            (channel_id,) = _CHANNEL_ID.unpack(file.read(_CHANNEL_ID.size))
            chunks[-1].message_index_offsets[channel_id] = offset
        offset = end
    if chunks:
        chunks[-1].message_index_offsets.clear()  # some of them may be missing
    ids: dict[str, int] = {}
    if chunks:
        channels = [r for r in _chunk_records(file, chunks[0]) if isinstance(r, Channel)]
        ids = {channel.topic: channel.id for channel in channels}
    return ChunkTable(tuple(chunks), ids, offset)


def _chunk_records(file: BinaryIO, chunk: ChunkIndex) -> list:
    file.seek(chunk.chunk_start_offset + _RECORD_HEAD.size)
    return breakup_chunk(Chunk.read(ReadDataStream(file)), validate_crc=True)


def _chunk_index(file: BinaryIO, offset: int, length: int) -> ChunkIndex:
    """The index of a chunk, as far as its head says; the file stands behind the record's head."""
    start_ns, end_ns, size, _crc, name_length = _CHUNK_HEAD.unpack(file.read(_CHUNK_HEAD.size))
    compression = file.read(name_length).decode()
    (compressed_size,) = struct.unpack("<Q", file.read(8))
    return ChunkIndex(
        message_start_time=start_ns,
        message_end_time=end_ns,
        chunk_start_offset=offset,
        chunk_length=length,
        message_index_offsets={},
        message_index_length=0,
        compression=compression,
        compressed_size=compressed_size,
        uncompressed_size=size,
    )
