"""Downloads from a drive, and the rerun viewer on a part of it."""

import tempfile
import threading
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from fcw.frame import FALLBACK_RATE_HZ, Frame
from fcw.logs.encode import VideoEncoder
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.replay import replay, with_its_keyframe
from fcw.logs.pictures import LogPictures
from fcw.logs.records import Sink
from fcw.units import NS_PER_S
from fcw_viz.console import SILENT
from fcw_viz.jobs.export import ExportJob, run_export_job
from fcw_viz.rerun.viewer import has_display, native_viewer, web_viewer

AROUND_S = 5.0
"""A clip begins so long before its event, and ends so long after it."""
MOST_VIEWERS = 4
"""Largest number of rerun viewers; the oldest one is ended for another."""


def clip_around(start_s: float, end_s: float, duration_s: float) -> tuple[float, float]:
    """The part of a drive that shows an event."""
    return max(start_s - AROUND_S, 0.0), min(end_s + AROUND_S, duration_s)


def exported_file(log: Path, export_format: str, between: tuple[float, float]) -> bytes:
    """A part of a drive in a format of `fcw export`.

    Raises:
        UserError: the drive cannot be read, or there is no space for the file.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"clip.{export_format}"
        run_export_job(ExportJob((log,), export_format, file, between=between), SILENT)
        return file.read_bytes()


def held_range(log: Path, between: tuple[float, float]) -> tuple[float, float]:
    """The part of a drive in a clip with its packets: it begins at a keyframe at or before the wanted start.

    Raises:
        UserError: the drive cannot be read.
    """
    clip, _ = with_its_keyframe(DriveClip.open(log, between=between))
    return clip.time_s(int(clip.times_ns[0])), clip.time_s(int(clip.times_ns[-1]))


def event_table(log: Path) -> bytes:
    """All events of a drive as CSV.

    Raises:
        UserError: the drive cannot be read, or there is no space for the file.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "events.csv"
        run_export_job(ExportJob((log,), "csv", file, events=True), SILENT)
        return file.read_bytes()


def write_from_its_start(clip: DriveClip, sink: Sink) -> None:
    """Write a clip that begins exactly at its start; it is encoded again if there is no keyframe there."""
    if not with_its_keyframe(clip)[1]:
        replay(clip, sink, lambda: None)
        return
    header, pictures = clip.log.header, LogPictures(clip.log)
    encoder = VideoEncoder(header.image_size, header.frame_rate_hz or FALLBACK_RATE_HZ)
    sink.open(replace(header, relays_video=False))
    try:
        for result in clip.results():
            image = pictures.at(result.index)
            sink.write(result, encoder.encode(Frame(result.index, result.time_ns, image)))
    finally:
        encoder.close()
        pictures.close()
        sink.close()


class RerunViewers:
    """The rerun viewers that were started from the page; they end with it."""

    def __init__(self) -> None:
        self._viewers: list[ExitStack] = []
        self._lock = threading.Lock()

    def open(self, log: Path, between: tuple[float, float], played: tuple[float, float]) -> str | None:
        """Start a viewer on a part of a drive.

        Args:
            log: log of the drive.
            between: the part that it contains; it opens at the start of it.
            played: the part that it plays in a loop.

        Returns:
            Its address for a browser; None if it has its own window.

        Raises:
            UserError: the drive cannot be read, or the viewer does not start.
        """
        from fcw_viz.rerun.log import RerunSink  # it takes a second to load, and few reviews need it

        with ExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            recording = folder / "drive.rrd"
            clip = DriveClip.open(log, between=between)
            start_ns, end_ns = (clip.first_ns + round(time_s * NS_PER_S) for time_s in played)
            write_from_its_start(clip, RerunSink(recording, (start_ns, end_ns)))
            make = native_viewer if has_display() else web_viewer
            viewer = stack.enter_context(make(recording))
            with self._lock:
                self._viewers.append(stack.pop_all())
                ended = self._viewers[:-MOST_VIEWERS]
                self._viewers = self._viewers[-MOST_VIEWERS:]
        for old in ended:
            old.close()
        return viewer.url

    def close(self) -> None:
        """End all viewers."""
        with self._lock:
            ended, self._viewers = self._viewers, []
        for viewer in ended:
            viewer.close()
