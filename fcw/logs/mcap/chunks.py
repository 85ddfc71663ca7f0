"""Where the chunks of an MCAP file stand, by its index or, where its writer was killed, by going over it."""

import struct
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from typing import BinaryIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    McapRecord,
    Message,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray
from zstandard import ZstdError

from fcw.bounded.mcap_chunks import CHUNK_HEAD

DAMAGED = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, OverflowError, MemoryError)
"""What mcap's readers raise where a file ends inside a record, or holds other bytes than were written."""
_RECORD_HEAD = struct.Struct("<BQ")
_CHANNEL_ID = struct.Struct("<H")
_DATA_LENGTH_BYTES = 8
_FOOTER_BYTES = 9 + 20 + len(MCAP0_MAGIC)
"""Head and body of the footer record, and what a file ends with."""


class ChunkTable:
    """The chunks of a file in their order.

    Attributes:
        chunks: where they stand and what is in them; one without message indexes may hold any topic.
        topics: by the number of the channel.
        whole_bytes: of a file that was scanned, up to the end of its last record that is whole.
        torn_bytes: after that record.
    """

    def __init__(
        self,
        chunks: Sequence[ChunkIndex],
        topics: dict[int, str],
        whole_bytes: int = len(MCAP0_MAGIC),
        torn_bytes: int = 0,
    ) -> None:
        self.chunks = tuple(chunks)
        self.topics = topics
        self.whole_bytes, self.torn_bytes = whole_bytes, torn_bytes
        self._starts_ns = np.array([chunk.message_start_time for chunk in chunks], np.uint64)
        self._ends_ns = np.array([chunk.message_end_time for chunk in chunks], np.uint64)
        self._holding: dict[str, NDArray[np.bool_]] = {}

    def messages(
        self,
        file: BinaryIO,
        topics: Collection[str],
        start_ns: int = 0,
        end_ns: int | None = None,
        *,
        first_chunk: int = 0,
        pass_over_damage: bool = False,
    ) -> Iterator[tuple[str, Message]]:
        """Messages of some topics, in the order in which they were written.

        They come from all chunks, from number `first_chunk` on, that hold log times in [start_ns, end_ns):
        some are earlier or later.

        Raises:
            One of `DAMAGED`, where damaged chunks are not to be passed over.
        """
        wanted = {channel_id: topic for channel_id, topic in self.topics.items() if topic in topics}
        inside = np.logical_or.reduce([self._holds(topic) for topic in topics])
        inside[:first_chunk] = False
        inside &= self._ends_ns >= start_ns
        if end_ns is not None:
            inside &= self._starts_ns < end_ns
        for number in np.flatnonzero(inside):
            try:
                records = chunk_records(file, self.chunks[number])
            except DAMAGED:
                if pass_over_damage:
                    continue
                raise
            for record in records:
                if isinstance(record, Message) and record.channel_id in wanted:
                    yield wanted[record.channel_id], record

    @property
    def start_ns(self) -> int | None:
        """Earliest log time; None where there is no chunk."""
        return int(self._starts_ns.min()) if self.chunks else None

    def end_ns(self, topic: str | None = None) -> int | None:
        """Latest log time in the chunks, or in those that hold a topic; None where there is none."""
        ends_ns = self._ends_ns if topic is None else self._ends_ns[self._holds(topic)]
        return int(ends_ns.max()) if len(ends_ns) else None

    def span(self, start_ns: int, end_ns: int) -> tuple[int, int]:
        """First byte, and number of bytes, of all chunks that hold log times in [start_ns, end_ns].

        Both are 0 where there is none.
        """
        inside = [
            self.chunks[i] for i in np.flatnonzero((self._ends_ns >= start_ns) & (self._starts_ns <= end_ns))
        ]
        if not inside:
            return 0, 0
        first = min(chunk.chunk_start_offset for chunk in inside)
        return first, max(chunk.chunk_start_offset + chunk.chunk_length for chunk in inside) - first

    def _holds(self, topic: str) -> NDArray[np.bool_]:
        """Which chunks may hold a topic."""
        if topic not in self._holding:
            ids = {channel_id for channel_id, other in self.topics.items() if other == topic}
            found = [
                not chunk.message_index_offsets or not ids.isdisjoint(chunk.message_index_offsets)
                for chunk in self.chunks
            ]
            self._holding[topic] = np.array(found, np.bool_)
        return self._holding[topic]


def indexed_chunks(file: BinaryIO) -> ChunkTable:
    """The chunks of a finished file.

    Raises:
        One of `DAMAGED`: its index cannot be read.
    """
    file.seek(0)
    summary = SeekingReader(file).get_summary()
    if summary is None:
        return scanned_chunks(file)
    chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    return ChunkTable(chunks, {c.id: c.topic for c in summary.channels.values()})


def stored_attachment(file: BinaryIO, name: str) -> bytes | None:
    """An attachment of a finished file, found without its chunks' long index; None where it has none.

    Raises:
        One of `DAMAGED`: the file's end cannot be read.
    """
    file.seek(-_FOOTER_BYTES, 2)
    footer = next(StreamReader(file, skip_magic=True).records)
    if not isinstance(footer, Footer) or not footer.summary_offset_start:
        return None
    file.seek(footer.summary_offset_start)
    groups = {
        record.group_opcode: record.group_start
        for record in StreamReader(file, skip_magic=True).records
        if isinstance(record, SummaryOffset)
    }
    if Opcode.ATTACHMENT_INDEX not in groups:
        return None
    file.seek(groups[Opcode.ATTACHMENT_INDEX])
    for index in StreamReader(file, skip_magic=True).records:
        if isinstance(index, AttachmentIndex) and index.name == name:
            file.seek(index.offset)
            record = next(StreamReader(file, skip_magic=True).records)
            return record.data if isinstance(record, Attachment) else None
    return None


def scanned_chunks(file: BinaryIO, known: ChunkTable | None = None) -> ChunkTable:
    """The whole chunks of a file without an index, by the heads of its records.

    Args:
        file: the file.
        known: what was found when the file was shorter; only what came after it is read.
    """
    size, offset = file.seek(0, 2), len(MCAP0_MAGIC)
    chunks: list[ChunkIndex] = []
    if known is not None:
        offset, chunks = known.whole_bytes, list(known.chunks)
    while offset + _RECORD_HEAD.size <= size:
        file.seek(offset)
        opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
        end = offset + _RECORD_HEAD.size + length
        if opcode in (0, Opcode.DATA_END) or end > size:  # a power cut leaves zeros; no record has that code
            break
        if opcode == Opcode.CHUNK:
            chunks.append(_chunk_index(file, offset, end - offset))
        elif opcode == Opcode.MESSAGE_INDEX and chunks:
            (channel_id,) = _CHANNEL_ID.unpack(file.read(_CHANNEL_ID.size))
            chunks[-1].message_index_offsets[channel_id] = offset
        offset = end
    if chunks:
        _complete_index(file, chunks[-1])
    return ChunkTable(chunks, _topics(file, chunks), offset, size - offset)


def chunk_records(file: BinaryIO, chunk: ChunkIndex) -> list[McapRecord]:
    """Schemas, channels and messages of a chunk.

    Raises:
        One of `DAMAGED`: its bytes are not those that were written.
    """
    file.seek(chunk.chunk_start_offset + _RECORD_HEAD.size)
    return breakup_chunk(Chunk.read(ReadDataStream(file)), validate_crc=True)


def _complete_index(file: BinaryIO, last: ChunkIndex) -> None:
    """Note what is in the last chunk: the indexes that follow it may be torn off."""
    with suppress(*DAMAGED):
        for record in chunk_records(file, last):
            if isinstance(record, Message):
                last.message_index_offsets.setdefault(record.channel_id, 0)


def _topics(file: BinaryIO, chunks: Sequence[ChunkIndex]) -> dict[int, str]:
    """Topics by their channels, which stand in the first chunk that can be read."""
    for chunk in chunks:
        with suppress(*DAMAGED):
            return {r.id: r.topic for r in chunk_records(file, chunk) if isinstance(r, Channel)}
    return {}


def _chunk_index(file: BinaryIO, offset: int, length: int) -> ChunkIndex:
    """The index of a chunk, as far as its head says; the file stands behind the record's head."""
    start_ns, end_ns, size, _crc, name_length = CHUNK_HEAD.unpack(file.read(CHUNK_HEAD.size))
    compression = file.read(name_length)
    return ChunkIndex(
        message_start_time=start_ns,
        message_end_time=end_ns,
        chunk_start_offset=offset,
        chunk_length=length,
        message_index_offsets={},
        message_index_length=0,
        compression=compression.decode(errors="replace"),
        compressed_size=length - CHUNK_HEAD.size - len(compression) - _DATA_LENGTH_BYTES,
        uncompressed_size=size,
    )
