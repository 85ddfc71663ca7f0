"""`fcw batch`: many drives on many cores, one table of their events, and what came of each drive."""

import threading
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from fcw_viz.console_text import one_line
from fcw_viz.exit_codes import EXIT_INTERRUPTED, EXIT_WRONG_INPUT

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import TaskID
    from rich.table import Table

    from fcw.batch.identity import BatchOptions
    from fcw.batch.ledger import Record
    from fcw.batch.plan import Plan

SHOWN_RUNNING = 16
"""Drives under way that the live table has lines for."""
MOST_WORKERS = 512
"""On one machine."""


@dataclass(frozen=True, slots=True)
class BatchCommand:
    """Run many drives, one on each core, and collect their events in one table.

    Run the same command again to do only what is left: finished drives are recognised by content,
    calibration, model and options. A drive that fails does not stop the others. Exit code 2 means that
    some drives are not done; each is listed with the reason and what to do.
    """

    sources: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="SOURCE ...")]
    """Video and MCAP files, and folders, which are searched with all their subfolders; or URLs of these, such
    as s3://bucket/folder (needs `pip install 'fsspec[s3]'`), which each worker fetches."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Folder of the batch: a folder for each drive, events.parquet, drives.parquet and manifest.json."""
    join_files: bool = False
    """Take the videos of each folder as one drive: dash cameras begin a new file every few minutes."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE|TABLE.csv")] = None
    """For drives that have no calibration beside them and no calibration.yaml in their folder: one file for
    all, or a table with the columns camera (name of the drive's folder), calibration and, optionally,
    topic."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Image topic of MCAP files; needed for files with more than one, unless the table names it."""
    workers: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Number of processes on this computer. Default: one for each core."""
    scheduler: Annotated[str | None, tyro.conf.arg(metavar="tcp://HOST:PORT")] = None
    """Address of a running Dask scheduler. Its workers must see the same files under the same paths."""
    piece_minutes: Annotated[float, tyro.conf.arg(metavar="MINUTES")] = 2.0
    """With fewer than two drives for each worker, a drive of more than one and a half times this length is
    searched for vehicles in pieces of this length, in parallel. The results are the same; 0 turns this
    off."""
    retry: bool = False
    """Run only the drives that failed."""
    detector: Annotated[str, tyro.conf.arg(metavar="net|acf|acf-full|onnx:FILE")] = "net"
    """As for `fcw run`."""
    model: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """As for `fcw run`. With --scheduler the workers must see it."""
    warning_policy: Annotated[str, tyro.conf.arg(metavar="NAME")] = "timely-braking"
    """As for `fcw run`."""
    warning_timing: Literal["early", "normal", "late"] = "normal"
    """As for `fcw run`."""
    no_own_motion: bool = False
    """As for `fcw run`."""
    json: bool = False
    """Print the result of each drive as JSON, and nothing else on stdout."""


def run_batch(command: BatchCommand) -> int:
    """Run `fcw batch`; returns the exit code.

    Raises:
        UserError: an option is wrong, or the batch's folder or a table cannot be written.
    """
    from fcw.batch.drives import find_batch_drives
    from fcw.batch.ledger import Ledger, State
    from fcw.batch.plan import plan_batch
    from fcw.batch.tables import check_batch_folder, write_tables
    from fcw_viz.console import MESSAGES, progress

    _check(command)
    options = _options(command)
    # The workers of a scheduler have working folders of their own.
    out, calibration = command.out.absolute(), command.calibration and command.calibration.absolute()
    check_batch_folder(out)
    drives = find_batch_drives(command.sources, calibration, command.topic, command.join_files)
    ledger = Ledger(out)
    with progress("looking at the drives", len(drives), MESSAGES) as bar:
        plan = plan_batch(
            drives, options, ledger, command.retry, bar.advance, command.piece_minutes * 60 or None
        )
    ledger.note_places(plan.records)
    records = {record.name: record for record in plan.records}
    records |= {task.drive.name: task.record(State.LOST, "the batch was stopped") for task in plan.tasks}
    interrupted = False
    try:
        with closing(_run(command, plan)) as done:
            for record in done:
                records[record.name] = record
    except KeyboardInterrupt:
        interrupted = True
    finally:
        ledger.write_manifest((ledger.finished | records).values(), plan.identities)
    events, unreadable = write_tables(out, (ledger.finished | records).values())
    if unreadable:
        records |= {record.name: record for record in unreadable}
        ledger.write_manifest((ledger.finished | records).values(), plan.identities)
    ordered = [records[name] for name in sorted(records)]
    _report(command, ordered, events, earlier=len(ledger.finished.keys() - records))
    if interrupted:
        return EXIT_INTERRUPTED
    return 0 if all(record.state in (State.DONE, State.DUPLICATE) for record in ordered) else EXIT_WRONG_INPUT


def _check(command: BatchCommand) -> None:
    """See that the options make sense: what is wrong is said once, and not by each drive."""
    from fcw.detection.choice import load_model
    from fcw.errors import UserError
    from fcw.warning.policies import make_policy

    if not command.sources:
        raise UserError("fcw batch: no drive given; name videos, MCAP files, or folders of them")
    if command.workers is not None and (
        not 1 <= command.workers <= MOST_WORKERS or command.scheduler is not None
    ):
        raise UserError(
            f"--workers {command.workers}: expected at least 1 and at most {MOST_WORKERS}, and not with "
            "--scheduler, which has its own"
        )
    if not command.piece_minutes >= 0:
        raise UserError(f"--piece-minutes {command.piece_minutes:g}: expected 0 or more")
    load_model(command.detector, path=command.model)
    make_policy(command.warning_policy, command.warning_timing)


def _options(command: BatchCommand) -> "BatchOptions":
    """How all drives are run; paths are whole, for workers elsewhere."""
    from fcw.batch.identity import BatchOptions
    from fcw.detection.choice import ONNX_PREFIX, model_path

    model = model_path(command.detector, command.model).absolute()
    return BatchOptions(
        f"{ONNX_PREFIX}{model}" if command.detector.startswith(ONNX_PREFIX) else command.detector,
        command.warning_policy,
        command.warning_timing,
        not command.no_own_motion,
        str(model) if command.model is not None else "",
    )


def _run(command: BatchCommand, plan: "Plan") -> Generator["Record", None, None]:
    """Run what is left, with a table of it on a terminal; what came of each drive, as soon as it is known."""
    from fcw.batch.cluster import connected, run_tasks
    from fcw_viz.console import MESSAGES

    if not plan.tasks:
        return
    with connected(command.scheduler, command.workers) as client:
        if client.cluster is not None and client.cluster.scheduler is not None:
            from fcw_viz.page.guard.dashboard import guard_dashboard

            guard_dashboard(client.cluster.scheduler.http_application)
        if client.dashboard_link:
            MESSAGES.print(f"Dask's dashboard: {client.dashboard_link}")
        with _live_table(len(plan.tasks), MESSAGES) as shown:
            for record in run_tasks(client, plan.tasks, shown.advance):
                yield record
                shown.finish(record)


def _report(command: BatchCommand, records: Sequence["Record"], events: int, earlier: int) -> None:
    """Print what came of each drive, and where to look; `earlier` drives are of other batches."""
    from fcw.batch.fleet import FLEET_NAME
    from fcw.batch.ledger import State, as_json
    from fcw.batch.tables import EVENTS_NAME
    from fcw_viz.console import RESULTS, print_json

    if command.json:
        print_json([as_json(record) for record in records])
        return
    RESULTS.print(_result_table(records))
    for record in records:
        if record.reason:  # whole lines, for commands and paths are there to be copied
            RESULTS.print(one_line(f"{record.name}: {record.reason}"), soft_wrap=True, markup=False)
        for note in record.notes:
            RESULTS.print(one_line(f"{record.name}: note: {note}"), soft_wrap=True, markup=False)
    done = sum(record.state is State.DONE for record in records)
    also = f" and {earlier} of earlier batches" if earlier else ""
    for line in (
        f"{done} of {len(records)} drives done{also}, {events} event{'s' * (events != 1)} "
        f"in {command.out / EVENTS_NAME}",
        f"look at them: {command.out / FLEET_NAME}; review them: fcw review {quote(str(command.out))}",
    ):
        RESULTS.print(one_line(line), soft_wrap=True, markup=False)


class _Shown:
    """The table of drives under way, drawn anew as they tell of themselves."""

    def __init__(self, count: int, console: "Console") -> None:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeRemainingColumn,
        )

        self._lock = threading.Lock()
        self._console = console
        name = TextColumn("{task.description}", markup=False)
        self.bars = Progress(
            name,
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("{task.fields[warnings]}"),
            TimeRemainingColumn(),
            console=console,
            disable=console.quiet or not console.is_terminal,
            transient=True,
        )
        self._all = self.bars.add_task("drives", total=count, rate="", warnings="")
        self._tasks: dict[str, TaskID] = {}

    def advance(self, name: str, done: int, total: int | None, warnings: int) -> None:
        """A drive is so far."""
        with self._lock:
            if name not in self._tasks and len(self._tasks) < SHOWN_RUNNING:
                self._tasks[name] = self.bars.add_task(
                    one_line(name), total=total, rate="starting", warnings=""
                )
            if name in self._tasks:
                task = self._tasks[name]
                speed = self.bars.tasks[self.bars.task_ids.index(task)].speed
                rate = f"{speed:.0f} frames/s" if speed else ""
                words = _warnings_text(warnings) if done else ""
                self.bars.update(task, completed=done, total=total, rate=rate, warnings=words)

    def finish(self, record: "Record") -> None:
        """A drive is at its end."""
        with self._lock:
            if record.name in self._tasks:
                self.bars.remove_task(self._tasks.pop(record.name))
            self.bars.advance(self._all)
        text = f"{record.name}: {record.state.value}"
        if record.frames:
            text += f", {record.frames_per_second:.0f} frames/s, {_warnings_text(record.warnings)}"
        self._console.print(one_line(text + (f": {record.reason}" if record.reason else "")))


def _warnings_text(count: int) -> str:
    return f"{count} warning{'s' * (count != 1)}"


@contextmanager
def _live_table(count: int, console: "Console") -> Iterator[_Shown]:
    shown = _Shown(count, console)
    with shown.bars:
        yield shown


def _result_table(records: Sequence["Record"]) -> "Table":
    from rich.table import Table
    from rich.text import Text

    table = Table("drive", "state", "frames/s", "warnings", box=None)
    for record in records:
        rate = f"{record.frames_per_second:.0f}" if record.frames else ""
        warnings = str(record.warnings) if record.frames else ""
        table.add_row(*map(Text, (one_line(record.name), record.state.value, rate, warnings)))
    return table
