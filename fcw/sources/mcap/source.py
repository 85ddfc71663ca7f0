"""Reads MCAP files as drives: pictures and video of Foxglove and ROS 2, and this program's own logs.

The time of a picture is the stamp in its message (`header.stamp`, `timestamp`), which is when the camera saw
it; the log time includes the delay to the recorder. If the first picture of a topic has no stamp, log times
are used. The log time is also used for a picture whose stamp is far from those of its neighbours. Times stay
as they are, mostly nanoseconds since 1970, so that a log matches the file it was made from. Files are read
one chunk at a time, unfinished ones up to their end.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

from fcw.errors import UserError
from fcw.frame import Source, VideoPacket
from fcw.sources import h264
from fcw.sources.mcap.file import DELAY_MARGIN_NS, Clock, McapFile, Timed, Topic, stray_notes
from fcw.sources.mcap.images import McapImageSource
from fcw.sources.mcap.pictures import PICTURE_TYPES, VIDEO_CODECS, VIDEO_TYPES
from fcw.sources.mcap.video import PacketVideoSource, counted, reorders

OWN_LOG_TYPE = "fcw.VideoPacket"
"""Only logs of this program state whether a packet is shown."""
ORDER_PACKETS = 64
"""So many packets show their order, because no codec lets more than 16 pictures wait for others."""
MOST_PARAMETER_BYTES = 1 << 16
"""Largest size of parameter sets in separate messages."""
READ_ENCODINGS = ("protobuf with protobuf", "cdr with ros2msg")
"""Encodings of messages and their schemas that can be read."""


def open_mcap(path: Path, topic: str | None = None) -> Source:
    """Open the pictures of an MCAP file.

    Args:
        path: the file.
        topic: the topic of the pictures; None if there is only one.

    Raises:
        UserError: the file is not MCAP or has no pictures; several topics have pictures and none is named;
            the named topic does not exist; or its pictures have a form that cannot be read.
    """
    file = McapFile(path)
    pictures = picture_topic(file, topic)
    if pictures.type not in VIDEO_TYPES:
        return McapImageSource(file, pictures)
    codec = _codec(file, pictures)
    label = f"{path}: {pictures.name}"
    if is_own_log(file):
        from fcw.logs.mcap.reader import DriveLog  # it builds on the packets of this package

        log = DriveLog(path)
        size = log.header.image_size
        source = PacketVideoSource(path.name, label, log.video_packets, codec, lambda: file.notes, size)
        source.zero_utc_ns = log.header.zero_utc_ns
        return source
    packets = _ForeignPackets(file, pictures, codec)
    try:
        return PacketVideoSource(path.name, label, packets, codec, lambda: packets.notes)
    except UserError as error:
        raise UserError(f"{error}{packets.other_form}") from None


def is_own_log(file: McapFile) -> bool:
    """Whether a file is one drive log of this program; two merged logs are read as separate topics."""
    return sum(topic.type == OWN_LOG_TYPE for topic in file.topics) == 1


def picture_topic(file: McapFile, name: str | None) -> Topic:
    """The topic of pictures to read; an empty one counts only if it is named.

    Raises:
        UserError: see `open_mcap`.
    """
    pictures = [topic for topic in file.topics if topic.type in PICTURE_TYPES]
    readable = [topic for topic in pictures if topic.readable]
    if name is not None:
        found = next((topic for topic in file.topics if topic.name == name), None)
        if found is None:
            what = "no such topic"
        elif found in readable:
            return found
        else:
            no_pictures = f"a topic of {found.type}, which is not a type of pictures"
            what = _unreadable(found) if found in pictures else no_pictures
        has = f"expected one of: {'; '.join(map(str, readable))}" if readable else "the file has no other"
        raise UserError(f"{file.path}: --topic {name}: {what}; {has}")
    filled = [topic for topic in pictures if topic.count != 0]
    if len(filled) > 1:
        raise UserError(
            f"{file.path}: several topics of pictures: {'; '.join(map(str, filled))}; "
            "name the camera that looks ahead with --topic"
        )
    if filled:
        if not filled[0].readable:
            raise UserError(f"{file.path}: {filled[0]}: {_unreadable(filled[0])}")
        return filled[0]
    held = "; ".join(map(str, file.topics)) or "nothing"
    raise UserError(
        f"{file.path}: no topic of pictures; expected {', '.join(VIDEO_TYPES[:1])}, "
        "foxglove.CompressedImage, foxglove.RawImage (protobuf), sensor_msgs/CompressedImage or "
        f"sensor_msgs/Image (ROS 2); it holds: {held}"
    )


def _unreadable(topic: Topic) -> str:
    """Why the messages of a topic cannot be read."""
    if topic.encoding in READ_ENCODINGS:
        return f"the schema of its messages ({topic.encoding}) is damaged; record or convert it again"
    return f"its messages are {topic.encoding}; expected {' or '.join(READ_ENCODINGS)}: convert it first"


def _codec(file: McapFile, topic: Topic) -> str:
    """FFmpeg's name for the codec of a topic."""
    first = next(file.messages([topic.name]), None)
    stated = (None if first is None else first.read(lambda content: str(content.format))) or ""
    codec = VIDEO_CODECS.get(stated.lower())
    if codec is None:
        raise UserError(
            f"{file.path}: {topic}: video of the format {stated!r}; expected one of {', '.join(VIDEO_CODECS)}"
        )
    return codec


class _ForeignPackets:
    """The packets of a topic from the first keyframe on; a recording may begin between two keyframes."""

    def __init__(self, file: McapFile, topic: Topic, codec: str) -> None:
        self._file, self._topic, self._codec = file, topic, codec
        self._clock = Clock.of(file, topic.name)
        self._as_they_stand = self._log_times_disorder()
        self._before_keyframe, self._strays = 0, 0

    def _log_times_disorder(self) -> bool:
        """Whether the packets are in decoding order in the file, but not by their log times.

        This happens with a video whose pictures refer to later ones, if the log time of each packet is the
        time of its picture. Then the log times step back in the order of the file.
        """
        by_log, standing = (
            [*islice(self._clock.timed(self._file.messages([self._topic.name], None, stand)), ORDER_PACKETS)]
            for stand in (False, True)
        )
        if _steps_back(by_log) or not _steps_back(standing):
            return False
        data = (each.message.read(_data) for each in standing)
        return reorders(filter(None, data), self._codec)

    @property
    def other_form(self) -> str:
        """What to do if the packets have lengths instead of start codes, as in an MP4 file."""
        first = next(self._file.messages([self._topic.name]), None)
        data = None if first is None else first.read(_data)
        if not data or self._codec not in ("h264", "hevc") or h264.is_annex_b(data):
            return ""
        return (
            "; its packets do not begin with a start code (Annex B), but may be as in an MP4 file: convert "
            f"them with FFmpeg's {self._codec}_mp4toannexb"
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be read so far, and what was left out of the topic."""
        label = f"{self._file.path}: {self._topic.name}"
        strays = stray_notes(label, self._strays, "picture")
        if not self._before_keyframe:
            return (*strays, *self._file.notes)
        left_out = f"{label}: {counted(self._before_keyframe)} before the first keyframe left out"
        return (left_out, *strays, *self._file.notes)

    def __call__(self, key_ns: int | None) -> Iterator[VideoPacket]:
        """See `PacketStream`."""
        started = self._codec != "h264"
        before, strays = 0, 0
        # A message with its parameter sets may precede the keyframe.
        search_ns = None if key_ns is None else max(self._clock.search_ns(key_ns) - DELAY_MARGIN_NS, 0)
        messages = self._file.messages([self._topic.name], search_ns, self._as_they_stand)
        apart = b""
        for message, time_ns, stray in self._clock.timed(messages):
            strays += stray
            self._strays = max(strays, self._strays)
            data = message.read(_data)
            if data is None:
                continue
            unit = None
            if self._codec == "h264":
                data, apart = apart + data, b""
                unit = h264.inspect(data)
                if unit is None and h264.is_annex_b(data):
                    apart = data[-MOST_PARAMETER_BYTES:]  # parameter sets alone are no picture
                    continue
            if key_ns is not None and time_ns < key_ns:
                continue
            keyframe = unit is not None and unit.idr and unit.parameter_sets
            started |= keyframe
            if started:
                yield VideoPacket(data, time_ns, keyframe, shown=True)
            elif unit is not None:
                before += 1
                self._before_keyframe = max(before, self._before_keyframe)


def _data(content: Any) -> bytes:  # noqa: ANN401 - of any schema
    return bytes(memoryview(content.data))


def _steps_back(messages: Sequence[Timed]) -> bool:
    return any(after.time_ns < before.time_ns for before, after in pairwise(messages))
