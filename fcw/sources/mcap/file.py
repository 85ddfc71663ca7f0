"""Reads any MCAP file as a stream: its topics, the messages of some of them, and its attachments."""

import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from statistics import median_high
from typing import Any, BinaryIO, NamedTuple, TypeVar

from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Attachment, Channel, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.summary import Summary
from mcap_protobuf.decoder import DecoderFactory as ProtobufDecoders
from mcap_ros2.decoder import DecoderFactory as Ros2Decoders
from zstandard import ZstdError

from fcw.bounded.mcap_chunks import check_chunks
from fcw.errors import UserError

DAMAGED = (
    *(McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, OverflowError, RuntimeError),
    MemoryError,  # a length that is damaged may be any
)
"""What mcap's reader and its decompressors raise if a file ends early or is damaged."""
UNDECODABLE = (DecodeError, *DAMAGED, IndexError, TypeError, NotImplementedError)
"""What the decoders raise if a message does not match its schema."""
NOT_AS_NAMED = (AttributeError, TypeError, ValueError, IndexError, ArithmeticError)
"""What reading a field raises if the file's own schema is not what its name suggests."""

LATEST_NS = 2**63 - 1
"""In the year 2262; MCAP's times go twice as far."""
Decoder = Callable[[bytes], object]
Read = TypeVar("Read")
DELAY_MARGIN_NS = 2_000_000_000
"""How much shorter than that of the first message the delay of another message may be."""
BESIDE = 3
"""So many messages before and after a message show what its delay should be."""
STRAY_NS = 5_000_000_000
"""If the delay of a message differs by more than this from its neighbours', its stamp is wrong."""


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a file.

    Attributes:
        name: name of the topic.
        type: name of the schema of its messages, without the `/msg/` of ROS 2.
        readable: whether there is a decoder for its encoding, which is protobuf or ROS 2's CDR.
        count: number of its messages; None if the file does not state it.
        encoding: encodings of its messages and of their schema, as stated in the file.
    """

    name: str
    type: str
    readable: bool
    count: int | None
    encoding: str = ""

    def __str__(self) -> str:
        return f"{self.name} ({self.type})"


@dataclass(frozen=True, slots=True, eq=False)
class Logged:
    """A message.

    Attributes:
        topic: name of its topic.
        log_ns: when it was logged.
        content: its fields as attributes; None if it could not be decoded.
    """

    topic: str
    log_ns: int
    content: Any

    def read(self, fields: Callable[[Any], Read]) -> Read | None:
        """Apply a function to the fields; None if there are none, or they are not what it needs."""
        if self.content is None:
            return None
        try:
            return fields(self.content)
        except NOT_AS_NAMED:
            return None

    @property
    def stamp_ns(self) -> int | None:
        """The message's own time stamp; None if it has none, or it is out of range or 0 (no clock)."""
        stamp_ns = self.read(_stamp_ns)
        return stamp_ns if stamp_ns is not None and 0 < abs(stamp_ns) <= LATEST_NS else None

    @property
    def delay_ns(self) -> int | None:
        """How much later than its stamp it was logged; None without a stamp."""
        return None if (stamp_ns := self.stamp_ns) is None else self.log_ns - stamp_ns


class Timed(NamedTuple):
    """A message and its time.

    Attributes:
        message: the message.
        time_ns: its time on the clock of its topic.
        stray: whether its stamp was not used because it cannot be right.
    """

    message: Logged
    time_ns: int
    stray: bool = False


@dataclass(frozen=True, slots=True)
class Clock:
    """Gives the times of the messages of a topic.

    Attributes:
        stamps: whether the times are the messages' own stamps; else they are log times.
        delay_ns: how much later than their times the first messages were logged.
    """

    stamps: bool
    delay_ns: int

    @classmethod
    def of(cls, file: "McapFile", topic: str) -> "Clock":
        """The clock of a topic, from its first messages."""
        first = [message.delay_ns for message in islice(file.messages([topic]), 2 * BESIDE + 1)]
        if not first or first[0] is None:
            return cls(False, 0)
        return cls(True, median_high(delay_ns for delay_ns in first if delay_ns is not None))

    def timed(self, messages: Iterable[Logged]) -> Iterator[Timed]:
        """Messages of a topic with their times, in the order of the file.

        A message without a stamp, or with a stray one, gets its log time minus the delay of its neighbours.
        Only neighbours are used, because a clock may drift or be set during a recording.
        """
        if not self.stamps:
            yield from (Timed(message, message.log_ns) for message in messages)
            return
        messages = iter(messages)
        before: deque[int] = deque(maxlen=BESIDE)
        ahead: deque[Logged] = deque()
        while True:
            ahead.extend(islice(messages, BESIDE + 1 - len(ahead)))
            if not ahead:
                return
            delays = [*before, *(each.delay_ns for each in ahead if each.delay_ns is not None)]
            usual_ns = median_high(delays) if delays else self.delay_ns
            message = ahead.popleft()
            delay_ns = message.delay_ns
            stray = delay_ns is not None and abs(delay_ns - usual_ns) > STRAY_NS
            used_ns = usual_ns if stray or delay_ns is None else delay_ns
            yield Timed(message, message.log_ns - used_ns, stray)
            if delay_ns is not None:
                before.append(delay_ns)

    def search_ns(self, time_ns: int) -> int:
        """A log time that is certainly before that of a message with this time."""
        return max(time_ns + self.delay_ns - (DELAY_MARGIN_NS if self.stamps else 0), 0)


class McapFile:
    """An MCAP file, whose messages are read one chunk at a time.

    Attributes:
        path: path of the file.
        topics: its topics by name.
        torn: whether it is unfinished or damaged; then it is read up to that place.
    """

    def __init__(self, path: Path) -> None:
        """Read the summary of the file; a file without one is read through once.

        Raises:
            UserError: the file cannot be read, or is not MCAP.
        """
        self.path = path
        self.torn = False
        self._indexed = False
        with self._opened() as file:
            check_chunks(path, file)
            summary = self._summary(file)
            if summary is not None and summary.statistics is not None and summary.channels:
                self._indexed = bool(summary.chunk_indexes)
                counts: dict[int, int] | None = dict(summary.statistics.channel_message_counts)
                channels, schemas = summary.channels, summary.schemas
            else:
                channels, schemas, counts = self._scan(file)
        topics: dict[str, Topic] = {}
        for number, channel in channels.items():
            schema = schemas.get(channel.schema_id)
            known = topics.get(channel.topic)
            count = (counts.get(number, 0) if counts else 0) + (known.count or 0 if known else 0)
            topics[channel.topic] = Topic(
                channel.topic,
                schema.name.replace("/msg/", "/") if schema else "no schema",
                _decoder(_decoders(), channel, schema) is not None,
                count if counts else None,
                f"{channel.message_encoding or 'nothing'} with {(schema and schema.encoding) or 'no schema'}",
            )
        self.topics = tuple(sorted(topics.values(), key=lambda topic: topic.name))

    @property
    def notes(self) -> tuple[str, ...]:
        """A note if the file is unfinished or damaged, once that is known."""
        return (f"{self.path.name}: the file was never finished or is damaged; read up to there",) * self.torn

    def messages(
        self, topics: Iterable[str], start_log_ns: int | None = None, as_they_stand: bool = False
    ) -> Iterator[Logged]:
        """Messages of some topics by log time; without an index, in the order of the file.

        Of a damaged file, everything before the damage is read, and `torn` is set.
        """
        decoders = _decoders()
        found: dict[int, Decoder | None] = {}
        with self._opened() as file:
            try:
                reader = SeekingReader(file) if self._indexed else NonSeekingReader(file)
                for schema, channel, message in reader.iter_messages(
                    set(topics),
                    log_time_order=self._indexed and not as_they_stand,
                    starting_at=start_log_ns,
                ):
                    if message.log_time > LATEST_NS:
                        raise ValueError(f"a message logged at {message.log_time} ns")
                    if channel.id not in found:
                        found[channel.id] = _decoder(decoders, channel, schema)
                    yield Logged(channel.topic, message.log_time, _decoded(found[channel.id], message))
            except DAMAGED:
                self.torn = True

    def attachment(self, name: str) -> bytes | None:
        """The data of the first attachment with this name; None if there is none."""
        with self._opened() as file:
            try:
                if not self._indexed:
                    records = StreamReader(file, emit_chunks=True).records
                    found = (record for record in records if isinstance(record, Attachment))
                else:
                    found = SeekingReader(file).iter_attachments()
                return next((record.data for record in found if record.name == name), None)
            except DAMAGED:
                return None

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        try:
            if not self.path.is_file():
                raise UserError(f"{self.path}: no file; expected an MCAP file")
            file = self.path.open("rb")
        except OSError as error:
            raise UserError(
                f"{self.path}: cannot be read ({error.strerror}); expected an MCAP file"
            ) from error
        with file:
            yield file

    def _summary(self, file: BinaryIO) -> Summary | None:
        try:
            reader = SeekingReader(file)
        except DAMAGED as error:
            raise UserError(f"{self.path}: not an MCAP file, though its name says so") from error
        try:
            return reader.get_summary()
        except (*DAMAGED, OSError, StopIteration):
            self.torn = True
            return None

    def _scan(self, file: BinaryIO) -> tuple[dict[int, Channel], dict[int, Schema], dict[int, int] | None]:
        file.seek(0)
        channels: dict[int, Channel] = {}
        schemas: dict[int, Schema] = {}
        counts: dict[int, int] = {}
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    counts[record.channel_id] = counts.get(record.channel_id, 0) + 1
        except DAMAGED:
            self.torn = True
        return channels, schemas, counts


def stray_notes(label: str, strays: int, what: str) -> tuple[str, ...]:
    """A note that stray stamps of a topic were not used; empty if there were none.

    Args:
        label: file and topic.
        strays: number of messages with a stray stamp.
        what: what each of these messages is.
    """
    if not strays:
        return ()
    if strays == 1:
        return (f"{label}: 1 {what} with an impossible time stamp: its log time is used",)
    return (f"{label}: {strays} {what}s with impossible time stamps: their log times are used",)


def _stamp_ns(content: Any) -> int | None:  # noqa: ANN401 - of any schema
    header = getattr(content, "header", None)
    stamp = getattr(content, "timestamp", None) if header is None else getattr(header, "stamp", None)
    if stamp is None:
        return None
    seconds = getattr(stamp, "seconds", None)
    if seconds is None:
        return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    return int(seconds) * 1_000_000_000 + int(stamp.nanos)


def _decoders() -> tuple[ProtobufDecoders, Ros2Decoders]:
    return ProtobufDecoders(), Ros2Decoders()


def _decoder(
    decoders: tuple[ProtobufDecoders, Ros2Decoders], channel: Channel, schema: Schema | None
) -> Decoder | None:
    """The decoder for the messages of a channel; None if there is none."""
    try:
        choices = (decoder.decoder_for(channel.message_encoding, schema) for decoder in decoders)
        return next((choice for choice in choices if choice is not None), None)
    except Exception:  # a schema that cannot be parsed: whatever its parser raises
        return None


def _decoded(decoder: Decoder | None, message: Message) -> object | None:
    try:
        return None if decoder is None else decoder(message.data)
    except UNDECODABLE:
        return None
