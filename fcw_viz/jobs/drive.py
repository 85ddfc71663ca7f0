"""A drive's job on the console, as `fcw run` and `fcw demo` do it: with the rerun log, a bar and Ctrl-C."""

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from fcw.frame import Source
from fcw.job import DriveJob, DriveOutcome, prepare_drive
from fcw.logs.names import RRD_NAME
from fcw.logs.records import Sink
from fcw_viz.rerun.log import RerunSink


def run_on_console(
    job: DriveJob,
    console: Console,
    source: Source | None = None,
    watchers: Sequence[Sink] = (),
    stop: threading.Event | None = None,
) -> DriveOutcome:
    """Run a job with a progress bar on `console`; Ctrl-C ends it early with complete logs.

    Args:
        job: what to run; a log for rerun is written as well.
        console: where the bar is drawn; nothing is drawn unless it is a terminal.
        source: the job's source where it is open already.
        watchers: who is told of every frame beside the logs; see `fcw.job.run_drive`.
        stop: what Ctrl-C sets; an event of its own by default.
    """
    drive = prepare_drive(job, source)
    with stop_on_interrupt(stop) as stop, _progress(console, drive.source) as advance:
        return drive.run((RerunSink(job.out / RRD_NAME),), watchers, stop, lambda result: advance())


@contextmanager
def stop_on_interrupt(event: threading.Event | None = None) -> Iterator[threading.Event]:
    """An event that the first Ctrl-C (or SIGTERM) sets; a second one interrupts at once."""
    stop = event or threading.Event()

    def on_signal(number: int, _stack: FrameType | None) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _progress(console: Console, source: Source) -> Iterator[Callable[[], None]]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]:.0f} frames/s"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        starting = "starting (the first time kernels are compiled)"
        task = progress.add_task(starting, total=source.frame_count, rate=0.0)
        start, frames = time.perf_counter(), 0

        def advance() -> None:
            nonlocal frames
            frames += 1
            rate = frames / (time.perf_counter() - start)
            progress.update(task, description=source.name, advance=1, rate=rate)

        yield advance
