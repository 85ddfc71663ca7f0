"""The drive log for the rerun viewer: `drive.rrd`, with everything the MCAP log holds.

Frames are kept back and sent a batch at a time, column by column: that costs a fraction of logging frame
by frame, in time and in bytes. Two time lines: `drive_time` is the source's own clock in nanoseconds,
`frame` the index among the shown frames. Video packets that only feed the decoder are logged at their
`drive_time` with `shown` false, and have no `frame`.

While a drive is being written its file is called `<name>.partial.rrd`, which the viewer opens as well; it
takes its final name once it is complete. A process that is killed leaves the partial file with all but
the last batches; `rerun rrd optimize` gives such a file its missing footer.
"""

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import rerun as rr
from rerun.chunk import RrdReader

import fcw_viz.rerun_blueprint as scene
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources.frame import VideoPacket
from fcw.warning.types import WarningLevel
from fcw_viz.rerun_columns import (
    Columns,
    level_columns,
    log_columns,
    result_columns,
    time_columns,
    video_columns,
)
from fcw_viz.rerun_scene import log_static_scene

FRAMES_PER_BATCH = 64
"""About two seconds: what a killed run loses, against the 25 kB that each batch costs."""


class RerunSink:
    """Writes a drive as a rerun recording with its blueprint; an `fcw.logs.records.Sink`.

    Args:
        path: the `.rrd` file; one that exists is replaced when the drive is complete.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._partial_path = path.with_suffix(".partial.rrd")
        self._recording: rr.RecordingStream | None = None
        self._results: list[FrameResult] = []
        self._packets: list[tuple[VideoPacket, int]] = []
        self._last_level: WarningLevel | None = None

    def open(self, header: DriveHeader) -> None:
        """Start the file with all that stays the same during the drive."""
        self._header = header
        self._recording = rr.RecordingStream("fcw")
        self._recording.save(self._partial_path, default_blueprint=scene.drive_blueprint(header.imperial))
        log_static_scene(self._recording, header)

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Add a frame; it reaches the file with its batch."""
        self._results.append(result)
        self._packets.extend((packet, result.index) for packet in packets)
        if len(self._results) == FRAMES_PER_BATCH:
            self._send()

    def close(self) -> None:
        """Write what was kept back and give the file its name; a second call does nothing."""
        if self._recording is None:
            return
        if self._results:
            self._send()
        self._recording.disconnect()
        self._recording = None
        self._partial_path.replace(self._path)

    def _send(self) -> None:
        results, packets = self._results, self._packets
        self._results, self._packets = [], []
        self._send_video([packet for packet, _ in packets if not packet.shown], None)
        shown = [(packet, index) for packet, index in packets if packet.shown]
        self._send_video([packet for packet, _ in shown], [index for _, index in shown])
        times = _times(results)
        for path, columns in result_columns(results, self._header):
            self._send_columns(path, times, columns)
        self._send_level_changes(results)

    def _send_video(self, packets: Sequence[VideoPacket], indexes: Sequence[int] | None) -> None:
        if packets:
            times = time_columns([packet.time_ns for packet in packets], indexes)
            self._send_columns(scene.VIDEO, times, video_columns(packets))

    def _send_level_changes(self, results: Sequence[FrameResult]) -> None:
        """The level where it changes and, but for a quiet beginning, the reason in words."""
        changes: list[FrameResult] = []
        told: list[FrameResult] = []
        for result in results:
            level = result.warning.level
            if level != self._last_level:
                changes.append(result)
                if level != WarningLevel.NONE or self._last_level is not None:
                    told.append(result)
            self._last_level = level
        if changes:
            self._send_columns(scene.LEVEL, _times(changes), level_columns(changes))
        if told:
            self._send_columns(scene.LOG, _times(told), log_columns(told, self._header.imperial))

    def _send_columns(self, path: str, times: list[rr.TimeColumn], columns: Columns) -> None:
        assert self._recording is not None
        self._recording.send_columns(path, times, columns, strict=True)


def read_frame_times(path: Path) -> list[tuple[int, int]]:
    """Index and time of every shown frame of a recording, also of one that was cut short.

    Args:
        path: an `.rrd` file of `RerunSink`.

    Returns:
        (index, time_ns) of each row in the file's order, the time on the source's clock.
    """
    times: list[tuple[int, int]] = []
    for chunk in RrdReader(path).stream().filter(content=f"/{scene.FRAMES}"):
        rows = chunk.to_record_batch()
        indexes = rows.column(scene.FRAME_TIMELINE).cast(pa.int64()).to_pylist()
        times_ns = rows.column(scene.TIME_TIMELINE).cast(pa.int64()).to_pylist()
        times += zip(indexes, times_ns, strict=True)
    return times


def _times(results: Sequence[FrameResult]) -> list[rr.TimeColumn]:
    return time_columns([result.time_ns for result in results], [result.index for result in results])
