"""What a batch has to do: which drives are done, which cannot be run, and which are left."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from fcw.batch.drives import BatchDrive
from fcw.batch.identity import BatchOptions, Identity, identity_of
from fcw.batch.ledger import Ledger, Record, State
from fcw.batch.remote import StoreError
from fcw.batch.work import Task


@dataclass(frozen=True, slots=True)
class Plan:
    """A batch before it runs.

    Attributes:
        tasks: drives to run.
        records: of all others, by what came of them earlier, or why they are not run.
        identities: by the name of the drive, where it has one.
    """

    tasks: tuple[Task, ...]
    records: tuple[Record, ...]
    identities: dict[str, Identity]


def plan_batch(
    drives: Sequence[BatchDrive],
    options: BatchOptions,
    ledger: Ledger,
    retry: bool = False,
    on_drive: Callable[[], None] = lambda: None,
    piece_s: float | None = None,
) -> Plan:
    """Look at every drive once.

    Args:
        drives: all there are.
        options: how they are run.
        ledger: of the batch's folder.
        retry: run those alone that failed.
        on_drive: called after each drive.
        piece_s: see `Task`; results do not depend on it.

    Raises:
        UserError: there is no such detector.
    """
    tasks: list[Task] = []
    records: list[Record] = []
    identities: dict[str, Identity] = {}
    seen: dict[str, str] = {}
    to_run: list[tuple[BatchDrive, Identity]] = []
    for drive in drives:
        record = _without_running(drive)
        try:
            if record is None:
                identity = identity_of(drive.source, drive.calibration, options)
                first = seen.setdefault(identity.key, drive.name)
                known = ledger.known(identity)
                if first != drive.name:
                    record = _record(drive, State.DUPLICATE, f"the same file and calibration as {first}")
                elif known is not None and (known.state is State.DONE or not retry):
                    record = _known(known, drive)
                elif retry and known is None:
                    record = _record(drive, State.LOST, "not run yet, and --retry runs only what failed")
                else:
                    to_run.append((drive, identity))
                identities[drive.name if record is None else record.name] = identity
        except OSError as error:
            record = _record(
                drive, State.FAILED, f"{drive.source}: cannot be read ({error.strerror}); check the file"
            )
        except StoreError as error:
            record = _record(drive, State.FAILED, str(error))
        if record is not None:
            records.append(record)
        on_drive()
    taken = {record.name for record in records if record.state is State.DONE}
    for drive, identity in to_run:
        name = drive.name
        if name in taken:  # by a drive that had this name then, and has another one now
            name = f"{name}-{identity.key[:8]}"
            identities[name] = identity
        named = replace(drive, name=name)
        tasks.append(Task(named, identity.key, options, ledger.folder(name), piece_s))
    return Plan(tuple(tasks), tuple(records), identities)


def _without_running(drive: BatchDrive) -> Record | None:
    if drive.is_calibrated:
        return None
    return _record(
        drive,
        State.UNCALIBRATED,
        f"make one with `fcw calibrate {drive.source}` (a rough one, from the drive alone: --from-clip), or "
        "name one for all with --calibration",
    )


def _known(known: Record, drive: BatchDrive) -> Record:
    """An earlier record, of the file where it lies now."""
    again = "" if known.state is State.DONE else "; mended, run it again with --retry"
    reason = known.reason if known.reason.endswith(again) else known.reason + again
    return replace(known, source=str(drive.source), camera=drive.camera, reason=reason)


def _record(drive: BatchDrive, state: State, reason: str) -> Record:
    return Record(drive.name, str(drive.source), drive.camera, state, reason)
