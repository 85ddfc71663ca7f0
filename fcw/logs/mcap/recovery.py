"""Making a whole log of one whose writer was killed, or whose bytes are damaged."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import BinaryIO

from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Attachment, Channel, Chunk, ChunkIndex, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from fcw.errors import UserError
from fcw.files import whole_file
from fcw.logs.mcap import format as mcap
from fcw.logs.mcap.chunks import DAMAGED, chunk_records
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import recovered_log
from fcw.versions import __version__


@dataclass(frozen=True, slots=True)
class RecoveryReport:
    """What was recovered, and what was lost as far as that can be known.

    Attributes:
        frames: results in the new log, or in the old one where that is whole.
        duration_s: from the first of them to the last.
        pictures: shown pictures in it.
        damaged_chunks: parts of the file that held other bytes than were written.
        torn_bytes: at the end of the file, of records that were never finished.
        was_complete: whether the old log had been closed.
        written: whether there is a new log; of a whole one there is none.
    """

    frames: int
    duration_s: float
    pictures: int
    damaged_chunks: int
    torn_bytes: int
    was_complete: bool
    written: bool


def recover(path: Path, out: Path, progress: Callable[[float], None] = lambda part: None) -> RecoveryReport:
    """Copy all that can be read of a log into a new one, read that in full, and count.

    The messages are copied as they are, in the same chunks. Of a whole log nothing is written.

    Args:
        path: the log; it stays as it is.
        out: the new log, written whole or not at all.
        progress: called with the part of the new log that is done, 0 to 1.

    Raises:
        UserError: `path` is no drive log, not a frame of it can be read, or `out` cannot be written.
    """
    if out.exists():
        made = ""
        if out == recovered_log(path):
            made = f"; it was made of {path.name}: `fcw review {quote(str(out))}` opens it"
        raise UserError(f"{out}: is there already; move it away, or name another file with --out{made}")
    log = DriveLog(path, pass_over_damage=True)
    if log.complete and _is_sound(path):
        return _report(log, log, 0, written=False)
    with whole_file(out) as partial:
        with path.open("rb") as source, partial.open("wb") as target:
            copy = _Copy(target)
            copy.start(source)
            chunks = log.chunks.chunks
            for number, chunk in enumerate(chunks, start=1):
                copy.add(source, chunk)
                progress(number / len(chunks))
            copy.finish(log.gathered_series().to_bytes())
        if not copy.counts.get(mcap.RESULT_TOPIC):
            raise UserError(f"{path}: no frame of this log can be read; run the drive again")
        _check(partial, copy.counts)
        return _report(log, DriveLog(partial), copy.damaged_chunks, written=True)


def _is_sound(path: Path) -> bool:
    """Whether a log holds what was written, for mcap's own readers."""
    try:
        found, stated = _messages(path)
    except (*DAMAGED, OSError):
        return False
    return stated == sum(found.values())


def _report(old: DriveLog, whole: DriveLog, damaged_chunks: int, *, written: bool) -> RecoveryReport:
    return RecoveryReport(
        frames=len(whole.series()),
        duration_s=whole.series().duration_s,
        pictures=sum(packet.shown for packet in whole.video_packets()),
        damaged_chunks=damaged_chunks,
        torn_bytes=old.chunks.torn_bytes,
        was_complete=old.complete,
        written=written,
    )


class _Copy:
    """A log made of the readable chunks of another."""

    def __init__(self, target: BinaryIO) -> None:
        self.damaged_chunks = 0
        self.counts: dict[str, int] = {}
        self._writer = Writer(target, chunk_size=mcap.CHUNK_BYTES)
        self._schema_ids = {0: 0}
        self._channels: dict[int, tuple[int, str]] = {}

    def start(self, source: BinaryIO) -> None:
        """Copy what stands before the first chunk."""
        self._writer.start(library=f"fcw {__version__}")
        with suppress(*DAMAGED):  # the first chunk may be torn
            for record in StreamReader(source, emit_chunks=True).records:
                if isinstance(record, Metadata):
                    self._writer.add_metadata(record.name, record.metadata)
                elif isinstance(record, Attachment):
                    self._writer.add_attachment(
                        record.create_time, record.log_time, record.name, record.media_type, record.data
                    )
                elif isinstance(record, Chunk):
                    break

    def add(self, source: BinaryIO, chunk: ChunkIndex) -> None:
        """Copy a chunk; one that is damaged is counted."""
        try:
            records = chunk_records(source, chunk)
        except DAMAGED:
            self.damaged_chunks += 1
            return
        for record in records:
            if isinstance(record, Schema):
                schema_id = self._writer.register_schema(record.name, record.encoding, record.data)
                self._schema_ids[record.id] = schema_id
            elif isinstance(record, Channel):
                schema_id = self._schema_ids[record.schema_id]
                channel_id = self._writer.register_channel(
                    record.topic, record.message_encoding, schema_id, record.metadata
                )
                self._channels[record.id] = channel_id, record.topic
            elif isinstance(record, Message):
                self._add_message(record)
        self._writer.flush()

    def _add_message(self, message: Message) -> None:
        if message.channel_id not in self._channels:  # said in the first chunk, which is damaged
            return
        channel_id, topic = self._channels[message.channel_id]
        self._writer.add_message(
            channel_id, message.log_time, message.data, message.publish_time, message.sequence
        )
        self.counts[topic] = self.counts.get(topic, 0) + 1

    def finish(self, series: bytes) -> None:
        """Add the drive's columns, and what ends a log."""
        self._writer.add_attachment(0, 0, mcap.SERIES_NAME, mcap.SERIES_MEDIA_TYPE, series)
        self._writer.finish()


def _check(path: Path, counts: dict[str, int]) -> None:
    """Read a log in full with mcap's own readers, and compare the numbers of messages."""
    found, stated = _messages(path)
    if found != counts or stated != sum(counts.values()):
        raise RuntimeError(
            f"{path}: {found} messages in the recovered log, {stated} stated, expected {counts}"
        )


def _messages(path: Path) -> tuple[dict[str, int], int | None]:
    """Messages by topic, read with checksums, and how many the file says that it has; None: it does not."""
    found: dict[str, int] = {}
    with path.open("rb") as file:
        for _, channel, _ in NonSeekingReader(file, validate_crcs=True).iter_messages(log_time_order=False):
            found[channel.topic] = found.get(channel.topic, 0) + 1
        file.seek(0)
        summary = SeekingReader(file).get_summary()
    return found, summary.statistics.message_count if summary and summary.statistics else None
