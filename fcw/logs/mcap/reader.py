"""Reads a drive log."""

import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from shlex import quote
from typing import BinaryIO

from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from mcap.records import Attachment, Chunk, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from fcw.bounded.gpx import GpxTrack, parse_gpx
from fcw.bounded.mcap_chunks import check_chunks
from fcw.errors import UserError
from fcw.frame import VideoPacket
from fcw.logs.mcap import format as mcap
from fcw.logs.mcap.chunks import DAMAGED, ChunkTable, indexed_chunks, scanned_chunks, stored_attachment
from fcw.logs.mcap.messages import result_from_message
from fcw.logs.names import mcap_path, recovered_log
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.schemas import drive_pb2
from fcw.logs.series import DriveSeries, SeriesBuilder
from fcw.units import NS_PER_S


def read_drive(drive: Path | str) -> "DriveLog":
    """Open a drive's log.

    Args:
        drive: a `drive.mcap`, or its folder.

    Raises:
        UserError: there is none, or it is no drive log.
    """
    return DriveLog(mcap_path(Path(drive)))


class DriveLog:
    """A drive log in MCAP.

    A log whose writer was killed is read up to where it ends. Several threads may read at once, as each pass
    opens the file anew.

    Attributes:
        path: the file.
        header: what was known before the first frame.
        complete: whether the log was closed.
    """

    def __init__(self, path: Path, *, pass_over_damage: bool = False) -> None:
        """Read the header.

        Args:
            path: the file.
            pass_over_damage: whether damaged parts of a complete log are skipped instead of raising an error.

        Raises:
            UserError: the file is missing, or is no drive log.
        """
        self.path = path
        self._series: DriveSeries | None = None
        self._known: ChunkTable | None = None
        self._gathered = _Gathered()
        try:
            if path.exists() and not path.is_file():
                raise UserError(f"{path}: no file; expected a drive.mcap of `fcw run`")
            with self._open() as file:
                check_chunks(path, file)
                self.header = self._read_header(file)
                file.seek(-min(len(MCAP0_MAGIC), file.tell()), 2)
                self.complete = file.read() == MCAP0_MAGIC
        except OSError as error:
            raise self._unreadable(error) from error
        self._strict = self.complete and not pass_over_damage

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that the user should read: that the log is incomplete, and how much is lost."""
        if self.complete:
            return ()
        start_ns = self.chunks.start_ns
        torn = f"{self.path}: its writer was stopped before it closed the log"
        if start_ns is None:
            return (f"{torn}; no frame can be read",)
        signals_s, pictures_s = (
            ((self.chunks.end_ns(topic) or start_ns) - start_ns) / NS_PER_S
            for topic in (mcap.RESULT_TOPIC, mcap.VIDEO_TOPIC)
        )
        return (
            f"{torn}; signals can be read up to {signals_s:.2f} s, pictures up to {pictures_s:.2f} s. What "
            f"came after is lost: at most {mcap.SIGNALS_CHUNK_NS / NS_PER_S:g} s of signals and "
            f"{mcap.PICTURES_CHUNK_NS / NS_PER_S:g} s of pictures. {self._recovery}",
        )

    @property
    def _recovery(self) -> str:
        """A sentence on how to recover the log, or where the recovered one is."""
        if (recovered := recovered_log(self.path)) is not None:
            return f"{recovered} is the complete log recovered from it"
        return f"`fcw recover {quote(str(self.path))}` makes a complete log of it"

    @cached_property
    def chunks(self) -> ChunkTable:
        """The positions of the file's chunks.

        Raises:
            UserError: the index of a complete log is damaged.
        """
        with self._open() as file:
            if not self.complete:
                return scanned_chunks(file, self._known)
            try:
                return indexed_chunks(file)
            except DAMAGED as error:
                if self._strict:
                    raise self._damaged(error) from error
                return scanned_chunks(file)

    def track(self) -> GpxTrack | None:
        """The drive's GPX track, with times from the log's first frame; None if there is none.

        Raises:
            UserError: the track is damaged.
        """
        header = self.header
        if not header.gpx:
            return None
        first_ns = int(self.series().time_ns[0])
        begins_ns = first_ns if header.gpx_begins_ns is None else header.gpx_begins_ns
        return parse_gpx(header.gpx, f"{self.path}: its track").later((begins_ns - first_ns) / NS_PER_S)

    def results(self, start_ns: int | None = None, end_ns: int | None = None) -> Iterator[FrameResult]:
        """Results of the frames at times in [start_ns, end_ns), in order; all by default.

        Raises:
            UserError: a complete log holds damaged bytes.
        """
        for _, message in self._messages((mcap.RESULT_TOPIC,), start_ns, end_ns):
            result = result_from_message(message.data)
            if _within(result.time_ns, start_ns, end_ns):
                yield result

    def entries(
        self, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[tuple[FrameResult, tuple[VideoPacket, ...]]]:
        """Results of the frames at times in [start_ns, end_ns) with their packets, as they were written.

        Pictures are written later than signals, so the last results of an incomplete log may have no packets.
        The first packet of a range need not be a keyframe; see `video_packets`.
        """
        packets = self._packets(start_ns, end_ns)
        following = next(packets, None)
        for result in self.results(start_ns, end_ns):
            own: list[VideoPacket] = []
            while following is not None and following[0] <= result.index:
                if following[0] == result.index:
                    own.append(following[1])
                following = next(packets, None)
            yield result, tuple(own)

    def video_packets(self, start_ns: int | None = None, end_ns: int | None = None) -> Iterator[VideoPacket]:
        """Video packets in decoding order up to `end_ns` (exclusive).

        They start at the keyframe from which the picture at `start_ns` can be decoded.
        """
        if start_ns is not None:
            start_ns = self.series().keyframe_before(start_ns)
        for _, packet in self._packets(start_ns, end_ns):
            if _within(packet.time_ns, start_ns, end_ns):
                yield packet

    def series(self, progress: Callable[[float], None] = lambda part: None) -> DriveSeries:
        """The signals as columns: those stored in the log or, if there are none, from a pass over it.

        Args:
            progress: called with the fraction of such a pass that is done, 0 to 1.
        """
        if self._series is None:
            self._series = self._stored_series() or self.gathered_series(progress)
        return self._series

    def result_at(self, frame_index: int) -> FrameResult:
        """The result of one frame.

        Raises:
            IndexError: the log has no such frame.
        """
        series = self.series()
        time_ns = int(series.time_ns[series.row_of(frame_index)])
        for result in self.results(time_ns, time_ns + 1):
            if result.index == frame_index:
                return result
        raise IndexError(f"{self.path}: no frame {frame_index}")

    def _stored_series(self) -> DriveSeries | None:
        """The columns stored in the log; None if there are none that can be read."""
        if not self.complete:
            return None
        with self._open() as file, suppress(*DAMAGED):
            data = stored_attachment(file, mcap.SERIES_NAME)
            return DriveSeries.from_bytes(data) if data is not None else None
        return None

    def gathered_series(self, progress: Callable[[float], None] = lambda part: None) -> DriveSeries:
        """The signals as columns from a pass over the log, even if it has stored ones."""
        gathered, chunks = self._gathered, self.chunks
        with gathered.lock:
            end_ns, pictures_end_ns = chunks.end_ns() or 1, chunks.end_ns(mcap.VIDEO_TOPIC) or 0
            first_chunk, gathered.chunks = gathered.chunks, len(chunks.chunks)
            topics = (mcap.RESULT_TOPIC, mcap.VIDEO_INDEX_TOPIC)
            for topic, message in self._messages(topics, first_chunk=first_chunk):
                if topic == mcap.RESULT_TOPIC:
                    gathered.builder.add(result_from_message(message.data), ())
                    progress(message.log_time / end_ns)
                else:
                    gathered.packets.append((message.log_time, message.data))
            # At the end of a log that is incomplete, or still being written, pictures are missing.
            while gathered.packets and gathered.packets[0][0] <= pictures_end_ns:
                index = drive_pb2.VideoPacket.FromString(gathered.packets.popleft()[1])
                gathered.builder.add_packet(index.time_ns, index.keyframe)
            return gathered.builder.build()

    def grown(self) -> "DriveLog":
        """The same log with what was written meanwhile; only the new part is read.

        Raises:
            UserError: it cannot be read any more.
        """
        log = DriveLog(self.path)
        if not (self.complete or log.complete):
            self.series()
            log._known, log._gathered = self.chunks, self._gathered
        return log

    def _packets(self, start_ns: int | None, end_ns: int | None) -> Iterator[tuple[int, VideoPacket]]:
        """Packets with the index of their frame, from all chunks that overlap the range.

        If pictures are missing in between, those up to the next keyframe cannot be decoded, and are left out.
        """
        index = self._messages((mcap.VIDEO_INDEX_TOPIC,), start_ns, end_ns)
        entry = next(index, None)
        due: int | None = None
        for _, picture in self._messages((mcap.VIDEO_TOPIC,), start_ns, end_ns):
            while entry is not None and entry[1].sequence < picture.sequence:
                entry = next(index, None)
            if entry is None or entry[1].sequence != picture.sequence:
                continue
            about = drive_pb2.VideoPacket.FromString(entry[1].data)
            if due in (None, picture.sequence) or about.keyframe:
                due = picture.sequence + 1
                data = CompressedVideo.FromString(picture.data).data
                yield about.frame_index, VideoPacket(data, about.time_ns, about.keyframe, about.shown)

    def _messages(
        self,
        topics: Sequence[str],
        start_ns: int | None = None,
        end_ns: int | None = None,
        first_chunk: int = 0,
    ) -> Iterator[tuple[str, Message]]:
        """Messages with their topics, in the order of writing, from all chunks in the range."""
        # Log times cannot be negative; earlier packets have log time 0.
        start_ns = max(start_ns or 0, 0)
        end_ns = None if end_ns is None else max(end_ns, 1)
        chunks = self.chunks
        with self._open() as file:
            try:
                yield from chunks.messages(
                    file,
                    topics,
                    start_ns,
                    end_ns,
                    first_chunk=first_chunk,
                    pass_over_damage=not self._strict,
                )
            except DAMAGED as error:
                raise self._damaged(error) from error

    def _open(self) -> BinaryIO:
        try:
            return self.path.open("rb")
        except OSError as error:
            raise self._unreadable(error) from error

    def _unreadable(self, error: OSError) -> UserError:
        return UserError(
            f"{self.path}: cannot read the log ({error.strerror}); expected a drive.mcap of `fcw run`"
        )

    def _damaged(self, error: Exception) -> UserError:
        return UserError(
            f"{self.path}: the log is damaged ({error}); copy it again, or take what can be read: "
            f"{self._recovery}"
        )

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
        except DAMAGED as error:
            if mcap.CALIBRATION_NAME not in attachments:
                what = f"not a drive log, or one cut off at its start ({str(error) or type(error).__name__})"
                if file.seek(0, 2) == 0:
                    what = "an empty file"
                raise UserError(f"{self.path}: {what}; expected a drive.mcap of `fcw run`") from error
        try:
            drive = metadata[mcap.DRIVE_METADATA]
            if drive["format_version"] != mcap.FORMAT_VERSION:
                raise UserError(
                    f"{self.path}: drive log of format version {drive['format_version']}, expected "
                    f"{mcap.FORMAT_VERSION}; run the drive again with this version of fcw"
                )
            calibration = attachments[mcap.CALIBRATION_NAME].decode()
            gpx = attachments.get(mcap.TRACK_NAME, b"")
            versions = metadata[mcap.VERSIONS_METADATA]
            return mcap.drive_header(drive, versions, calibration, str(self.path), gpx)
        except (KeyError, ValueError) as error:
            raise UserError(
                f"{self.path}: an MCAP file, but no drive log of fcw (no {error}); "
                "expected a drive.mcap of `fcw run`"
            ) from error


@dataclass(slots=True)
class _Gathered:
    """Progress of collecting the signals of a log without stored columns; a growing log continues from here.

    Attributes:
        builder: has the frames so far.
        chunks: number of chunks that were read.
        packets: log times and index messages of packets whose pictures have not been written yet.
    """

    builder: SeriesBuilder = field(default_factory=SeriesBuilder)
    chunks: int = 0
    packets: deque[tuple[int, bytes]] = field(default_factory=deque)
    lock: threading.Lock = field(default_factory=threading.Lock)


def _within(time_ns: int, start_ns: int | None, end_ns: int | None) -> bool:
    return (start_ns is None or time_ns >= start_ns) and (end_ns is None or time_ns < end_ns)
