"""The drive log for the rerun viewer: `drive.rrd`, with what the MCAP log holds of the pictures and vehicles.

Frames are kept back and sent a batch at a time, column by column: that costs a fraction of logging frame
by frame, in time and in bytes. Two time lines: `drive_time` is the source's own clock in nanoseconds (day and
hour where it counts from 1970), `frame` the index among the shown frames. Video packets that only feed the
decoder are logged at their `drive_time` with `shown` false, and have no `frame`.

While a drive is being written its file is called `<name>.partial.rrd`, which the viewer opens as well; it
takes its final name once it is complete. A process that is killed leaves the partial file with all but
the last batches; `rerun rrd optimize` gives such a file its missing footer.
"""

import atexit
import ctypes
import os
import threading
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import rerun as rr
import rerun_bindings

import fcw_viz.rerun.blueprint as scene
from fcw.errors import UserError
from fcw.files import not_written
from fcw.frame import VideoPacket
from fcw.logs.overlay import pitch_now
from fcw.logs.records import DriveHeader, FrameResult
from fcw.warning.types import WarningLevel
from fcw_viz.rerun.columns import (
    Columns,
    is_calendar_time,
    level_columns,
    log_columns,
    result_columns,
    time_columns,
    video_columns,
)
from fcw_viz.rerun.scene import log_static_scene, look_columns

FRAMES_PER_BATCH = 128
"""About four seconds: what a killed run loses of this file, against the 16 kB that each batch costs. The MCAP
log, from which this file can be made again, loses half a second."""
WRITE_TIMEOUT_S = 20.0
"""Far longer than a batch takes. Without a limit rerun may wait for ever for a writer that has failed."""
FOOTER_MAGIC = b"RRF2FOOT"
FOOTER_SEARCH_BYTES = 32
"""The magic stands 12 bytes before the end of a complete file."""
UNWRITTEN = "the recording could not be written whole"
MOVED = "something removed or moved it during the run: run again, into a folder that nothing else writes to"
_writer_has_failed = threading.Event()


class RerunSink:
    """Writes a drive as a rerun recording with its blueprint; an `fcw.logs.records.Sink`.

    Args:
        path: the `.rrd` file; one that exists is replaced when the drive is complete.
        played_ns: see `drive_blueprint`.
    """

    def __init__(self, path: Path, played_ns: tuple[int, int] | None = None) -> None:
        self._path, self._played_ns = path, played_ns
        self._partial_path = path.with_suffix(".partial.rrd")
        self._recording: rr.RecordingStream | None = None
        self._results: list[FrameResult] = []
        self._packets: list[tuple[VideoPacket, int]] = []
        self._last_level: WarningLevel | None = None
        self._last_pitch_rad: float | None = None
        self._failed = False
        self._calendar = False

    def open(self, header: DriveHeader) -> None:
        """Start the file with all that stays the same during the drive.

        Raises:
            UserError: the file cannot be written there.
        """
        self._header = header
        recording = rr.RecordingStream("fcw")
        try:
            blueprint = scene.drive_blueprint(header.imperial, self._played_ns)
            recording.save(self._partial_path, default_blueprint=blueprint)
            blueprint.end()
        except (RuntimeError, UnicodeEncodeError) as error:  # rerun takes names of files in UTF-8 alone
            raise UserError(
                f"{self._path}: cannot write the recording ({error}); "
                "name a folder that exists and can be written"
            ) from error
        self._recording = recording
        log_static_scene(recording, header)
        self._flush()

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Add a frame; it reaches the file with its batch.

        Raises:
            UserError: the file cannot be written any further.
        """
        if self._last_level is None and not self._results:
            self._calendar = is_calendar_time(result.time_ns)
        self._results.append(result)
        self._packets.extend((packet, result.index) for packet in packets)
        if len(self._results) == FRAMES_PER_BATCH:
            self._send()

    def close(self) -> None:
        """Write what was kept back and give the file its name; a second call does nothing.

        Raises:
            UserError: the file could not be written to its end; it keeps its partial name.
        """
        if self._recording is None:
            return
        try:
            if not self._failed:
                if self._results:
                    self._send()
                self._disconnect(self._recording)
        finally:
            self._recording = None
            _end_threads()
        try:
            if self._failed or not _has_footer(self._partial_path):
                raise self._unwritten("its end is missing")
            self._partial_path.replace(self._path)
        except OSError as error:
            raise not_written(f"{self._path}: {UNWRITTEN}", error, MOVED) from error

    def _send(self) -> None:
        results, packets = self._results, self._packets
        self._results, self._packets = [], []
        self._send_video(packets)
        times = self._times(results)
        for path, columns in result_columns(results, self._header):
            self._send_columns(path, times, columns)
        self._send_level_changes(results)
        self._send_looks(results)
        self._flush()

    def _send_video(self, packets: Sequence[tuple[VideoPacket, int]]) -> None:
        """Packets with their frame's index, in runs: only shown ones have a place among the frames."""
        for shown, group in groupby(packets, key=lambda pair: pair[0].shown):
            run, indexes = zip(*group, strict=True)
            times = time_columns(
                [packet.time_ns for packet in run], indexes if shown else None, self._calendar
            )
            self._send_columns(scene.VIDEO, times, video_columns(run))

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
            self._send_columns(scene.LEVEL, self._times(changes), level_columns(changes))
        if told:
            self._send_columns(scene.LOG, self._times(told), log_columns(told, self._header.imperial))

    def _send_looks(self, results: Sequence[FrameResult]) -> None:
        """Where the camera looks, when that is news."""
        news: list[FrameResult] = []
        pitches_rad: list[float] = []
        for result in results:
            pitch_rad = pitch_now(self._header.calibration, result)
            if pitch_rad != self._last_pitch_rad:
                news.append(result)
                pitches_rad.append(pitch_rad)
            self._last_pitch_rad = pitch_rad
        if news:
            for path, columns in look_columns(pitches_rad, self._header):
                self._send_columns(path, self._times(news), columns)

    def _times(self, results: Sequence[FrameResult]) -> list[rr.TimeColumn]:
        return time_columns(
            [result.time_ns for result in results], [result.index for result in results], self._calendar
        )

    def _flush(self) -> None:
        """Wait for the file: rerun tells of a failed write here and nowhere else."""
        assert self._recording is not None
        try:
            self._recording.flush(timeout_sec=WRITE_TIMEOUT_S)
        except (RuntimeError, TimeoutError) as error:
            self._failed = True
            _abandon(self._recording)
            raise self._unwritten(str(error)) from error

    def _disconnect(self, recording: rr.RecordingStream) -> None:
        """Have the file finished; where the writer fails at that, rerun would not come back."""
        finishing = threading.Thread(target=recording.disconnect, name="finish rrd", daemon=True)
        finishing.start()
        finishing.join(WRITE_TIMEOUT_S)
        if finishing.is_alive():
            self._failed = True
            _abandon(recording)

    def _unwritten(self, reason: str) -> UserError:
        """Of rerun's own writer, which does not say what the system refused."""
        return UserError(
            f"{self._path}: {UNWRITTEN} ({reason}); make room on the disk, or allow larger files "
            "(ulimit -f), and run again"
        )

    def _send_columns(self, path: str, times: list[rr.TimeColumn], columns: Columns) -> None:
        assert self._recording is not None
        self._recording.send_columns(path, times, columns, strict=True)


def _abandon(recording: rr.RecordingStream) -> None:
    """Never touch a recording again whose writer has failed.

    rerun 0.41 waits for ever for that writer when the recording is disconnected, when it is freed, and in its
    clean-up at the end of the process: so it is never freed, and there is no clean-up.
    """
    _writer_has_failed.set()
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(recording.inner))
    atexit.unregister(rr.rerun_shutdown)


def _end_threads() -> None:
    """Those of all recordings that are closed. rerun 0.41 else keeps two for each until the process ends
    (https://github.com/rerun-io/rerun/issues/2116)."""
    if not _writer_has_failed.is_set():  # it would wait for that writer for ever
        rerun_bindings.flush_and_cleanup_orphaned_recordings()


def _has_footer(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-min(FOOTER_SEARCH_BYTES, path.stat().st_size), os.SEEK_END)
        return FOOTER_MAGIC in file.read()
