"""What a worker does: one drive from its file to its log, and its record at the end."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

from fcw.batch.drives import BatchDrive
from fcw.batch.identity import Identity
from fcw.batch.ledger import RECORD_NAME, RETRY_WORDS, Record, State, write_record
from fcw.batch.moments import write_moments
from fcw.batch.remote import fetched
from fcw.errors import UserError
from fcw.files import check_kind
from fcw.job import DriveJob, prepare_drive
from fcw.logs.drive_folder import FolderBusyError
from fcw.logs.events import WarningCounter
from fcw.logs.names import MCAP_NAME
from fcw.logs.records import FrameResult
from fcw.pieces import plan_pieces, run_in_pieces

TELL_EVERY_S = 1.0


@dataclass(frozen=True, slots=True)
class Task:
    """A drive for a worker.

    Attributes:
        drive: which.
        identity: what is run, and how.
        folder: where its log goes.
        piece_s: a long drive is searched in pieces of this length at the same time; None never.
    """

    drive: BatchDrive
    identity: Identity
    folder: Path
    piece_s: float | None = None

    def record(self, state: State, reason: str = "") -> Record:
        """What came of it."""
        drive, identity = self.drive, self.identity
        return Record(
            drive.name, str(drive.source), drive.camera, state, reason, identity.key, identity.content
        )


def run_task(
    task: Task,
    tell: Callable[[int, int | None, int], None] = lambda done, total, warnings: None,
    executor: Callable[[], AbstractContextManager[Executor]] | None = None,
) -> Record:
    """Run a drive to its end; what is wrong with it is in its record, and stops nobody else.

    A folder that another run writes to, as that of a batch that was killed a moment ago, is left alone.

    Args:
        task: which and how.
        tell: called about once a second with the frames done, how many there are if that is known, and the
            warnings by then.
        executor: makes one for the pieces of a long drive; None runs it whole, as one that was fetched is.
    """
    drive, options = task.drive, task.identity.options
    start_s = told_s = time.perf_counter()
    try:
        check_kind(task.folder / RECORD_NAME, "record of a batch", (b'"identity":',))
    except UserError as error:
        return task.record(State.FAILED, str(error))
    # An earlier run's record says nothing of the log that is written now.
    (task.folder / RECORD_NAME).unlink(missing_ok=True)
    try:
        with fetched(drive.source, drive.calibration, drive.track) as (source, calibration, track):
            assert source is not None
            job = DriveJob(
                source=source,
                out=task.folder,
                calibration=calibration,
                topic=drive.topic,
                ego_speed=None if track is None else str(track),
                detector=options.detector,
                model=options.model_file,
                warning_policy=options.warning_policy,
                warning_timing=options.warning_timing,
                own_motion=options.own_motion,
                detection_threads=0,
            )
            prepared = prepare_drive(job)
            total, warnings = prepared.source.frame_count, WarningCounter()

            def on_result(result: FrameResult) -> None:
                nonlocal told_s
                warnings.add(result.told_warning)
                if (now_s := time.perf_counter()) - told_s >= TELL_EVERY_S:
                    told_s = now_s
                    tell(result.index + 1, total, warnings.count)

            # What was fetched is on this machine alone.
            piece_s = task.piece_s if source is drive.source else None
            if executor and piece_s and len(plan_pieces(prepared.source, piece_s)) > 1:
                with executor() as pool:
                    outcome = run_in_pieces(
                        job, piece_s, pool, task.identity.key, prepared, on_result=on_result
                    )
            else:
                outcome = prepared.run(on_result=on_result)
            summary = outcome.summary
        events = write_moments(task.folder)
    except FolderBusyError as error:
        return task.record(State.LOST, f"{error}; run the batch again when that one has ended")
    except UserError as error:
        failed = task.record(State.FAILED, f"{error}{RETRY_WORDS}")
        try:
            write_record(failed, task.folder)
        except UserError:
            return task.record(State.FAILED, str(error))  # without a record the next batch runs it
        return failed
    done = replace(
        task.record(State.DONE),
        warning_policy=options.warning_policy,
        frames=summary["frames"],
        seconds=time.perf_counter() - start_s,
        duration_s=summary["duration_s"],
        events=events,
        warnings=sum(span["level"] == "warning" for span in summary["warnings"]),
        log_bytes=(task.folder / MCAP_NAME).stat().st_size,
        notes=tuple(summary["notes"]),
    )
    try:
        write_record(done, task.folder)
    except UserError as error:
        return task.record(State.LOST, f"{error}, and run the batch again")
    return done
