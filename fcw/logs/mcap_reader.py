"""Reading a drive log back."""

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Attachment, Chunk, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from fcw.errors import UserError
from fcw.logs import mcap_format as mcap
from fcw.logs.messages import result_from_message
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.schemas import drive_pb2
from fcw.sources.frame import VideoPacket

_DAMAGED = (McapError, ZstdError, struct.error, EOFError, ValueError, KeyError, OverflowError)
"""What mcap's readers raise where a file ends inside a record, or holds other bytes than were written."""


class DriveLog:
    """A drive log in MCAP.

    A log whose writer was killed is read up to where it is torn.

    Attributes:
        path: the file.
        header: what the log was opened with.
        complete: False where the log was never closed.
    """

    def __init__(self, path: Path) -> None:
        """Read the header.

        Raises:
            UserError: the file is missing, or is no drive log.
        """
        self.path = path
        try:
            with path.open("rb") as file:
                self.header = self._read_header(file)
                file.seek(-min(len(MCAP0_MAGIC), file.tell()), 2)
                self.complete = file.read() == MCAP0_MAGIC
        except OSError as error:
            raise UserError(
                f"{path}: cannot read the log ({error.strerror}); expected a drive.mcap of `fcw run`"
            ) from error

    def results(self) -> Iterator[FrameResult]:
        """Every frame's result, in order.

        Raises:
            UserError: a complete log holds damaged bytes.
        """
        for _, data in self._messages((mcap.RESULT_TOPIC,)):
            yield result_from_message(data)

    def entries(self) -> Iterator[tuple[FrameResult, tuple[VideoPacket, ...]]]:
        """Every frame's result with its video packets, as they were given to `Sink.write`."""
        video: list[bytes] = []
        packets: list[VideoPacket] = []
        for topic, data in self._messages((mcap.VIDEO_TOPIC, mcap.VIDEO_INDEX_TOPIC, mcap.RESULT_TOPIC)):
            if topic == mcap.VIDEO_TOPIC:
                video.append(CompressedVideo.FromString(data).data)
            elif topic == mcap.VIDEO_INDEX_TOPIC:
                index = drive_pb2.VideoPacket.FromString(data)
                packets.append(VideoPacket(video.pop(), index.time_ns, index.keyframe, index.shown))
            else:
                yield result_from_message(data), tuple(packets)
                packets.clear()

    def video_packets(self) -> Iterator[VideoPacket]:
        """Every video packet in decoding order."""
        for _, packets in self.entries():
            yield from packets

    def _messages(self, topics: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """Topic and data of messages in the order in which they were written."""
        with self.path.open("rb") as file:
            try:
                reader = (SeekingReader if self.complete else NonSeekingReader)(file, validate_crcs=True)
                for _, channel, message in reader.iter_messages(topics, log_time_order=False):
                    yield channel.topic, message.data
            except _DAMAGED as error:
                if self.complete:
                    raise UserError(
                        f"{self.path}: the log is damaged ({error}); copy it again, or run the drive again"
                    ) from error

    def _read_header(self, file: BinaryIO) -> DriveHeader:
        """The header from the records before the first chunk."""
        metadata: dict[str, dict[str, str]] = {}
        attachments: dict[str, bytes] = {}
        try:
            for record in StreamReader(file, emit_chunks=True).records:
                if isinstance(record, Metadata):
                    metadata[record.name] = record.metadata
                elif isinstance(record, Attachment):
                    attachments[record.name] = record.data
                elif isinstance(record, Chunk):
                    break
        except _DAMAGED as error:
            if mcap.CALIBRATION_NAME not in attachments:
                raise UserError(
                    f"{self.path}: not a drive log, or one cut off at its start ({error}); "
                    "expected a drive.mcap of `fcw run`"
                ) from error
        try:
            drive = metadata[mcap.DRIVE_METADATA]
            if drive["format_version"] != mcap.FORMAT_VERSION:
                raise UserError(
                    f"{self.path}: drive log of format version {drive['format_version']}, expected "
                    f"{mcap.FORMAT_VERSION}; run the drive again with this version of fcw"
                )
            calibration = attachments[mcap.CALIBRATION_NAME].decode()
            return mcap.drive_header(drive, metadata[mcap.VERSIONS_METADATA], calibration, str(self.path))
        except (KeyError, ValueError) as error:
            raise UserError(
                f"{self.path}: an MCAP file, but no drive log of fcw (no {error}); "
                "expected a drive.mcap of `fcw run`"
            ) from error
