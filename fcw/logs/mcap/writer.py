"""Writes the drive log as MCAP, for Foxglove, for this program's own review, and for any other reader."""

import errno
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from fcw.camera.file import calibration_text
from fcw.errors import UserError
from fcw.files import not_written
from fcw.frame import VideoPacket
from fcw.logs.disk_sync import DiskSync
from fcw.logs.mcap import format as mcap
from fcw.logs.mcap import foxglove_messages as foxglove
from fcw.logs.mcap.messages import no_track_message, result_message, track_message, warning_message
from fcw.logs.overlay import overlay_rows, pitch_now
from fcw.logs.records import DriveHeader, FrameResult
from fcw.logs.schemas import drive_pb2
from fcw.logs.series import SeriesBuilder
from fcw.versions import __version__
from fcw.warning.types import WarningLevel

_TOPICS: dict[str, type[Message]] = {
    mcap.VIDEO_TOPIC: CompressedVideo,
    mcap.VIDEO_INDEX_TOPIC: drive_pb2.VideoPacket,
    mcap.RESULT_TOPIC: drive_pb2.FrameResult,
    mcap.LEAD_TOPIC: drive_pb2.Track,
    mcap.WARNING_TOPIC: drive_pb2.WarningState,
    mcap.CALIBRATION_TOPIC: CameraCalibration,
    mcap.ANNOTATIONS_TOPIC: ImageAnnotations,
    mcap.SCENE_TOPIC: SceneUpdate,
    mcap.TRANSFORMS_TOPIC: FrameTransforms,
    mcap.LOG_TOPIC: Log,
}


@dataclass(frozen=True, slots=True)
class _Picture:
    log_ns: int
    data: bytes


class McapSink:
    """Writes a drive as MCAP; an `fcw.logs.records.Sink`. For the layout see `fcw.logs.mcap.format`.

    The file is written in place and has no footer before `close`. So an unfinished log can be recognised, and
    read up to its end. mcap's writer has only one open chunk, which takes the signals. Pictures are buffered
    here and written as a chunk of their own.
    """

    def __init__(self, path: Path) -> None:
        """The log is written to `path`; an existing file is replaced when the log is opened."""
        self._path = path
        self._file: BufferedWriter | None = None

    def open(self, header: DriveHeader) -> None:
        """Start the file with everything that is known before the first frame.

        Raises:
            UserError: the file cannot be written there, or not whole.
        """
        try:
            self._file = self._path.open("wb")
        except OSError as error:
            raise not_written(f"{self._path}: cannot write the log", error) from error
        with self._telling():
            self._begin(self._file, header)

    def _begin(self, file: BufferedWriter, header: DriveHeader) -> None:
        self._header = header
        self._pitch_rad: float | None = None
        self._last_ns: int | None = None
        self._level = WarningLevel.NONE
        self._had_lead = False
        self._signals_ns: int | None = None
        self._pictures: list[_Picture] = []
        self._sequences: defaultdict[str, int] = defaultdict(int)
        self._series = SeriesBuilder()
        self._disk = DiskSync(file)
        self._writer = Writer(file, chunk_size=mcap.CHUNK_BYTES)
        self._writer.start(library=f"fcw {__version__}")
        self._writer.add_metadata(mcap.DRIVE_METADATA, mcap.drive_metadata(header))
        self._writer.add_metadata(mcap.VERSIONS_METADATA, dict(header.versions))
        calibration = calibration_text(header.calibration).encode()
        self._writer.add_attachment(0, 0, mcap.CALIBRATION_NAME, "application/yaml", calibration)
        if header.gpx:
            self._writer.add_attachment(0, 0, mcap.TRACK_NAME, "application/gpx+xml", header.gpx)
        self._channels = {
            topic: self._writer.register_channel(topic, "protobuf", register_schema(self._writer, message))
            for topic, message in _TOPICS.items()
        }
        file.flush()

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Add a frame; indices and times must increase.

        It is passed to the operating system within `SIGNALS_CHUNK_NS` of the drive's time, and its pictures
        within `PICTURES_CHUNK_NS`.

        Raises:
            UserError: the file cannot be written any further.
        """
        with self._telling():
            if not self._sequences:
                self._add_camera(result, min([result.time_ns, *(packet.time_ns for packet in packets)]))
            if any(packet.keyframe for packet in packets):
                self._end_pictures()
            for packet in packets:
                self._add_packet(packet, result.index)
            self._add_signals(result)
            self._series.add(result, packets)
            log_ns = max(result.time_ns, 0)
            gap_ns = 0 if self._last_ns is None else log_ns - self._last_ns
            self._last_ns = log_ns
            end_ns = log_ns + 2 * gap_ns  # end of the next frame, which must still fit into the chunk
            if self._pictures and end_ns - self._pictures[0].log_ns > mcap.PICTURES_CHUNK_NS:
                self._end_pictures()
            elif self._signals_ns is not None and end_ns - self._signals_ns > mcap.SIGNALS_CHUNK_NS:
                self._end_signals()

    def close(self) -> None:
        """Finish the file; a second call does nothing.

        Raises:
            UserError: the file could not be written to its end.
        """
        if self._file is None:
            return
        file, self._file = self._file, None
        with self._telling(), file, self._disk:
            self._end_pictures()
            series = self._series.build().to_bytes()
            self._writer.add_attachment(0, 0, mcap.SERIES_NAME, mcap.SERIES_MEDIA_TYPE, series)
            self._writer.finish()

    @contextmanager
    def _telling(self) -> Iterator[None]:
        """Turn an error while writing into a message for the user."""
        try:
            yield
        except OSError as error:
            too_large = error.errno == errno.EFBIG
            mend = "allow larger files (ulimit -f)" if too_large else "make room on the disk"
            raise UserError(
                f"{self._path}: the log could not be written whole ({error.strerror}); {mend} and run again; "
                "what was written before can be read"
            ) from error

    def _end_signals(self) -> None:
        self._writer.flush()
        self._signals_ns = None
        self._disk.sync()

    def _end_pictures(self) -> None:
        """Write the buffered pictures as a chunk; this also ends the chunk of signals."""
        self._writer.flush()
        for picture in self._pictures:
            self._add(mcap.VIDEO_TOPIC, picture.log_ns, picture.data)
        self._pictures.clear()
        self._end_signals()

    def _add_camera(self, result: FrameResult, start_ns: int) -> None:
        log_ns = max(start_ns, 0)
        message = foxglove.calibration_message(self._header.calibration, foxglove.timestamp(log_ns))
        self._signal(mcap.CALIBRATION_TOPIC, log_ns, message)
        self._add_pitch(result, log_ns)

    def _add_pitch(self, result: FrameResult, log_ns: int) -> None:
        """Write the camera's transform if its pitch has changed; the rows of the distances change with it."""
        header = self._header
        pitch_rad = pitch_now(header.calibration, result)
        if pitch_rad == self._pitch_rad:
            return
        self._pitch_rad = pitch_rad
        self._rows = overlay_rows(header.calibration, header.imperial, pitch_rad)
        message = foxglove.transforms_message(header.calibration, pitch_rad, foxglove.timestamp(log_ns))
        self._signal(mcap.TRANSFORMS_TOPIC, log_ns, message)

    def _add_signals(self, result: FrameResult) -> None:
        header, log_ns = self._header, max(result.time_ns, 0)
        self._add_pitch(result, log_ns)
        stamp = foxglove.timestamp(log_ns)
        annotations = foxglove.annotations_message(
            result, self._rows, header.image_size, header.imperial, stamp
        )
        self._signal(mcap.ANNOTATIONS_TOPIC, log_ns, annotations)
        scene = foxglove.scene_message(result, header.calibration, header.imperial, stamp)
        self._signal(mcap.SCENE_TOPIC, log_ns, scene)
        if result.warning.level != self._level:
            self._level = result.warning.level
            self._signal(mcap.LOG_TOPIC, log_ns, foxglove.log_message(result, header.imperial, stamp))
        lead = result.lead
        if lead is not None or self._had_lead:
            self._signal(mcap.LEAD_TOPIC, log_ns, no_track_message() if lead is None else track_message(lead))
        self._had_lead = lead is not None
        self._signal(mcap.WARNING_TOPIC, log_ns, warning_message(result.warning))
        self._signal(mcap.RESULT_TOPIC, log_ns, result_message(result))

    def _add_packet(self, packet: VideoPacket, frame_index: int) -> None:
        log_ns = max(packet.time_ns, 0)
        index = drive_pb2.VideoPacket(
            time_ns=packet.time_ns, keyframe=packet.keyframe, shown=packet.shown, frame_index=frame_index
        )
        self._signal(mcap.VIDEO_INDEX_TOPIC, log_ns, index)
        video = foxglove.video_message(packet.data, foxglove.timestamp(log_ns))
        self._pictures.append(_Picture(log_ns, video.SerializeToString()))

    def _signal(self, topic: str, log_ns: int, message: Message) -> None:
        if self._signals_ns is None:
            self._signals_ns = log_ns
        self._add(topic, log_ns, message.SerializeToString())

    def _add(self, topic: str, log_ns: int, data: bytes) -> None:
        self._writer.add_message(self._channels[topic], log_ns, data, log_ns, self._sequences[topic])
        self._sequences[topic] += 1
