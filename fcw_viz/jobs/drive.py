"""A drive's job on the console, as `fcw run` and `fcw demo` do it: with the rerun log, a bar and Ctrl-C."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from types import FrameType

from rich.console import Console

from fcw.frame import Source, VideoLike
from fcw.job import DriveJob, DriveOutcome, PreparedDrive, prepare_drive
from fcw.logs.names import MCAP_NAME, RRD_NAME
from fcw.logs.records import FrameResult, Sink
from fcw_viz.console import MESSAGES, progress
from fcw_viz.rerun.log import RerunSink
from fcw_viz.signals import Interrupted, handled

STARTING = "starting (compiles once)"
"""The first time kernels are compiled, which takes up to two minutes; in words that fit beside a bar."""
MUCH_LARGER = 2.0
"""So many times the size of its video a log is said to be large."""


def run_on_console(
    job: DriveJob,
    console: Console = MESSAGES,
    source: Source | None = None,
    watchers: Sequence[Sink] = (),
    stop: threading.Event | None = None,
    rerun_log: bool = True,
) -> DriveOutcome:
    """Run a job with a progress bar on `console`; Ctrl-C ends it early with complete logs.

    Args:
        job: what to run.
        console: where the bar is drawn; nothing is drawn unless it is a terminal.
        source: the job's source where it is open already.
        watchers: who is told of every frame beside the logs; see `fcw.job.run_drive`.
        stop: what Ctrl-C sets; an event of its own by default.
        rerun_log: whether a log for rerun is written as well.
    """
    drive = prepare_drive(job, source)
    count = drive.source.frame_count
    starting = progress(STARTING, count, console, "frames")
    with stop_on_interrupt(stop) as stop, starting as bar:

        def on_result(result: FrameResult) -> None:
            if result.index == 0:  # what came before is not part of the rate
                bar.begin(drive.source.name, count)
            bar.advance()

        sinks = (RerunSink(job.out / RRD_NAME),) if rerun_log else ()
        outcome = drive.run(sinks, watchers, stop, on_result)
    return replace(outcome, notes=(*outcome.notes, *_on_size(drive, rerun_log)))


def _on_size(drive: PreparedDrive, rerun_log: bool) -> tuple[str, ...]:
    """Why the log is much larger than the video that was run, where it is."""
    video, source = drive.job.source, drive.source
    why = source.coded_anew if isinstance(source, VideoLike) else ""
    if not why or not video.is_file():
        return ()
    times = (drive.job.out / MCAP_NAME).stat().st_size / max(video.stat().st_size, 1)
    if times < MUCH_LARGER:
        return ()
    logs = f"{MCAP_NAME} and {RRD_NAME} are each" if rerun_log else f"{MCAP_NAME} is"
    mend = "; --no-rerun-log leaves one of them out" if rerun_log else ""
    return (
        f"{logs} {times:.1f} times as large as {video.name}: the pictures are encoded again, because "
        f"{why}{mend}",
    )


@contextmanager
def stop_on_interrupt(event: threading.Event | None = None) -> Iterator[threading.Event]:
    """An event that the first Ctrl-C (or SIGTERM, or SIGHUP) sets; a second one interrupts at once."""
    stop = event or threading.Event()

    def on_signal(number: int, _stack: FrameType | None) -> None:
        if stop.is_set():
            raise Interrupted
        stop.set()

    with handled(on_signal):
        yield stop
