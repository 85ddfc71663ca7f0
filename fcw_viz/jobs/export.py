"""Exporting drive logs: what goes where, with a progress bar."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from fcw.annotation.frame_labels import labelled_frames, labelled_indices
from fcw.annotation.review import Review
from fcw.annotation.store import read_review
from fcw.errors import UserError
from fcw.files import make_folder, not_written
from fcw.logs.events import find_events
from fcw.logs.export.clip import Between, DriveClip, check_between, find_drives
from fcw.logs.export.coco import CALIBRATIONS_NAME, PICTURES_NAME, FrameBoxes, track_frames, write_coco
from fcw.logs.export.columns import EVENT_COLUMNS, TRACK_COLUMNS, EventRow, TrackRow, track_rows
from fcw.logs.export.mp4 import write_overlay_mp4, write_relayed_mp4
from fcw.logs.export.replay import replay, with_its_keyframe
from fcw.logs.export.table import write_csv, write_parquet
from fcw.logs.export.tracks import write_kitti, write_mot
from fcw.logs.mcap.writer import McapSink
from fcw.logs.names import recovered_log
from fcw.logs.records import Sink
from fcw_viz.console import note, progress
from fcw_viz.console_text import counted
from fcw_viz.overlay import OverlayPainter

SUFFIXES = {
    "csv": ".csv",
    "parquet": ".parquet",
    "kitti": ".txt",
    "mot": ".txt",
    "coco": ".json",
    "mp4": ".mp4",
    "rrd": ".rrd",
    "mcap": ".mcap",
}
TABLES = {"csv": write_csv, "parquet": write_parquet}
GATHERED = {"csv": "tracks", "parquet": "tracks", "coco": "labels"}
"""Formats that hold several drives, and what their file is called in a folder."""
EVENTS_NAME = "events"


@dataclass(frozen=True, slots=True)
class ExportJob:
    """What to export and how; `fcw_viz.commands.export.ExportCommand` says what each field means."""

    drives: tuple[Path, ...]
    format: str
    out: Path
    events: bool = False
    between: Between | None = None
    overlay: bool = True
    pictures: bool = False
    annotations: bool = False
    every: int = 1
    overwrite: bool = False


def run_export_job(job: ExportJob, console: Console) -> list[str]:
    """Export, each file whole or not at all.

    Args:
        job: what to export.
        console: for notes, and for the progress bar where it is a terminal.

    Returns:
        What was written, a line a file.

    Raises:
        UserError: the job makes no sense, a drive cannot be read, or a file cannot be written.
    """
    _check(job)
    drives = find_drives(job.drives)
    tell = partial(note, console=console)
    clips = _clips(job, drives, tell)
    reviews = _labelled(clips, tell, job.between is not None) if job.annotations else None
    if reviews is not None:
        clips = [clip for clip in clips if clip.name in reviews]
    targets = _targets(job, [clip.name for clip in clips])
    _check_targets(job, targets, clips, drives)
    frames = sum(
        len(clip.times_ns) if reviews is None else len(labelled_indices(clip, reviews[clip.name]))
        for clip in clips
    )
    with progress(f"{job.format} of {counted(len(clips), 'drive')}", frames, console) as bar:
        if job.events:
            return [_write_events(job, targets[0], clips)]
        if job.format in GATHERED:
            return [_write_gathered(job, targets[0], clips, reviews, bar.advance)]
        return [
            _write_one(job, target, clip, bar.advance, tell)
            for target, clip in zip(targets, clips, strict=True)
        ]


def _check(job: ExportJob) -> None:
    if not job.drives:
        raise UserError("fcw export: no drive given; name a drive.mcap of `fcw run`, or its folder")
    if job.between is not None:
        check_between(job.between)
    if job.events and job.format not in TABLES:
        raise UserError(f"--events --format {job.format}: events are a table; choose csv or parquet")
    if not job.overlay and job.format != "mp4":
        raise UserError(f"--no-overlay --format {job.format}: only an mp4 has the overlay; leave it out")
    if (job.pictures or job.every != 1) and job.format != "coco":
        given = {"--annotations": job.annotations, "--pictures": job.pictures, f"--every {job.every}": True}
        option = next(option for option, is_given in given.items() if is_given)
        raise UserError(f"{option} --format {job.format}: only for coco; leave it out")
    if job.annotations and job.every != 1:
        raise UserError(f"--every {job.every} --annotations: people chose the frames; leave out --every")
    suffix = job.out.suffix.lower()
    others = [name for name, one in SUFFIXES.items() if one == suffix]
    if others and job.format not in others and not job.out.is_dir():
        raise UserError(
            f"--out {job.out} --format {job.format}: {suffix} is for {' and '.join(others)}; expected a "
            f"folder or {SUFFIXES[job.format]}"
        )
    if job.every < 1:
        raise UserError(f"--every {job.every}: expected a whole number of at least 1")


def _clips(job: ExportJob, drives: dict[str, Path], note: Callable[[str], None]) -> list[DriveClip]:
    """The drives' clips; of several drives those that have nothing to export are named and left out."""
    clips: list[DriveClip] = []
    errors: list[UserError] = []
    for name, path in drives.items():
        try:
            clip = DriveClip.open(path, name, job.between)
        except UserError as error:
            errors.append(error)
            continue
        clips.append(clip)
        if not clip.log.complete:
            recovered = recovered_log(path)
            note(
                f"{path}: the run that wrote it was stopped early: exported up to the damage, at "
                f"{clip.log.series().duration_s:.1f} s; "
                + (
                    "`fcw recover` repairs the log"
                    if recovered is None
                    else f"{recovered} is the repaired log"
                )
            )
    if not clips:
        raise errors[0]
    for error in errors:
        note(f"left out: {error}")
    return clips


def _labelled(clips: Sequence[DriveClip], note: Callable[[str], None], cut: bool) -> dict[str, Review]:
    """The reviews of the clips of which somebody labelled a frame, by name; the others are counted."""
    reviews: dict[str, Review] = {}
    frame = "frame in that time" if cut else "frame"
    for clip in clips:
        review, troubles = read_review(clip.log)
        for trouble in troubles:
            note(trouble)
        if labelled_indices(clip, review):
            reviews[clip.name] = review
    if not reviews:
        drives = str(clips[0].log.path) if len(clips) == 1 else f"these {len(clips)} drives"
        raise UserError(
            f"--annotations: {drives}: no labelled {frame}; "
            "correct boxes, or say that they are right, in `fcw review`"
        )
    if without := len(clips) - len(reviews):
        has = "has" if without == 1 else "have"
        note(f"{without} of {counted(len(clips), 'drive')} {has} no labelled {frame}, left out")
    return reviews


def _targets(job: ExportJob, names: Sequence[str]) -> list[Path]:
    """The files to write: one for all drives, or one for each."""
    suffix = SUFFIXES[job.format]
    is_folder = job.out.is_dir() or not job.out.suffix
    if job.events or job.format in GATHERED:
        name = EVENTS_NAME if job.events else GATHERED[job.format]
        targets = [job.out / f"{name}{suffix}" if is_folder else job.out]
    elif is_folder:
        targets = [job.out / f"{name}{suffix}" for name in names]
    elif len(names) == 1:
        targets = [job.out]
    else:
        raise UserError(f"--out {job.out}: {len(names)} drives need one file each; give a folder")
    if is_folder:
        make_folder(job.out)
    return targets


def _check_targets(
    job: ExportJob, targets: Sequence[Path], clips: Sequence[DriveClip], drives: dict[str, Path]
) -> None:
    for target in targets:
        if target.resolve() in drives.values():
            raise UserError(f"--out {target}: this is the drive itself; choose another file")
        if any(_is_source(target, clip) for clip in clips):
            raise UserError(
                f"--out {target}: it has the name of the drive's source, and is older than the drive; "
                "choose another name"
            )
    if job.overwrite:
        return
    written = (f"{PICTURES_NAME}/{{}}", f"{CALIBRATIONS_NAME}/{{}}.yaml") if job.pictures else ()
    beside = [targets[0].parent / name.format(clip.name) for clip in clips for name in written]
    for target in (*targets, *beside):
        if target.exists():
            raise UserError(f"{target}: exists already; choose another name, or replace it with --overwrite")


def _is_source(target: Path, clip: DriveClip) -> bool:
    """Whether a file may be what a drive was made from: its log knows the name alone; an export is newer."""
    log = clip.log
    if target.name != log.header.source or not target.is_file():
        return False
    return target.stat().st_mtime <= log.path.stat().st_mtime


def _write_events(job: ExportJob, target: Path, clips: Sequence[DriveClip]) -> str:
    start_s, end_s = job.between or (0.0, float("inf"))
    rows = [
        EventRow(clip.name, event)
        for clip in clips
        for event in find_events(clip.log.series())
        if event.start_s <= end_s and event.end_s >= start_s
    ]
    count = TABLES[job.format](target, EVENT_COLUMNS, rows)
    return f"{target}: {counted(count, 'event')} of {counted(len(clips), 'drive')}"


def _write_gathered(
    job: ExportJob,
    target: Path,
    clips: Sequence[DriveClip],
    reviews: Mapping[str, Review] | None,
    on_frame: Callable[[], None],
) -> str:
    if job.format == "coco":

        def frames_of(clip: DriveClip) -> Iterator[FrameBoxes]:
            if reviews is None:
                return track_frames(clip, on_frame, job.every)
            return labelled_frames(clip, reviews[clip.name], on_frame)

        count = write_coco(target, clips, frames_of, with_pictures=job.pictures)
        return f"{target}: {counted(count, 'box', 'boxes')} of {counted(len(clips), 'drive')}"
    empty = 0

    def rows() -> Iterator[TrackRow]:
        nonlocal empty
        for row in track_rows(clips, on_frame):
            empty += row.track is None
            yield row

    count = TABLES[job.format](target, TRACK_COLUMNS, rows())
    boxes = counted(count - empty, "box", "boxes")
    frames = f" and {counted(empty, 'frame')} without one" if empty else ""
    return f"{target}: {counted(count, 'row')} of {counted(len(clips), 'drive')}, {boxes}{frames}"


def _write_one(
    job: ExportJob,
    target: Path,
    clip: DriveClip,
    on_frame: Callable[[], None],
    note: Callable[[str], None],
) -> str:
    if job.format == "kitti":
        return f"{target}: {counted(write_kitti(target, clip, on_frame), 'box', 'boxes')}"
    if job.format == "mot":
        return f"{target}: {counted(write_mot(target, clip, on_frame), 'box', 'boxes')}"
    if job.format == "mp4" and job.overlay:
        painter = OverlayPainter(clip.log.header, clip.first_ns)
        count = write_overlay_mp4(target, clip, painter.paint, on_frame)
        if count < len(clip.times_ns):
            lost = counted(len(clip.times_ns) - count, "frame")
            note(
                f"{clip.log.path}: the pictures of the last {lost} were lost when the run that wrote it was "
                "stopped"
            )
        return f"{target}: {counted(count, 'picture')}"
    clip, earlier_s = with_its_keyframe(clip)
    if earlier_s:
        note(f"{target}: starts {earlier_s:.2f} s earlier, at the keyframe that its pictures need")
    if job.format == "mp4":
        return f"{target}: {counted(write_relayed_mp4(target, clip, on_frame), 'picture')}"
    return f"{target}: {counted(_write_log(job, target, clip, on_frame), 'frame')}"


def _write_log(job: ExportJob, target: Path, clip: DriveClip, on_frame: Callable[[], None]) -> int:
    """A log by a sink, which leaves what it has where it fails: in a folder that goes away."""
    make: Callable[[Path], Sink] = McapSink
    if job.format == "rrd":
        from fcw_viz.rerun.log import RerunSink  # it takes a second to load, and other formats need it not

        make = RerunSink
    try:
        with TemporaryDirectory(prefix=".fcw-export-", dir=target.parent) as folder:
            written = Path(folder) / target.name
            try:
                count = replay(clip, make(written), on_frame)
            except UserError as error:
                if folder not in str(error):  # it is about the drive
                    raise
                raise UserError(
                    f"{target}: cannot be written completely; make room on the disk, or choose another place"
                ) from error
            written.replace(target)
    except OSError as error:
        raise not_written(f"{target}: cannot write this file", error) from error
    return count
