"""`fcw export`: drive logs in the formats of others."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

ExportFormat = Literal["csv", "parquet", "kitti", "mot", "coco", "mp4", "rrd", "mcap"]


@dataclass(frozen=True, slots=True)
class ExportCommand:
    """Write drive logs as tables, tracks, boxes, a video with the overlay, or a clip of a time range."""

    drives: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="DRIVE ...")]
    """Drive logs (drive.mcap), folders that hold one, or folders of such folders."""
    format: ExportFormat
    """csv, parquet: a row for each track and frame. kitti, mot: tracks. coco: boxes. mp4: video with overlay.
    rrd: for the rerun viewer. mcap: a separate drive log. docs/export.md describes each."""
    out: Annotated[Path, tyro.conf.arg(metavar="PATH")]
    """File to write, or a folder with one file for each drive, created if needed. csv, parquet and coco put
    all drives into one file."""
    events: bool = False
    """csv, parquet: one table of events (warnings, near misses) instead of tracks."""
    between: Annotated[tuple[float, float] | None, tyro.conf.arg(metavar="S S")] = None
    """Only this range of time, in seconds from the drive's first frame, both ends included."""
    no_overlay: bool = False
    """mp4: the original video without the overlay, copied without loss."""
    pictures: bool = False
    """coco: also write images/ and calibration/ beside the labels, as `fcw train --data` expects them."""
    annotations: bool = False
    """coco: only frames that people labelled in `fcw review`, with the boxes as they corrected them, and with
    their pictures: a folder for `fcw train --data` and `fcw evaluate detection`."""
    every: Annotated[int, tyro.conf.arg(metavar="N")] = 1
    """coco: only every Nth frame of the drive."""
    overwrite: bool = False
    """Replace existing files."""


def run_export(command: ExportCommand) -> int:
    """Run `fcw export`; returns the exit code."""
    from fcw_viz.console import MESSAGES, RESULTS
    from fcw_viz.console_text import one_line
    from fcw_viz.jobs.export import ExportJob, run_export_job

    job = ExportJob(
        drives=command.drives,
        format=command.format,
        out=command.out,
        events=command.events,
        between=command.between,
        overlay=not command.no_overlay,
        pictures=command.pictures or command.annotations,
        annotations=command.annotations,
        every=command.every,
        overwrite=command.overwrite,
    )
    for line in run_export_job(job, MESSAGES):
        RESULTS.print(one_line(line), soft_wrap=True, markup=False)
    return 0
