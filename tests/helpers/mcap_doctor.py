"""What `mcap doctor` checks of a file (https://mcap.dev/spec), with the reference library's record reader."""

import zlib
from pathlib import Path

from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk, get_chunk_data_stream

MAGIC = b"\x89MCAP0\r\n"


def placed_records(path: Path) -> list[tuple[int, int, McapRecord]]:
    """Offset, length and record of everything in a file, with CRCs checked and chunks left whole."""
    placed = []
    with path.open("rb") as file:
        records = StreamReader(file, emit_chunks=True, validate_crcs=True).records
        start = len(MAGIC)
        for record in records:
            placed.append((start, file.tell() - start, record))
            start = file.tell()
            if isinstance(record, Footer):
                break
    return placed


def complaints(path: Path) -> list[str]:
    """Everything in which a file departs from what its records say of one another."""
    data, placed, found = path.read_bytes(), placed_records(path), []

    def expect(holds: bool, what: str) -> None:
        if not holds:
            found.append(what)

    expect(data.startswith(MAGIC) and data.endswith(MAGIC), "magic")
    expect(isinstance(placed[0][2], Header), "the first record is no header")
    end = next(i for i, (_, _, record) in enumerate(placed) if isinstance(record, DataEnd))
    section, summary = placed[:end], placed[end + 1 :]
    footer = summary[-1][2]
    assert isinstance(footer, Footer)

    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    counts: dict[int, int] = {}
    latest: dict[int, int] = {}
    times: list[int] = []
    chunks: dict[int, tuple[int, Chunk, dict[int, int]]] = {}
    for offset, length, record in section:
        if isinstance(record, Chunk):
            _, stream_length = get_chunk_data_stream(record, validate_crc=True)
            expect(stream_length == record.uncompressed_size, f"size of the chunk at {offset}")
            inside, entries = message_offsets(record)
            for item in inside:
                if isinstance(item, Schema):
                    expect(schemas.setdefault(item.id, item) == item, f"schema {item.id} twice")
                elif isinstance(item, Channel):
                    expect(channels.setdefault(item.id, item) == item, f"channel {item.id} twice")
                    expect(item.schema_id in schemas, f"channel {item.topic} before its schema")
                elif isinstance(item, Message):
                    expect(item.channel_id in channels, f"message of the unknown channel {item.channel_id}")
                    expect(
                        record.message_start_time <= item.log_time <= record.message_end_time,
                        f"a message's time {item.log_time} outside of its chunk at {offset}",
                    )
                    expect(item.log_time >= latest.get(item.channel_id, 0), "times step back in a channel")
                    latest[item.channel_id] = item.log_time
                    counts[item.channel_id] = counts.get(item.channel_id, 0) + 1
                    times.append(item.log_time)
            own_times = [item.log_time for item in inside if isinstance(item, Message)]
            if own_times:
                expect(record.message_start_time == min(own_times), f"start of the chunk at {offset}")
                expect(record.message_end_time == max(own_times), f"end of the chunk at {offset}")
            indexes, places = following_indexes(section, offset)
            expect(indexes == entries, f"message indexes of the chunk at {offset}")
            chunks[offset] = (length, record, places)
        elif isinstance(record, Schema):
            expect(schemas.setdefault(record.id, record) == record, f"schema {record.id} twice")
        elif isinstance(record, Channel):
            expect(channels.setdefault(record.id, record) == record, f"channel {record.id} twice")
        expect(not isinstance(record, Message), "a message outside of the chunks")

    statistics = [record for _, _, record in summary if isinstance(record, Statistics)]
    expect(len(statistics) == 1, "not one record of statistics")
    for record in statistics:
        expect(record.message_count == sum(counts.values()), "statistics: messages")
        expect({k: v for k, v in record.channel_message_counts.items() if v} == counts, "statistics: counts")
        expect(record.chunk_count == len(chunks), "statistics: chunks")
        expect(record.schema_count == len(schemas), "statistics: schemas")
        expect(record.channel_count == len(channels), "statistics: channels")
        expect(record.attachment_count == number_of(section, Attachment), "statistics: attachments")
        expect(record.metadata_count == number_of(section, Metadata), "statistics: metadata")
        expect(record.message_start_time == min(times, default=0), "statistics: first time")
        expect(record.message_end_time == max(times, default=0), "statistics: last time")
    expect({r.id: r for _, _, r in summary if isinstance(r, Schema)} == schemas, "schemas of the summary")
    expect({r.id: r for _, _, r in summary if isinstance(r, Channel)} == channels, "channels of the summary")

    at = {offset: (length, record) for offset, length, record in section}
    indexed = [record for _, _, record in summary if isinstance(record, ChunkIndex)]
    expect({index.chunk_start_offset for index in indexed} == set(chunks), "chunk indexes")
    for index in indexed:
        length, chunk, places = chunks[index.chunk_start_offset]
        expect(index.chunk_length == length, "chunk index: length")
        expect(index.message_index_offsets == places, "chunk index: message indexes")
        expect(
            (index.message_start_time, index.message_end_time, index.compression, index.uncompressed_size)
            == (chunk.message_start_time, chunk.message_end_time, chunk.compression, chunk.uncompressed_size),
            "chunk index: what it says of its chunk",
        )
        expect(index.compressed_size == len(chunk.data), "chunk index: compressed size")
    for _, _, record in summary:
        if isinstance(record, AttachmentIndex):
            expect(at[record.offset][0] == record.length, f"attachment index of {record.name}")
            attachment = at[record.offset][1]
            expect(isinstance(attachment, Attachment) and attachment.name == record.name, "attachment index")
        elif isinstance(record, MetadataIndex):
            expect(at[record.offset][0] == record.length, f"metadata index of {record.name}")
    expect(number_of(summary, AttachmentIndex) == number_of(section, Attachment), "attachment indexes")
    expect(number_of(summary, MetadataIndex) == number_of(section, Metadata), "metadata indexes")
    check_summary(data, summary, footer, found)
    return found


def check_summary(
    data: bytes, summary: list[tuple[int, int, McapRecord]], footer: Footer, found: list[str]
) -> None:
    """The footer's offsets, its CRC, and the groups that the summary offsets point to."""
    if footer.summary_start != summary[0][0]:
        found.append("footer: start of the summary")
    offsets = [(offset, record) for offset, _, record in summary if isinstance(record, SummaryOffset)]
    if offsets and footer.summary_offset_start != offsets[0][0]:
        found.append("footer: start of the summary offsets")
    covered = data[footer.summary_start : len(data) - len(MAGIC) - 4]
    if footer.summary_crc not in (0, zlib.crc32(covered)):
        found.append("footer: CRC of the summary")
    starts = {offset: record for offset, _, record in summary}
    for _, group in offsets:
        record = starts.get(group.group_start)
        if group.group_length == 0:
            continue
        if record is None or data[group.group_start] != group.group_opcode:
            found.append(f"summary offset of the records {group.group_opcode}")


def number_of(records: list[tuple[int, int, McapRecord]], kind: type[McapRecord]) -> int:
    return sum(isinstance(record, kind) for _, _, record in records)


def message_offsets(chunk: Chunk) -> tuple[list[McapRecord], dict[int, list[tuple[int, int]]]]:
    """A chunk's records, and of each channel its messages' times and places in the uncompressed chunk."""
    stream, length = get_chunk_data_stream(chunk, validate_crc=False)
    entries: dict[int, list[tuple[int, int]]] = {}
    records = breakup_chunk(chunk)
    for record in records:
        place = stream.count
        stream.read1()
        stream.read(stream.read8())
        if isinstance(record, Message):
            entries.setdefault(record.channel_id, []).append((record.log_time, place))
    assert stream.count == length
    return records, entries


def following_indexes(
    section: list[tuple[int, int, McapRecord]], chunk_offset: int
) -> tuple[dict[int, list[tuple[int, int]]], dict[int, int]]:
    """The message indexes after a chunk: their entries that are not empty, and where they stand."""
    entries: dict[int, list[tuple[int, int]]] = {}
    places: dict[int, int] = {}
    started = False
    for offset, _, record in section:
        if offset == chunk_offset:
            started = True
        elif started and isinstance(record, MessageIndex):
            if record.records:
                entries[record.channel_id] = [(time, place) for time, place in record.records]
                places[record.channel_id] = offset
        elif started:
            break
    return entries, places
